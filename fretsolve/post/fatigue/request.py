"""Say which fatigue parameters to compute, and check before that material, average and cycle allow it.

Stresses are averaged over a length L before a parameter is taken (theory of critical distances, Taylor 1999): at depth
L/2 (point), over depths from 0 to 2 L (line), or over a cube of side L below the surface, centred on the point
(volume). Between stored depths stress is linear. A cell's value holds over the cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import correlate1d

from fretsolve.case.keys.output_spec import AverageKind
from fretsolve.case.keys.quantity_names import SLIP_CRITERIA
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, KeyPath
from fretsolve.post.fatigue.material import MaterialSource, placed
from fretsolve.post.fatigue.ruiz import require_slip
from fretsolve.post.stress.cycles import (
    CycleChoice,
    LoadCycle,
    chosen,
    cycles_of,
    load_cycles,
    require_states,
    states_of,
)
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.request import (
    StressRequest,
    WindowChoice,
    least_depth,
    request_before,
    room_problem,
    stress_request,
)
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.system.arrays import DoubleArray

GAP = 0.3
"""Largest distance of stored depths over the averaging length; depths from a result are closer."""


@dataclass(frozen=True)
class Average:
    """An average over a length L (mm)."""

    kind: AverageKind
    length: float

    @property
    def depth_range(self) -> tuple[float, float]:
        """First and last depth over which stress is averaged (mm)."""
        if self.kind == "point":
            return 0.5 * self.length, 0.5 * self.length
        return 0.0, self.length * (2.0 if self.kind == "line" else 1.0)

    def require_length(self, cell: tuple[float, float]) -> None:
        """Raise CaseError if L is below a cell."""
        largest = max(cell)
        if not self.length >= largest:
            raise CaseError(
                f"the averaging length {self.length:g} mm is below a cell; {largest:.4g} mm or more is needed"
            )

    def require_resolved(self, depths: DoubleArray, cell: tuple[float, float]) -> None:
        """Raise CaseError if L is below a cell, or the stored depths do not hold the range."""
        self.require_length(cell)
        first, last = self.depth_range
        rounding = 1e-9 * last
        if first < depths[0] - rounding or last > depths[-1] + rounding:
            raise CaseError(
                f"the average needs depths from {first:g} to {last:g} mm, the stresses reach from {depths[0]:g} to"
                f" {depths[-1]:g} mm; `fretsolve stress --depth` computes others"
            )

    def gap_problem(self, depths: DoubleArray, cell: tuple[float, float]) -> str | None:
        """Return a warning if stored depths are far apart where stress is averaged, None if they are not."""
        first, last = self.depth_range
        inside = depths[(depths >= first - 1e-9 * last) & (depths <= last * (1.0 + 1e-9))]
        if first == last:
            gap = 0.0 if len(inside) else float(np.diff(depths[np.searchsorted(depths, first) - 1 :][:2])[0])
        else:
            gap = float(np.diff(np.unique(np.concatenate([[first], inside, [last]]))).max())
        if gap <= max(GAP * self.length, *cell):
            return None
        return (
            f"stresses are stored at depths {gap:.3g} mm apart and taken as linear between, which is far against the"
            f" averaging length {self.length:g} mm; more --depth in `fretsolve stress`, or the result itself, is better"
        )

    def of(self, stress: DoubleArray, weights: DoubleArray, cell: tuple[float, float]) -> DoubleArray:
        """Return the averages (..., nx, ny) of stresses (..., depths, nx, ny); weights: `depth_weights` of its range.

        In a volume, the window beyond the edge of the cells goes on as their last one.
        """
        below: DoubleArray = np.einsum("...dxy,d->...xy", stress, weights)
        if self.kind != "volume":
            return below
        for axis, side in ((-2, cell[0]), (-1, cell[1])):
            if below.shape[axis] > 1:
                below = correlate1d(below, box_weights(self.length / side), axis=axis, mode="nearest")
        return below


def depth_weights(depths: DoubleArray, first: float, last: float) -> DoubleArray:
    """Return weights (depths,) of the mean between two depths of what is linear between `depths`; a value if equal."""
    if last <= first:
        # The hat function of each depth is 1 there and 0 at the others.
        return np.asarray([float(np.interp(first, depths, hat)) for hat in np.eye(len(depths))])
    inside = depths[(depths > first) & (depths < last)]
    nodes = np.concatenate([[first], inside, [last]])
    hats = np.array([np.interp(nodes, depths, hat) for hat in np.eye(len(depths))])
    return np.asarray(0.5 * (hats[:, 1:] + hats[:, :-1]) @ np.diff(nodes) / (last - first))


def box_weights(cells: float) -> DoubleArray:
    """Return the weights of cells in a window `cells` cells wide around the middle one; they add up to 1."""
    beside = max(0, int(np.ceil(0.5 * (cells - 1.0))))
    weights = np.ones(2 * beside + 1)
    if beside:
        weights[0] = weights[-1] = 0.5 * (cells - (2 * beside - 1))
    return np.asarray(weights / weights.sum())


SMALLER = "fewer depths or bodies, or more room, is needed"
"""What makes the stresses of a cycle smaller, or lets them be as large as they are."""

AVERAGE_DEPTHS = 17
"""Depths that are computed for an average, graded towards the surface, where stresses change most."""


KEY = ("output", "fatigue")


@dataclass(frozen=True)
class FatigueRequest:
    """Fatigue parameters to compute.

    criteria: their names; average: of the stresses, None for none. bodies: none for the bodies in a file of stresses,
    or for body 2 of a result, or 1 if that is rigid; depths (mm): none for graded ones. window: the cells of a result,
    as in `stress_request`; cycles: that count.
    """

    material: MaterialSource
    criteria: tuple[str, ...]
    average: Average | None = None
    bodies: tuple[Body, ...] = ()
    depths: tuple[float, ...] = ()
    window: WindowChoice = "auto"
    cycles: CycleChoice = "last"

    @property
    def slip_criteria(self) -> tuple[str, ...]:
        """The criteria that need slip."""
        return tuple(name for name in self.criteria if name in SLIP_CRITERIA)

    def require_surface(self) -> None:
        """Raise CaseError if a criterion of the surface is asked for where there is none."""
        for name in self.slip_criteria:
            if self.average is not None:
                raise CaseError(f"{name} is a parameter of the surface, no average over depths; leave the average out")
            if self.depths and 0.0 not in self.depths:
                raise CaseError(f"{name} is a parameter of the surface; 0 mm is needed among the depths")

    def stress_depths(self, least: float) -> tuple[float, ...]:
        """Return the depths at which stresses are computed; least: the first depth below the surface (mm)."""
        if self.average is None:
            return self.depths
        first, last = self.average.depth_range
        if first == last:
            return (last,)
        graded = (last * (k / (AVERAGE_DEPTHS - 1)) ** 2 for k in range(AVERAGE_DEPTHS))
        return tuple(depth for depth in graded if depth in (first, last) or depth >= least)


def case_request(case: Case) -> FatigueRequest:
    """Return what a case with `output.fatigue` asks for."""
    spec = case.output.fatigue
    assert spec is not None
    return FatigueRequest(
        MaterialSource(spec.material, case.source, (*KEY, "material")),
        spec.criteria,
        None if spec.average is None else Average(spec.average.kind, spec.average.length),
        spec.bodies,
        spec.depths,
        cycles=spec.chosen,
    )


def require_fatigue(setup: ProblemSetup, free_disk: int | None = None) -> None:
    """Raise CaseError, before the run, if the fatigue parameters of a case could not be computed after it.

    free_disk: bytes for the stresses of the cycle, None where that is unknown.
    """
    case, grid = setup.case, setup.grid
    request = case_request(case)
    for number, body in enumerate(case.bodies, start=1):
        chosen = number in request.bodies if request.bodies else number == (1 if case.bodies[1] == "rigid" else 2)
        if chosen and body != "rigid":
            request.material.with_elastic_constants(body.model_dump()).require(request.criteria)
    with placed(lambda message: case.source.problem(message, (*KEY, "criteria"))):
        request.require_surface()
        if request.slip_criteria and "slip" not in case.output.fields:
            raise CaseError(f"{request.slip_criteria[0]} needs slip, which output.fields leaves out")
    if request.average is not None:
        with placed(lambda message: case.source.problem(message, (*KEY, "average"))):
            request.average.require_length((grid.dx, grid.dx if setup.model.line else grid.dy))
    with placed(lambda message: case.source.problem(message, (*KEY, "cycle"))):
        stored, cycles = cycles_before(setup, request.cycles)
    with placed(lambda message: case.source.problem(message, states_key(case))):
        for cycle in cycles:
            require_states(cycle, stored)
    states = len(states_of(cycles, stored))
    depths = request.stress_depths(0.5 * max(grid.dx, grid.dy))
    problem = room_problem(request_before(request.bodies, depths, states, grid.shape), free_disk, SMALLER)
    if problem is not None:
        raise case.source.problem(problem, KEY)


@dataclass(frozen=True, eq=False)
class ComputedTractions:
    """The tractions from which stresses were computed, and which stresses."""

    history: TractionHistory
    stresses: StressRequest


def stresses_of_cycles(tractions: TractionHistory, request: FatigueRequest) -> ComputedTractions:
    """Return the stresses of the chosen cycles that a request takes, with their tractions.

    Raises CaseError, before anything is computed, also for what is wrong with material and average.
    """
    result = tractions.result
    with placed(lambda message: CaseError(message, (), result.path)):
        cycles = chosen(cycles_of(result), request.cycles)
        for cycle in cycles:
            require_states(cycle, result.steps)
        if request.average is not None:
            request.average.require_length((tractions.grid.dx, tractions.grid.dy))
        request.require_surface()
    if request.slip_criteria:
        require_slip(tractions)
    depths = request.stress_depths(least_depth(tractions))
    steps = states_of(cycles, result.steps)
    found = stress_request(tractions, steps, request.bodies, depths, window=request.window)
    for body in found.bodies:
        elastic = result.effective_case["bodies"][body - 1]
        request.material.with_elastic_constants(elastic).require(request.criteria)
    return ComputedTractions(tractions, found)


def states_key(case: Case) -> KeyPath:
    """Return the key that decides how many states have fields: output.every where it leaves some out."""
    return ("output", "every") if case.output.every > 1 else ("load_path",)


def cycles_before(setup: ProblemSetup, choice: CycleChoice) -> tuple[frozenset[int], tuple[LoadCycle, ...]]:
    """Return the increments with fields of the load path of a case, and the chosen cycles. Raises CaseError."""
    path, every = setup.load_path, setup.case.output.every
    stored = frozenset((*range(every - 1, path.increments, every), path.increments - 1))
    counts = np.diff([-1, *path.last_steps])
    return stored, chosen(load_cycles(path.stages, np.repeat(np.arange(1, len(counts) + 1), counts)), choice)
