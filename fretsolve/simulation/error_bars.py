"""Error bars: estimates of how far a run's values lie from those of the continuum, from coarse runs.

They add three errors as independent ones. The error of the cells is the difference to a coarse run on half of the
points per side, by Richardson's extrapolation. It has a least value, since the errors of both runs may agree by chance.
The error of the increments is the difference between two coarse runs, one of which has half of the increments. The
error of the iteration is the certificate's worst residual. ``benchmarks/calibrate_error_bars.py`` calibrates the
constants; docs/error_bars.md has the outcome.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.case.models import Case
from fretsolve.result.state import ESTIMATED, State, Summary, SummaryErrors
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.coarse_runs import CoarseRun, coarser, common_points, fewer_increments, values_of
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import DoubleArray

ORDER, SURER_ORDERS = 0.8, {"contact_radius": 1.0, "work": 1.0, "work_total": 1.0}
"""Assumed orders of the discretisation. Sequences of grids show 1.3 to 2, but fluctuate with the place of the edges in
their cells. The contact radius and the dissipated energy need less safety."""

INCREMENTS_SAFETY = 2.0
"""Factor on the difference that is the error of the increments to first order; the observed order is slightly less."""

FLOOR, FLOOR_ORDER = 0.1, 2.0
FLOOR_WORK, FLOOR_ORDER_WORK = 0.2, 1.5
"""The least error of the cells is FLOOR (h/a)^FLOOR_ORDER times the largest value so far, with the side h of a cell and
the contact radius a. That of the dissipated energy is relative to its own value."""

FLOOR_RADII = {"contact_radius": 0.003, "stick_radius": 0.02}
"""The least error of radii, in units of h."""

NEAR_GROSS_SLIP = 0.15
"""Stick radius over contact radius below which increments count also if pressure and shear are not coupled: the shear
traction turns as the last of the stick zone slips, since Poisson's ratio links the directions."""

TOTAL = ESTIMATED.index("work_total")

UNSEEN = 0.5
"""Radius, in units of h, of a stick zone that may exist although no cell sticks."""


def run_with_error_bars(
    case: Case | ProblemSetup,
    start: State | None = None,
    history: Sequence[Summary] = (),
    threads: int = 1,
    warn: Callable[[str], object] | None = None,
) -> Iterator[State]:
    """Solve `case` as `run` does, and yield each state with its error bars.

    If a coarse run has no solution, the error bars are NaN from there on, and `warn` is called with one line.
    Raises NoSolutionError if the run itself has none.
    """
    setup = case if isinstance(case, ProblemSetup) else set_up(case)
    bars = ErrorBars(setup, history, threads)
    for state in run(setup, start, history, threads):
        errors = bars.of(state.summary)
        if bars.failure is not None and warn is not None:
            warn(f"no error bars from increment {state.summary.step} on: {bars.failure}")
            warn = None
        yield replace(state, errors=errors)


