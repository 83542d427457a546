"""Error bars: how far a run's values may lie from those of the continuum, estimated from coarser companion runs.

Three errors are added as independent ones. That of the cells is the difference to a companion on half of the points
per side, by Richardson's extrapolation, and no less than a small part of the cells' own scale, since the errors of both
runs may agree by chance. That of the increments is the difference between two companions, of which one has half of
the increments. That of the iteration is the certificate's worst residual. ``benchmarks/calibrate_error_bars.py``
calibrates the constants; docs/error_bars.md has the outcome.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.load_components import PAIRS
from fretsolve.result.state import ERROR_SUFFIX, SummaryErrors
from fretsolve.simulation.coarse_runs import (
    ESTIMATED,
    Companion,
    coarser,
    fewer_increments,
    nodes,
    values_of,
)
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result.state import State, Summary
    from fretsolve.setup.problem_setup import ProblemSetup

ORDER, SURER_ORDERS = 0.8, {"contact_radius": 1.0, "work": 1.0, "work_total": 1.0}
"""Orders of the discretisation that are taken for granted. Sequences of grids show 1.3 to 2, but with fluctuations, as
the edges cut the cells now so, now so; the radius of contact and the work need somewhat less safety."""

INCREMENTS_SAFETY = 2.0
"""On the difference that is the increments' error to first order; the order found is somewhat less than 1."""

FLOOR, FLOOR_ORDER = 0.1, 2.0
FLOOR_WORK, FLOOR_ORDER_WORK = 0.2, 1.5
"""The least error of the cells in parts of the largest value so far, FLOOR (h/a)^FLOOR_ORDER with h their side and a
the radius of contact; of the work in parts of itself."""

FLOOR_RADII = {"contact_radius": 0.003, "stick_radius": 0.02}
"""The same of radii, in units of h."""

NEARLY_SLIDING = 0.15
"""Stick over contact radius below which increments count also where pressure and shear do not act on each other: the
shear turns as the last of it slips, where Poisson's ratio links the directions."""

UNSEEN = 0.5
"""Radius of a stick zone that may be there, in units of h, where no cell sticks."""


def run_with_error_bars(
    setup: ProblemSetup,
    start: State | None = None,
    history: Sequence[Summary] = (),
    threads: int = 1,
    tell: Callable[[str], object] | None = None,
) -> Iterator[tuple[State, SummaryErrors]]:
    """As `fretsolve.run`, each state with its error bars.

    A companion that finds no solution where the run itself has one leaves NaN from there on, of which `tell` is told
    in one line. Raises NoSolutionError where the run has none.
    """
    bars = ErrorBars(setup, history, threads)
    told = False
    for state in run(setup, start, history, threads):
        errors = bars.of(state.summary)
        if bars.failure is not None and tell is not None and not told:
            tell(f"no error bars from increment {state.summary.step} on: {bars.failure}")
            told = True
        yield state, errors


