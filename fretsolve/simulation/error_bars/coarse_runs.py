"""Coarse runs: a case on half or a third of the points per side, also with other increments, beside the run itself."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from functools import partial
from itertools import accumulate, compress
from operator import or_
from typing import NamedTuple

import numpy as np

from fretsolve.case.history import COMPONENTS, SHEARING
from fretsolve.contact.increment.increment import IncrementSolver
from fretsolve.errors import CaseError, GridEdgeError, NoSolutionError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.setup.picked_settings import COARSENED, coarse_points
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import CORRECTED, ESTIMATED, Summary
from fretsolve.simulation.simulation import increment_solver, states_of
from fretsolve.system.arrays import DoubleArray

MANY = 4
"""If every stage that slips has this many increments, the coarse runs take a half and a quarter of them. That takes two
thirds of the time of coarse runs with all and half of the increments; corrected values are as good."""

FEW = 3
"""Increments of a stage from which on its half, rounded up, and twice that are taken where another stage has less than
MANY. Stages of less have all and twice as many."""


class CoarseCounts(NamedTuple):
    """Increments per stage of the coarse runs: on a third of the points, on these points again to compare, and on half.

    other: None where the number of increments does not matter.
    """

    third: tuple[int, ...]
    other: tuple[int, ...] | None
    half: tuple[int, ...]


def coarse_counts(setup: ProblemSetup, slips: tuple[bool, ...]) -> CoarseCounts:
    """Return the increments of the coarse runs; slips: of each stage, whether something may slip in it.

    Their number matters where the slip depends on the path, and where it turns. The errors of all stages grow by one
    factor where all have the same share of the run's increments.
    """
    counts = setup.load_path.counts
    # of stages in which nothing depends on the number of increments
    unslipping_third = tuple(count if count % 4 else count // 2 for count in counts)
    unslipping_half = tuple(count if count % 2 else count // 2 for count in unslipping_third)
    if not any(slips) or not (setup.load_path.path_dependent or setup.model.terms.in_plane_coupling):
        return CoarseCounts(unslipping_third, None, unslipping_half)
    if min(compress(counts, slips)) >= MANY:
        other = half = tuple(-(-count // 4) for count in counts)
        third = tuple(2 * count for count in other)
    else:
        fewer = not _keeps_errors_of_pressing(setup)  # which want the same share in all stages
        third = half = tuple(-(-count // 2) if fewer and count >= FEW else count for count in counts)
        other = tuple(2 * count for count in third)
    # until something slips, one increment leads to the same state as many
    third, half = where(slips, third, unslipping_third), where(slips, half, unslipping_half)
    return CoarseCounts(third, where(slips, other, [1] * len(other)), half)


def where(slips: Iterable[bool], here: Iterable[int], there: Iterable[int]) -> tuple[int, ...]:
    """Return the numbers of `here` for stages that slip, and the numbers of `there` for the others."""
    return tuple(one if slipping else other for slipping, one, other in zip(slips, here, there, strict=True))


def slipping_stages(setup: ProblemSetup) -> tuple[bool, ...]:
    """Return for each stage whether something may slip in it: all between dissimilar bodies, or once one is sheared."""
    moved = (any(name in SHEARING and value for name, value in stage.targets) for stage in setup.case.stages())
    return tuple(setup.model.coupled or sheared for sheared in accumulate(moved, or_))


def _keeps_errors_of_pressing(setup: ProblemSetup) -> bool:
    """Return whether the error of pressing dissimilar bodies persists: it is pressed in few increments, or tilts."""
    if not setup.model.coupled:
        return False
    stages = [
        (dict(stage.targets), count) for stage, count in zip(setup.case.stages(), setup.load_path.counts, strict=True)
    ]
    presses = any(count < MANY and targets.keys() & set(COMPONENTS[0]) for targets, count in stages)
    return presses or any(targets.get(name) for targets, _ in stages for names in COMPONENTS[1:3] for name in names)


LOOSER, LOOSEST = 30.0, 1e-4
"""Tolerance of a coarse run in units of the run's, and its limit. It saves a quarter of the applications, and shifts
corrections by some 1e-5 of the value."""

MOST_RINGS = 2
"""Rings of cells around the area of a coarse run, at most, where the contact reaches the edge of its larger cells."""

CORRECTABLE = np.array([name in CORRECTED for name in ESTIMATED])
"""Which of `ESTIMATED` are corrected for the number of increments."""

TOTAL = ESTIMATED.index("work_total")

FIRST_ORDER = 1.5
"""Order in the number n of increments with which the energy of the first stage converges, whose loads grow from zero:
each errs by the square of its part of the load, so that all of them err by n^(-3/2) on a cone, n^(-5/3) on a sphere."""


class PathPoint(NamedTuple):
    """A point of the load path: the share `part` of the stage `stage` (0-based)."""

    stage: int
    part: float


def at_point(values: Callable[[int], DoubleArray], path: LoadPath, point: PathPoint) -> DoubleArray:
    """Return `values` at a point of `path`, interpolated between the values of its increments."""
    first, count = path.last_steps[point.stage] - path.counts[point.stage] + 1, path.counts[point.stage]
    step = first + point.part * count - 1.0
    low, high = around(step)
    before = values(low)
    return before + (step - low) * (values(high) - before) if high > low else before


def around(position: float) -> tuple[int, int]:
    """Return the whole numbers below and above a position, twice the same one if it is one but for rounding."""
    return math.floor(position + 1e-9), math.ceil(position - 1e-9)


def common_points(one: LoadPath, other: LoadPath, point: PathPoint) -> tuple[PathPoint, PathPoint, float]:
    """Return the points around `point` at which the path with fewer increments has one, and the share between them.

    The first may be the end of the stage before, or the start of the path (the share 0 of its first stage).
    """
    stage, part = point
    common = min(one.counts[stage], other.counts[stage])
    low, high = around(part * common)
    first = PathPoint(stage - 1, 1.0) if stage and not low else PathPoint(stage, low / common)
    return first, PathPoint(stage, high / common), part * common - low if high > low else 0.0


def between_common_points(
    value: Callable[[PathPoint], DoubleArray], one: LoadPath, other: LoadPath, point: PathPoint
) -> DoubleArray:
    """Return `value` at a point, interpolated between points at which the path with fewer increments has a value."""
    first, second, share = common_points(one, other, point)
    return value(first) * (1.0 - share) + share * value(second) if share else value(second)


def values_of(summary: Summary) -> DoubleArray:
    """Return the values of `ESTIMATED`, in their order."""
    return np.array([getattr(summary, name) for name in ESTIMATED])


class CoarseRun:
    """The run of a coarser problem, solved only as far as its values are asked for.

    failure: why it stopped, if it did; applications: of the operator on the coarse grid so far, which took `seconds`.
    """

    def __init__(self, setup: ProblemSetup, threads: int):
        self.setup, self._threads, self._rings = setup, threads, 0
        self.failure: NoSolutionError | CaseError | None = None
        self.applications, self.seconds = 0, 0.0
        self._states = states_of(setup, solver=self._solver)
        self._values: list[DoubleArray] = []

    def _solver(self) -> IncrementSolver:
        return increment_solver(self.setup, self.setup.separation(), self._threads, to_map_end=True)

    def _widen(self) -> bool:
        """Start again with one more ring of cells around the area, and return whether that may help.

        The cells are the same ones, and so are the values up to where the contact has reached their edge. Beyond a
        height map there is no material, so that its last cells may be in contact.
        """
        if self._rings == MOST_RINGS:
            return False
        self._rings += 1
        self.setup = replace(self.setup, grid=self.setup.grid.with_ring())
        self._states = states_of(self.setup, solver=self._solver)
        self._values = []
        return True

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

    One has a third of the points per side, one half of them, and where the number of increments matters, another one a
    third with other increments. Errors of the increments are of first order in their number, and about the same on all
    grids, which makes up for the increments that a run lacks.
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
            self.other_increments = CoarseRun(coarser(setup, COARSENED, counts.other, self._left_out), threads)
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
        """Return the run's points per side over a coarse run's points per side."""
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
        """Return the last point up to the increment `step` that the run on a third of the points has, too."""
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
        """Return the values at a point on half of the points less the values on a third, with as many increments.

        Before the first increment that both have, the difference is the one there: radii differ under the least load.
        """
        first, second, _ = common_points(self._path, self.half.setup.load_path, point)
        if first == PathPoint(0, 0.0):
            return self._half_less_third(second)
        return between_common_points(self._half_less_third, self._path, self.half.setup.load_path, point)

    def point(self, step: int) -> PathPoint:
        """Return the point of the load path at the end of an increment of the run."""
        stage = bisect_left(self._path.last_steps, step)
        count = self._path.counts[stage]
        return PathPoint(stage, (step - self._path.last_steps[stage] + count) / count)

    def _half_less_third(self, point: PathPoint) -> DoubleArray:
        # of the runs on a third of the points, the one with as many increments
        count, other = self.half.setup.load_path.counts[point.stage], self.other_increments
        alike = other if other is not None and other.setup.load_path.counts[point.stage] == count else self.third
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

        They are of first order; the energy of the first stage has an order of its own.
        """
        errors: DoubleArray = self._other_less_third(point) * self._part(path, point.stage)
        if self._slips[self._path.stages[0].number]:
            first = self._other_less_third(PathPoint(0, 1.0) if point.stage else point)[TOTAL]
            errors[TOTAL] += first * (self._part(path, 0, FIRST_ORDER) - self._part(path, point.stage))
        return errors

    def _other_less_third(self, point: PathPoint) -> DoubleArray:
        assert self.other_increments is not None  # only runs that need it ask for it
        return self.other_increments.values_at(point) - self.third.values_at(point)

    def _part(self, path: LoadPath, stage: int, order: float = 1.0) -> float:
        """Return the error of the increments of `path` over the difference of the runs on a third of the points."""
        assert self.other_increments is not None
        runs = self.other_increments.setup.load_path, self.third.setup.load_path
        other, third = (run.counts[stage] ** -order for run in runs)
        return (
            float(path.counts[stage] ** -order / (other - third))
            if self._slips[self._path.stages[stage].number]
            else 0.0
        )


def coarser(setup: ProblemSetup, factor: int, counts: tuple[int, ...], left_out: Collection[int] = ()) -> ProblemSetup:
    """Return the problem on a `factor`-th of the points per side (`coarse_points`), with `counts` increments per stage.

    left_out: see `LoadPath.with_counts`.
    """
    grid = setup.grid.cut_into(*(coarse_points(points, factor) for points in setup.grid.shape))
    solver = setup.case.solver
    looser = max(solver.tolerance, min(LOOSER * solver.tolerance, LOOSEST))
    case = setup.case.model_copy(update={"solver": solver.model_copy(update={"tolerance": looser})})
    return replace(setup, case=case, grid=grid, load_path=setup.load_path.with_counts(counts, left_out))
