"""Coarse runs: a case on half or a third of the points per side, also with other numbers of increments.

They advance with the run whose errors they show, so that it can be stopped after each increment.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from fretsolve.errors import CaseError, GridEdgeError, NoSolutionError
from fretsolve.increment.increment import IncrementSolver
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import CORRECTED, ESTIMATED, State, Summary
from fretsolve.setup.contact_size import COARSENED, coarse_points
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.error_bars.coarse_counts import coarse_counts, slipping_stages
from fretsolve.simulation.error_bars.path_points import PathPoint, at_point, between_common_points, common_points
from fretsolve.simulation.simulation import increment_solver, states_of
from fretsolve.system.arrays import DoubleArray

LOOSER, LOOSEST = 30.0, 1e-4
"""Tolerance of a coarse run in units of the run's, and its limit. It saves a quarter of the applications, and shifts
corrections by some 1e-5 of the value (mode I.3, 48 x 48 cells), well below the differences of interest."""

MOST_RINGS = 2
"""Rings of cells around the area of a coarse run, at most, where the contact reaches the edge of its larger cells."""

CORRECTABLE = np.array([name in CORRECTED for name in ESTIMATED])
"""Which of `ESTIMATED` are corrected for the number of increments."""

TOTAL = ESTIMATED.index("work_total")

FIRST_ORDER = 1.5
"""Order in the number n of increments with which the energy of the first stage converges, whose loads grow in
proportion from zero. An increment there errs by the square of its part of the load, so that all of them err by n^(-3/2)
on a cone and by n^(-5/3) on a sphere. With 3 to 24 equal increments a pressed sphere shows orders of 1.4 to
1.7, and graded ones 1.4 to 2.3, whose energy it so corrects by too much, though by less than the first order would."""


def values_of(summary: Summary) -> DoubleArray:
    """Return the values of `ESTIMATED`, in their order."""
    return np.array([getattr(summary, name) for name in ESTIMATED])


class CoarseRun:
    """The run of a coarser problem, solved only as far as its values are asked for.

    every: after how many increments of each stage radii are asked for; after each without it. beside: a run of the
    same problem with other increments, whose solver this one has too.
    failure: why it stopped, if it did; applications, seconds: of the elastic operator on the coarse grid so far.
    """

    def __init__(
        self, setup: ProblemSetup, threads: int, every: tuple[int, ...] | None = None, beside: CoarseRun | None = None
    ):
        self.setup, self._threads, self._beside, self._rings = setup, threads, beside, 0
        self._every = dict(zip((stage.number for stage in setup.load_path.stages), every or (), strict=bool(every)))
        self.failure: NoSolutionError | CaseError | None = None
        self.applications, self.seconds = 0, 0.0
        self._states = self._from_start()
        self._values: list[DoubleArray] = []

    @cached_property
    def solver(self) -> IncrementSolver:
        """The solver. Making one for both runs on a grid saves the time of a third of an increment."""
        if self._beside is not None and self._beside.setup.grid == self.setup.grid:
            return self._beside.solver
        return increment_solver(self.setup, self.setup.separation(), self._threads, to_map_end=True)

    def _from_start(self) -> Iterator[State]:
        """Yield the states from the first increment on."""
        return states_of(self.setup, measured=self._is_asked_for, solver=lambda: self.solver)

    def _widen(self) -> bool:
        """Start again with one more ring of cells around the area, and return whether that may help.

        The cells are the same ones, and so are the values up to where the contact has reached their edge. Beyond a
        height map there is no material, so that its last cells may be in contact.
        """
        if self._rings == MOST_RINGS:
            return False
        self._rings += 1
        self.setup = replace(self.setup, grid=self.setup.grid.with_ring())
        del self.solver  # it is for the smaller grid
        self._states, self._values = self._from_start(), []
        return True

    def _is_asked_for(self, step: int) -> bool:
        """Return whether the radii after `step` are asked for."""
        path = self.setup.load_path
        stage = next(place for place, last in enumerate(path.last_steps) if step <= last)
        return (path.last_steps[stage] - step) % self._every.get(path.stages[stage].number, 1) == 0

    def values(self, step: int) -> DoubleArray:
        """Return the values after the increment `step`; zeros before the first one, NaN after a failure."""
        if step < 0:
            return np.zeros(len(ESTIMATED))
        while len(self._values) <= step and self.failure is None:
            try:
                summary = next(self._states).summary
            except GridEdgeError as error:
                if not self._widen():
                    self.failure = error
            except (NoSolutionError, CaseError) as error:  # a surface may fit the cells of the run alone
                self.failure = error
            else:
                self._values.append(values_of(summary))
                self.applications += summary.operator_applications
                self.seconds += summary.wall_time
        return self._values[step] if step < len(self._values) else np.full(len(ESTIMATED), np.nan)

    def values_at(self, point: PathPoint) -> DoubleArray:
        """Return the values at a point of the load path, interpolated between increments."""
        return at_point(self.values, self.setup.load_path, point)


class CoarseRuns:
    """The coarse runs of a problem, and what they show together.

    One has a third of the points per side. Where the number of increments matters, a second one has the same points and
    other increments. The third one has half of the points. Errors of the increments are of first order in their number,
    and about the same on all grids, which makes up for the increments that a run lacks.
    """

    def __init__(self, setup: ProblemSetup, threads: int):
        slips = slipping_stages(setup)
        self._slips = {stage.number: slips_in for stage, slips_in in zip(setup.load_path.stages, slips, strict=True)}
        self._left_out = set[int]()
        self._path = setup.load_path.with_counts(setup.load_path.counts, self._left_out)
        counts = coarse_counts(setup, slips)
        self.third = CoarseRun(coarser(setup, COARSENED, counts.third, self._left_out), threads)
        self.half = CoarseRun(coarser(setup, 2, counts.half, self._left_out), threads)
        self.other_increments = None
        if counts.other is not None:
            apart = tuple(max(other // asked, 1) for other, asked in zip(counts.other, counts.third, strict=True))
            other = coarser(setup, COARSENED, counts.other, self._left_out)
            self.other_increments = CoarseRun(other, threads, apart, self.third)
        self._points = math.prod(setup.grid.shape)
        self._directions = len(setup.grid.axes)

    @property
    def all(self) -> list[CoarseRun]:
        """The runs."""
        return [coarse for coarse in (self.third, self.other_increments, self.half) if coarse is not None]

    def leave_out(self, numbers: Collection[int]) -> None:
        """Leave out the stages of these numbers, as the run does whose cycles are periodic."""
        self._left_out |= set(numbers)
        self._path = self._path.without(self._left_out)
        for coarse in self.all:
            coarse.setup = replace(coarse.setup, load_path=coarse.setup.load_path.without(self._left_out))

    def refinement(self, coarse: CoarseRun) -> float:
        """Return the points per side of the run over those of a coarse one."""
        cells = self._points / math.prod(coarse.setup.grid.shape)
        return cells if self._directions == 1 else math.sqrt(cells)

    def cost(self) -> DoubleArray:
        """Return operator applications so far, in units of one on the run's own grid, and their seconds."""
        applications = sum(coarse.applications / self.refinement(coarse) ** self._directions for coarse in self.all)
        return np.array([applications, sum(coarse.seconds for coarse in self.all)])

    def failure(self) -> str | None:
        """Return why a coarse run stopped, in one line; None if none did."""
        for coarse in self.all:
            if coarse.failure is not None:
                size, count = coarse.setup.grid.shape[: self._directions], coarse.setup.load_path.increments
                which = f"{' x '.join(map(str, size))} cells with {count} increment{'s' * (count != 1)}"
                return f"the coarse run on {which} has no solution: {coarse.failure.message}"
        return None

    def last_known(self, step: int) -> PathPoint:
        """Return the last point up to the increment `step` at which the run on a third of the points has one too."""
        first, second, share = common_points(self._path, self.third.setup.load_path, self.point(step))
        return first if share else second

    def third_at(self, point: PathPoint) -> DoubleArray:
        """Return the values at a point on a third of the points, with as many increments as the run has."""
        # Radii and the largest pressure change by their edges' place in the cells rather than by the increments.
        lacking = self._errors(self._path, point) - self._errors(self.third.setup.load_path, point)
        found: DoubleArray = self.third.values_at(point) + np.where(CORRECTABLE, lacking, 0.0)
        return found

    def change_by_increments(self, step: int) -> DoubleArray:
        """Return what infinitely many increments would add to the values at `step`."""
        return -self._errors(self._path, self.point(step)) if step >= 0 else np.zeros(len(ESTIMATED))

    def half_less_third(self, point: PathPoint) -> DoubleArray:
        """Return the values at a point on half of the points less those on a third, with as many increments.

        Before the first increment that both have, the difference is the one there: radii differ under the least load.
        """
        first, second, _ = common_points(self._path, self.half.setup.load_path, point)
        if first == PathPoint(0, 0.0):
            return self._half_less_third(second)
        return between_common_points(self._half_less_third, self._path, self.half.setup.load_path, point)

    def point(self, step: int) -> PathPoint:
        """Return the point of the load path at the end of an increment of the run."""
        stage = next(number for number, last in enumerate(self._path.last_steps) if step <= last)
        count = self._path.counts[stage]
        return PathPoint(stage, (step - self._path.last_steps[stage] + count) / count)

    def _half_less_third(self, point: PathPoint) -> DoubleArray:
        # of the runs on a third of the points, the one with as many increments
        counts, alike = self.half.setup.load_path.counts, self.third
        other = self.other_increments
        if other is not None and other.setup.load_path.counts[point.stage] == counts[point.stage]:
            alike = other
        return self.half.values_at(point) - alike.values_at(point)

    def _errors(self, path: LoadPath, point: PathPoint) -> DoubleArray:
        """Return the errors of as many increments as `path` has."""
        if self.other_increments is None:
            return np.zeros(len(ESTIMATED))
        # compare the two at increments of the one that has fewer, which the other one has too
        runs = self.other_increments.setup.load_path, self.third.setup.load_path
        fewer = min(runs, key=lambda run: run.counts[point.stage])
        return between_common_points(partial(self._errors_at, path), self._path, fewer, point)

    def _errors_at(self, path: LoadPath, point: PathPoint) -> DoubleArray:
        """Return the errors at a point that the runs on a third of the points have in common.

        They are of first order, but that of the energy of the first stage of its own.
        """
        errors: DoubleArray = self._other_less_third(point) * self._part(path, point.stage)
        if self._slips_in(0):
            first = self._other_less_third(PathPoint(0, 1.0) if point.stage else point)[TOTAL]
            errors[TOTAL] += first * (self._part(path, 0, FIRST_ORDER) - self._part(path, point.stage))
        return errors

    def _other_less_third(self, point: PathPoint) -> DoubleArray:
        assert self.other_increments is not None  # only runs that need it ask for it
        return self.other_increments.values_at(point) - self.third.values_at(point)

    def _part(self, path: LoadPath, stage: int, order: float = 1.0) -> float:
        """Return the error of the increments of `path` over the difference of those on a third of the points."""
        assert self.other_increments is not None
        runs = self.other_increments.setup.load_path, self.third.setup.load_path
        other, third = (run.counts[stage] ** -order for run in runs)
        return float(path.counts[stage] ** -order / (other - third)) if self._slips_in(stage) else 0.0

    def _slips_in(self, stage: int) -> bool:
        """Return whether something may slip in a stage of the path."""
        return self._slips[self._path.stages[stage].number]


def coarser(setup: ProblemSetup, factor: int, counts: tuple[int, ...], left_out: Collection[int] = ()) -> ProblemSetup:
    """Return the problem on a `factor`-th of the points per side (`coarse_points`), with `counts` increments per stage.

    left_out: see `LoadPath.with_counts`.
    """
    nx, ny = (coarse_points(points, factor) for points in setup.grid.shape)
    grid = setup.grid.cut_into(nx, ny)
    solver = setup.case.solver
    looser = max(solver.tolerance, min(LOOSER * solver.tolerance, LOOSEST))
    case = setup.case.model_copy(update={"solver": solver.model_copy(update={"tolerance": looser})})
    return replace(setup, case=case, grid=grid, load_path=setup.load_path.with_counts(counts, left_out))