class ErrorBars:
    """The error bars of a scene, row after row; `history`: the rows that are there already.

    failure: why a companion goes no farther, None while all do.
    """

    def __init__(self, setup: ProblemSetup, history: Sequence[Summary] = (), threads: int = 1):
        self._setup = setup
        counts = setup.load_path.counts
        self._threads = threads
        self._coarse = Companion(coarser(setup, counts), threads)
        self._stepped: Companion | None = None
        if setup.load_path.path_dependent:
            self._follow_steps()
        orders = np.array([SURER_ORDERS.get(name, ORDER) for name in ESTIMATED])
        points, coarse_points = (math.prod(one.grid.shape) for one in (setup, self._coarse.setup))
        self._richardson = 1.0 / (math.sqrt(points / coarse_points) ** orders - 1.0)
        self._rows: list[Summary] = []
        self._largest = np.zeros(len(ESTIMATED))
        for summary in history:
            self._take(summary)
        if history:
            self._increments(history[-1].step)  # what companions did for rows that are there is no cost of the next one
            self._coarse.values(history[-1].step)

    @property
    def failure(self) -> str | None:
        """Why a companion goes no farther, in one line."""
        for companion in self._companions:
            if companion.failure is not None:
                nx, ny = companion.setup.grid.shape
                return f"the companion run on {nx} x {ny} cells has no solution: {companion.failure.message}"
        return None

    def of(self, summary: Summary) -> SummaryErrors:
        """The error bars of the row that follows those so far."""
        applications, seconds = self._applications, self._seconds
        self._take(summary)
        cells, increments = self._cells(summary), self._increments(summary.step)
        errors = np.sqrt(cells**2 + increments**2 + self._iteration(summary) ** 2)
        return SummaryErrors(
            **{name + ERROR_SUFFIX: float(error) for name, error in zip(ESTIMATED, errors, strict=True)},
            companion_applications=self._applications - applications,
            companion_wall_time=self._seconds - seconds,
        )

    def _follow_steps(self) -> None:
        counts = fewer_increments(self._setup.load_path.counts)
        self._stepped = Companion(coarser(self._setup, counts), self._threads)

    def _take(self, summary: Summary) -> None:
        nearly_slides = summary.stick_radius < NEARLY_SLIDING * summary.contact_radius
        if self._stepped is None and self._setup.model.terms.in_plane_coupling and nearly_slides:
            self._follow_steps()
        self._rows.append(summary)
        self._largest = np.maximum(self._largest, np.abs(values_of(summary)))

    @property
    def _companions(self) -> list[Companion]:
        return [self._coarse, *([] if self._stepped is None else [self._stepped])]

    @property
    def _applications(self) -> float:
        """Those of the companions so far, in parts of one on the scene's grid."""
        share = math.prod(self._coarse.setup.grid.shape) / math.prod(self._setup.grid.shape)
        return share * sum(companion.applications for companion in self._companions)

    @property
    def _seconds(self) -> float:
        return sum(companion.seconds for companion in self._companions)

    def _cells(self, summary: Summary) -> DoubleArray:
        """Error of the discretisation."""
        coarse = self._coarse.values(summary.step)
        if coarse is None:
            return np.full(len(ESTIMATED), np.nan)
        found: DoubleArray = np.hypot(self._richardson * (values_of(summary) - coarse), self._floor(summary))
        return found

    def _floor(self, summary: Summary) -> DoubleArray:
        """The least error of the discretisation; none of what is imposed."""
        side = math.sqrt(self._setup.grid.cell_area)
        ratio = side / summary.contact_radius if summary.contact_radius > side else 1.0
        imposed = self._imposed(summary.step)
        floor: DoubleArray = FLOOR * self._largest * ratio**FLOOR_ORDER
        for number, name in enumerate(ESTIMATED):
            if name in FLOOR_RADII:
                unseen = name == "stick_radius" and summary.stick_radius == 0.0 and self._setup.model.friction > 0.0
                floor[number] = (UNSEEN if unseen else FLOOR_RADII[name]) * side
            elif name.startswith("work"):
                floor[number] = FLOOR_WORK * ratio**FLOOR_ORDER_WORK * getattr(summary, name)
            elif name in imposed:
                floor[number] = 0.0
        return floor

    def _imposed(self, step: int) -> set[str]:
        """The load components that the path imposes."""
        increment = self._setup.load_path.increment(step, self._rows)
        forced = (*increment.normal.forced, *increment.tangential.forced)
        return {pair[0] if force else pair[1] for pair, force in zip(PAIRS, forced, strict=True)}

    def _increments(self, step: int) -> DoubleArray:
        """Error of the increments' number: 0 where it does not matter, NaN where a companion has no solution."""
        after = self._path_difference(step)
        if after is None:
            return np.full(len(ESTIMATED), np.nan)
        before = self._path_difference(step - 1) if step else np.zeros(len(ESTIMATED))
        error: DoubleArray = INCREMENTS_SAFETY * np.abs(after)
        if before is not None:
            work, total = ESTIMATED.index("work"), ESTIMATED.index("work_total")
            error[work] = INCREMENTS_SAFETY * abs(after[total] - before[total])
        return error

    def _path_difference(self, step: int) -> DoubleArray | None:
        """What the companions tell of the increments' error at `step`, between their common points in proportion."""
        if self._stepped is None:
            return np.zeros(len(ESTIMATED))
        fine, stepped = self._coarse.setup.load_path, self._stepped.setup.load_path
        first, second, share = nodes(fine, stepped, step)
        differences: list[DoubleArray] = []
        for place in (first, second):
            one, other = self._coarse.values_at(place), self._stepped.values_at(place)
            if one is None or other is None:
                return None
            differences.append((one - other) / abs(fine.counts[place.stage] / stepped.counts[place.stage] - 1.0))
        return differences[0] + share * (differences[1] - differences[0])

    def _iteration(self, summary: Summary) -> DoubleArray:
        """Error of the iteration: the worst residual on the scale of each value, that of the load of imposed ones."""
        imposed, scales = self._imposed(summary.step), self._scales(summary)
        errors: DoubleArray = summary.worst_residual * np.array([scales[name] for name in ESTIMATED])
        for number, name in enumerate(ESTIMATED):
            if name in imposed:
                errors[number] = summary.residual_load * scales[name]
        return errors

    def _scales(self, summary: Summary) -> dict[str, float]:
        """What residuals refer to: load or friction bound, the largest displacement of its kind, the value itself."""
        half, limit = 0.5 * max(self._setup.grid.size), self._setup.model.friction * summary.P
        normal = max(abs(summary.delta_z), half * abs(summary.phi_x), half * abs(summary.phi_y))
        tangential = max(abs(summary.delta_x), abs(summary.delta_y), half * abs(summary.phi_z))
        scales = {name: abs(getattr(summary, name)) for name in ESTIMATED}
        scales |= {"P": summary.P, "Mx": half * summary.P, "My": half * summary.P}
        scales |= {"Qx": limit, "Qy": limit, "Mz": half * limit}
        scales |= {"delta_z": normal, "phi_x": normal / half, "phi_y": normal / half}
        scales |= {"delta_x": tangential, "delta_y": tangential, "phi_z": tangential / half}
        return scales | dict.fromkeys(("work", "work_total"), limit * tangential)