class ErrorBars:
    """The error bars of a problem, summary after summary. history: the summaries so far."""

    def __init__(self, setup: ProblemSetup, history: Sequence[Summary] = (), threads: int = 1):
        self._setup = setup
        self._threads = threads
        self._coarse = CoarseRun(coarser(setup, setup.load_path.counts), threads)
        self._fewer = self._with_fewer() if setup.load_path.path_dependent else None
        orders = np.array([SURER_ORDERS.get(name, ORDER) for name in ESTIMATED])
        points, coarse_points = (math.prod(one.grid.shape) for one in (setup, self._coarse.setup))
        self._coarse_share = coarse_points / points
        self._richardson = 1.0 / (math.sqrt(points / coarse_points) ** orders - 1.0)
        self._summaries: list[Summary] = []
        self._largest = np.zeros(len(ESTIMATED))
        for summary in history:
            self._add(summary)
        if history:
            # Catch up now: the cost of the increments that are there already is not that of the next one.
            self._increments(history[-1].step)
            self._coarse.values(history[-1].step)

    @property
    def failure(self) -> str | None:
        """Reason why a coarse run stopped, in one line; None if none did."""
        for coarse in self._coarse_runs():
            if coarse.failure is not None:
                nx, ny = coarse.setup.grid.shape
                return f"the coarse run on {nx} x {ny} cells has no solution: {coarse.failure.message}"
        return None

    def of(self, summary: Summary) -> SummaryErrors:
        """Return the error bars of the summary that follows those so far."""
        cost_before = self._cost()
        self._add(summary)
        cells, increments = self._cells(summary), self._increments(summary.step)
        errors = np.sqrt(cells**2 + increments**2 + self._iteration(summary) ** 2)
        return SummaryErrors(*errors.tolist(), *(self._cost() - cost_before).tolist())

    def _coarse_runs(self) -> list[CoarseRun]:
        return [self._coarse] if self._fewer is None else [self._coarse, self._fewer]

    def _with_fewer(self) -> CoarseRun:
        """Return the coarse run with fewer increments."""
        return CoarseRun(coarser(self._setup, fewer_increments(self._setup.load_path.counts)), self._threads)

    def _add(self, summary: Summary) -> None:
        near_gross_slip = summary.stick_radius < NEAR_GROSS_SLIP * summary.contact_radius
        if self._fewer is None and self._setup.model.terms.in_plane_coupling and near_gross_slip:
            self._fewer = self._with_fewer()
        self._summaries.append(summary)
        self._largest = np.maximum(self._largest, np.abs(values_of(summary)))

    def _cost(self) -> DoubleArray:
        """Return operator applications of the coarse runs, in units of one on the run's own grid, and their seconds."""
        applications = self._coarse_share * sum(coarse.applications for coarse in self._coarse_runs())
        return np.array([applications, sum(coarse.seconds for coarse in self._coarse_runs())])

    def _cells(self, summary: Summary) -> DoubleArray:
        """Return the error of the discretisation."""
        difference = values_of(summary) - self._coarse.values(summary.step)
        return np.asarray(np.hypot(self._richardson * difference, self._floor(summary)))

    def _floor(self, summary: Summary) -> DoubleArray:
        """Return the least error of the discretisation; none for imposed values."""
        side = math.sqrt(self._setup.grid.cell_area)
        ratio = side / summary.contact_radius if summary.contact_radius > side else 1.0
        imposed = self._imposed(summary.step)
        floor: DoubleArray = FLOOR * self._largest * ratio**FLOOR_ORDER
        for number, name in enumerate(ESTIMATED):
            if name == "stick_radius" and summary.stick_radius == 0.0 and self._setup.model.friction > 0.0:
                floor[number] = UNSEEN * side
            elif name in FLOOR_RADII:
                floor[number] = FLOOR_RADII[name] * side
            elif name.startswith("work"):
                floor[number] = FLOOR_WORK * ratio**FLOOR_ORDER_WORK * getattr(summary, name)
            elif name in imposed:
                floor[number] = 0.0
        return floor

    def _imposed(self, step: int) -> set[str]:
        """Return the load components that the path imposes."""
        increment = self._setup.load_path.increment(step, self._summaries)
        forced = (*increment.normal.forced, *increment.tangential.forced)
        return {pair[0] if force else pair[1] for pair, force in zip(PAIRS, forced, strict=True)}

    def _increments(self, step: int) -> DoubleArray:
        """Return the error of the increments: 0 if their number does not matter, NaN if a coarse run has failed."""
        if self._fewer is None:
            return np.zeros(len(ESTIMATED))
        after = self._path_difference(self._fewer, step)
        error: DoubleArray = INCREMENTS_SAFETY * np.abs(after)
        total_before = self._path_difference(self._fewer, step - 1)[TOTAL] if step else 0.0
        error[ESTIMATED.index("work")] = INCREMENTS_SAFETY * abs(after[TOTAL] - total_before)
        return error

    def _path_difference(self, fewer: CoarseRun, step: int) -> DoubleArray:
        """Return the error of the increments at `step` by the coarse runs, interpolated between common points."""
        many, few = self._coarse.setup.load_path, fewer.setup.load_path
        first, second, share = common_points(many, few, step)
        start, end = (
            (self._coarse.values_at(point) - fewer.values_at(point))
            / abs(many.counts[point.stage] / few.counts[point.stage] - 1.0)
            for point in (first, second)
        )
        return start + share * (end - start)

    def _iteration(self, summary: Summary) -> DoubleArray:
        """Return the error of the iteration: the worst residual, for imposed values that of the load, times a scale."""
        imposed, scales = self._imposed(summary.step), self._scales(summary)
        residuals = {True: summary.residual_load, False: summary.worst_residual}
        return np.array([residuals[name in imposed] * scales[name] for name in ESTIMATED])

    def _scales(self, summary: Summary) -> dict[str, float]:
        """Return what residuals refer to: load or friction limit, largest displacement of its kind, or the value."""
        half, limit = 0.5 * max(self._setup.grid.size), self._setup.model.friction * summary.P
        normal = max(abs(summary.delta_z), half * abs(summary.phi_x), half * abs(summary.phi_y))
        tangential = max(abs(summary.delta_x), abs(summary.delta_y), half * abs(summary.phi_z))
        scales = {name: abs(getattr(summary, name)) for name in ESTIMATED}
        scales |= {"P": summary.P, "Mx": half * summary.P, "My": half * summary.P}
        scales |= {"Qx": limit, "Qy": limit, "Mz": half * limit}
        scales |= {"delta_z": normal, "phi_x": normal / half, "phi_y": normal / half}
        scales |= {"delta_x": tangential, "delta_y": tangential, "phi_z": tangential / half}
        return scales | dict.fromkeys(("work", "work_total"), limit * tangential)
