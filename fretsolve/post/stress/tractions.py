"""Tractions, bulk stresses, elastic bodies and cycles of a result, as the stress below its surface needs them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.case.keys.load_path_spec import AmplitudeCycle, CycleSpec
from fretsolve.case.keys.unrolled_path import stage_count
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.post.stress.influence import TRACTIONS, Body, Traction
from fretsolve.post.stress.layers import Window
from fretsolve.problem.model.grid import Grid
from fretsolve.result import Result
from fretsolve.result.state import stage_ends
from fretsolve.system.arrays import BoolArray, DoubleArray

BODIES: tuple[Body, Body] = (1, 2)


@dataclass(frozen=True, eq=False)
class TractionHistory:
    """Reads the tractions of a result one increment at a time.

    Raises CaseError if the result lacks what the stress follows from.
    """

    result: Result

    def __post_init__(self) -> None:
        result = self.result
        if not result.increments:
            raise CaseError(result.why_empty, (), result.path)
        if len(result.x) < 2 or (len(result.y) < 2 and not self.plane_strain):
            raise CaseError("the grid has only one cell across, which is too few for stresses", (), result.path)
        missing = "pressure" not in result.fields or (self.has_shear and "shear_x" not in result.fields)
        if missing:
            message = "the result does not hold pressure and shear, from which stresses follow"
            raise CaseError(f"{message}; output.fields in the case chooses them", (), result.path)

    @cached_property
    def grid(self) -> Grid:
        """The grid of the result."""
        x, y = self.result.x, self.result.y
        if self.plane_strain:
            dx = float(x[-1] - x[0]) / (len(x) - 1)
            return Grid(len(x), 1, dx, dx, float(x[0] + x[-1]) / 2)
        dx, dy = (float(axis[-1] - axis[0]) / (len(axis) - 1) for axis in (x, y))
        return Grid(len(x), len(y), dx, dy, float(x[0] + x[-1]) / 2, float(y[0] + y[-1]) / 2)

    @cached_property
    def plane_strain(self) -> bool:
        """True for a line contact, whose cells are strips in one row."""
        return bool(self.result.effective_case.get("plane") == "strain")

    @cached_property
    def has_sharp_edges(self) -> bool:
        """True if a surface is a punch without edge radius or a cone, at whose edge or tip stress has no bound."""
        surfaces = self.result.effective_case.get("surface", ())
        found = [(kind, keys) for one in surfaces for kind, keys in one.items()]
        return any(kind == "cone" or (kind == "punch" and not keys.get("edge_radius")) for kind, keys in found)

    @cached_property
    def has_shear(self) -> bool:
        """True if any increment has shear."""
        return bool(np.any(self.result.history["max_shear"]))

    @cached_property
    def poisson_ratios(self) -> dict[Body, float]:
        """Poisson's ratio of each elastic body."""
        bodies = self.result.effective_case.get("bodies", ())
        elastic = zip(BODIES, bodies, strict=False)
        return {number: float(body["poisson_ratio"]) for number, body in elastic if isinstance(body, dict)}

    def pressure(self, step: int) -> DoubleArray:
        """Return the pressure of an increment, ``(nx, ny)``."""
        return np.asarray(self.result.field("pressure", step), np.float64)

    def read(self, step: int, window: Window, tractions: Sequence[Traction] = TRACTIONS) -> dict[Traction, DoubleArray]:
        """Return tractions of an increment in the cells of `window`."""
        names: dict[Traction, str] = {"p": "pressure", "qx": "shear_x", "qy": "shear_y"}
        zeros = np.zeros(self.grid.shape)[window]
        return {
            one: np.asarray(self.result.field(names[one], step), np.float64)[window]
            if one == "p" or self.has_shear
            else zeros
            for one in tractions
        }

    def bulk_stress(self, body: Body, step: int) -> DoubleArray:
        """Return the bulk stress xx, yy, xy (MPa) of a body at an increment, (3,); in plane strain yy = nu xx."""
        history = self.result.history
        bulk = np.array([float(history[name][step]) if name in history else 0.0 for name in BULK[body]])
        if self.plane_strain:
            bulk[1] = self.poisson_ratios[body] * bulk[0]
        return bulk

    def extent(self, steps: Sequence[int]) -> tuple[Window, tuple[Traction, ...]]:
        """Return the cells that any of the increments loads, and the tractions that are not 0 in all of them."""
        loaded: BoolArray = np.zeros(self.grid.shape, bool)
        kept = {"p"}
        for step in steps:
            fields = self.read(step, (slice(None), slice(None)))
            for name, field in fields.items():
                if np.any(field):
                    loaded |= field != 0.0
                    kept.add(name)
        return bounding_window(loaded), tuple(name for name in TRACTIONS if name in kept)


def bounding_window(cells: BoolArray) -> Window:
    """Return the smallest window with all `cells`; the middle cell if there is none."""
    slices = []
    for axis in (0, 1):
        found = np.flatnonzero(cells.any(axis=1 - axis))
        middle = cells.shape[axis] // 2
        slices.append(slice(int(found[0]), int(found[-1]) + 1) if len(found) else slice(middle, middle + 1))
    return slices[0], slices[1]


def cycle_stages(case: Case | None, reached: int) -> tuple[int, int] | None:
    """Return the stages, from after the first to the second one, of the last whole `cycle` up to stage `reached`.

    None if there is none.
    """
    found: tuple[int, int] | None = None
    before = 0
    for step in case.load_path if case is not None else ():
        count = stage_count((step,))
        if isinstance(step, CycleSpec):
            first = int(isinstance(step.cycle, AmplitudeCycle))  # the way to the first end
            length, worn = (count - first) // step.cycle.most, 0
            if step.cycle.jumps is not None:  # the surfaces change in a stage after each repetition
                length, worn = (2 if isinstance(step.cycle, AmplitudeCycle) else stage_count(step.cycle.stages)) + 1, 1
            whole = min((count - first) // length, (reached - before - first + worn) // length)
            if whole > 0:
                found = before + first + (whole - 1) * length, before + first + whole * length - worn
        before += count
    return found


def last_cycle(result: Result) -> tuple[int, ...]:
    """Return the increments with fields of the last `cycle` that the result holds whole, and the increment before.

    Raises CaseError if there is none.
    """
    first, last = _cycle_of(result)
    stage = result.history["stage"]
    inside = (stage > first) & (stage <= last)
    before = int(inside.argmax()) - 1
    return tuple(step for step in result.steps if inside[step] or step == before)


def cycle_ends(result: Result) -> tuple[int, ...]:
    """Return the increments at which the stages of the last cycle begin and end. Raises CaseError if there is none."""
    first, last = _cycle_of(result)
    stages = result.history["stage"]
    ends = {int(stages[end]): int(end) for end in stage_ends(stages)}  # cycles that end by themselves leave stages out
    return tuple(ends[stage] for stage in range(max(first, 1), last + 1) if stage in ends)


def _cycle_of(result: Result) -> tuple[int, int]:
    """Return the stages of the last cycle that the result holds whole, from after the first to the second one."""
    reached = int(result.history["stage"][-1]) if result.increments else 0
    if result.status != "complete":
        reached -= 1  # the last stage may not have ended
    found = cycle_stages(result.case, reached)
    if found is None:
        raise CaseError("the load path has no cycle that the result holds", (), result.path)
    return found
