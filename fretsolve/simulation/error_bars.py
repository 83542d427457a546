"""Error bars: estimates of how far a run's values lie from those of the continuum, from coarse runs.

They add three errors as independent ones. The error of the cells follows from coarse runs on half and on a third of the
points per side, by Richardson's extrapolation. Three grids show what two hide when their errors agree by chance, and a
least value stands for what all three hide. The error of the increments is the difference between two coarse runs, one
of which has half of the increments. The error of the iteration is the certificate's worst residual.
``benchmarks/calibrate_error_bars.py`` calibrates the constants; docs/error_bars.md has the outcome.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.case.models import Case
from fretsolve.result.state import ESTIMATED, State, Summary, SummaryErrors
from fretsolve.setup.closed_forms import spence_ratio
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.coarse_runs import CoarseRun, coarser, common_points, fewer_increments, values_of
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import DoubleArray

ORDER = 0.8
ORDERS = {"delta_z": 1.2, "max_pressure": 0.7, "work": 0.7, "work_total": 0.7}
"""Assumed orders of the discretisation. Sequences of grids show 1.3 to 2, but fluctuate with the place of the edges in
their cells."""

COARSER = (2, 3)
"""Points per side of the run over those of the coarse runs."""

BETWEEN = 0.5
"""Part of the difference between the two coarse grids that counts as an error of the run."""

INCREMENTS_SAFETY = 4.0
"""Factor on the difference that is the error of the increments to first order. With few increments the difference
shows less than half of the error."""

FLOOR, FLOOR_ORDER = 0.1, 2.0
FLOOR_WORK, FLOOR_ORDER_WORK = 0.2, 1.5
"""The least error of the cells is FLOOR (h/a)^FLOOR_ORDER times the largest value so far, with the side h of a cell and
the contact radius a. That of the dissipated energy is relative to its own value."""

FLOOR_RADII = {"contact_radius": 0.006, "stick_radius": 0.03}
"""The least error of radii, in units of h."""

FLOOR_MOMENT = 0.02
"""The least error of Mx and My is no less than FLOOR_MOMENT (h/a)^FLOOR_ORDER times P a: they sum up pressures of
opposite effect."""

NEARLY_SLIDING = 0.15
"""Stick radius over contact radius below which increments count also if pressure and shear are not coupled: the shear
traction turns as the last of the stick zone slips, since Poisson's ratio links the directions."""

TOTAL = ESTIMATED.index("work_total")

UNSEEN = 0.5
"""Radius, in units of h, of a stick zone that may exist although no cell sticks."""

UNSEEN_ANNULUS, UNSEEN_WORK = 1.3, 8.0
"""A slip annulus of dissimilar bodies pressed together that is thinner than UNSEEN_BELOW cells is not resolved: more
increments only make it vanish. Its width w is UNSEEN_ANNULUS times that of a sphere (Spence), and the energy that it
dissipates while the contact grows is UNSEEN_WORK mu beta (w/a)^2.5 p0^2 a^3/E*, with Dundurs' constant beta: slip of
the order beta w^2/R under a pressure of the order p0 (w/a)^(1/2) in all of the area. The factors hold for spheres and
flat punches, where the order of magnitude alone is 3 too large and 3 too small."""

UNSEEN_BELOW = 1.5


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
        self._half, self._third = (
            CoarseRun(coarser(setup, factor, setup.load_path.counts), threads) for factor in COARSER
        )
        self._fewer = self._with_fewer() if setup.load_path.path_dependent else None
        self._orders = np.array([ORDERS.get(name, ORDER) for name in ESTIMATED])
        self._summaries: list[Summary] = []
        self._largest = np.zeros(len(ESTIMATED))
        for summary in history:
            self._add(summary)
        if history:
            # Catch up now: the cost of the increments that are there already is not that of the next one.
            self._increments(history[-1].step)
            for coarse in (self._half, self._third):
                coarse.values(history[-1].step)

    @property
    def failure(self) -> str | None:
        """Why a coarse run stopped, in one line; None if none did."""
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
        return [coarse for coarse in (self._half, self._third, self._fewer) if coarse is not None]

    def _with_fewer(self) -> CoarseRun:
        """Return the coarse run with fewer increments."""
        counts = fewer_increments(self._setup.load_path.counts)
        return CoarseRun(coarser(self._setup, COARSER[-1], counts), self._threads)

    def _add(self, summary: Summary) -> None:
        nearly_slides = summary.stick_radius < NEARLY_SLIDING * summary.contact_radius
        if self._fewer is None and self._setup.model.terms.in_plane_coupling and nearly_slides:
            self._fewer = self._with_fewer()
        self._summaries.append(summary)
        self._largest = np.maximum(self._largest, np.abs(values_of(summary)))

    def _cost(self) -> DoubleArray:
        """Return operator applications of the coarse runs, in units of one on the run's own grid, and their seconds."""
        runs = self._coarse_runs()
        applications = sum(coarse.applications / self._refinement(coarse) ** 2 for coarse in runs)
        return np.array([applications, sum(coarse.seconds for coarse in runs)])

    def _refinement(self, coarse: CoarseRun) -> float:
        """Return the points per side of the run over those of a coarse run."""
        points, coarse_points = (math.prod(one.grid.shape) for one in (self._setup, coarse.setup))
        return math.sqrt(points / coarse_points)

    def _cells(self, summary: Summary) -> DoubleArray:
        """Return the error of the discretisation."""
        value, errors = values_of(summary), [self._floor(summary)]
        half, third = (coarse.values(summary.step) for coarse in (self._half, self._third))
        for coarse, estimate in ((self._half, half), (self._third, third)):
            errors.append((value - estimate) / (self._refinement(coarse) ** self._orders - 1.0))
        errors.append(BETWEEN * (half - third))
        found: DoubleArray = np.linalg.norm(errors, axis=0)
        return found

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
            elif name in ("Mx", "My"):
                moment = FLOOR_MOMENT * ratio**FLOOR_ORDER * summary.P * summary.contact_radius
                floor[number] = math.hypot(floor[number], moment)
        width, work = self._unseen_slip(summary)
        floor[ESTIMATED.index("stick_radius")] += width
        floor[TOTAL] += work
        return floor

    def _unseen_slip(self, summary: Summary) -> tuple[float, float]:
        """Return width (mm) and dissipated energy (mJ) of a slip annulus too thin for the cells; 0 for others."""
        model = self._setup.model
        width = UNSEEN_ANNULUS * (1.0 - spence_ratio(model)) * summary.contact_radius
        if not 0.0 < width < UNSEEN_BELOW * math.sqrt(self._setup.grid.cell_area):
            return 0.0, 0.0
        pair, radius = model.compliances, summary.contact_radius
        mismatch = model.friction * abs(pair.dundurs_constant) * (width / radius) ** 2.5
        return width, UNSEEN_WORK * mismatch * summary.max_pressure**2 * radius**3 / pair.contact_modulus

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
        many, few = self._third.setup.load_path, fewer.setup.load_path
        first, second, share = common_points(many, few, step)
        start, end = (
            (self._third.values_at(point) - fewer.values_at(point))
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
