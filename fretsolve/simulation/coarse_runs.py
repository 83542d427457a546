"""Coarse runs: a case on half or a third of the points per side, also with other numbers of increments.

They advance with the run whose errors they show, so that it can be stopped after each increment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import accumulate, compress
from operator import or_
from typing import NamedTuple

import numpy as np

from fretsolve.case.history import SHEARING
from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import CORRECTED, ESTIMATED, Summary
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.simulation import states_of
from fretsolve.system.arrays import DoubleArray

LOOSER, LOOSEST = 30.0, 1e-4
"""Tolerance of a coarse run in units of the run's, and its limit. It saves a quarter of the applications, and shifts
corrections by some 1e-5 of the value (mode I.3, 48 x 48 cells), well below the differences of interest."""

FEWEST_POINTS = 8
"""Points per side of a coarse run, at least. With fewer, a contact has no inside."""

CORRECTABLE = np.array([name in CORRECTED for name in ESTIMATED])
"""Which of `ESTIMATED` are corrected for the number of increments."""

FEWEST_HALVED, FEWEST_TURNED = 12, 4
"""Increments of each stage that slips, from which half of them show what more would change: where the slip depends on
the path, and where it only turns. Half take a quarter of the time of twice as many. The errors of the second order left
in the corrected values grow fourfold, to 0.3 % of the dissipated energy in mode I.3 with 20 increments."""


def values_of(summary: Summary) -> DoubleArray:
    """Return the values of `ESTIMATED`, in their order."""
    return np.array([getattr(summary, name) for name in ESTIMATED])


class PathPoint(NamedTuple):
    """A point of the load path: the share `part` of the stage `stage` (0-based)."""

    stage: int
    part: float


class CoarseRun:
    """The run of a coarser problem, solved only as far as its values are asked for.

    every: after how many increments of each stage radii are asked for; after each without it.
    failure: why it stopped, if it did; applications, seconds: of the elastic operator on the coarse grid so far.
    """

    def __init__(self, setup: ProblemSetup, threads: int, every: tuple[int, ...] | None = None):
        self.setup = setup
        self._every = dict(zip((stage.number for stage in setup.load_path.stages), every or (), strict=bool(every)))
        self.failure: NoSolutionError | CaseError | None = None
        self.applications, self.seconds = 0, 0.0
        self._states = states_of(setup, threads=threads, measured=self._is_asked_for)
        self._values: list[DoubleArray] = []

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
            except (NoSolutionError, CaseError) as error:  # a surface may fit the cells of the run alone
                self.failure = error
            else:
                self._values.append(values_of(summary))
                self.applications += summary.operator_applications
                self.seconds += summary.wall_time
        return self._values[step] if step < len(self._values) else np.full(len(ESTIMATED), np.nan)

    def values_at(self, point: PathPoint) -> DoubleArray:
        """Return the values at a point of the load path, interpolated between increments."""
        counts = self.setup.load_path.counts
        step = sum(counts[: point.stage]) + point.part * counts[point.stage] - 1.0
        low, high = math.floor(step + 1e-9), math.ceil(step - 1e-9)
        before, after = self.values(low), self.values(high)
        return before + (step - low) * (after - before) if high > low else before


class CoarseRuns:
    """The coarse runs of a problem, and what they show together.

    One has a third of the points per side. Where the number of increments matters, a second one has the same points and
    half of the increments, and so has one on half of the points. Errors of the increments are of first order in their
    number, and about the same on all grids.

    Half of few increments would tell little where the slip depends on the path. There the second run has twice as many,
    and what it shows stands for the increments that the one on half of the points lacks.
    """

    def __init__(self, setup: ProblemSetup, threads: int):
        counts = fewer = setup.load_path.counts
        other, slips = None, slipping_stages(setup)
        self._slips = {stage.number: slips_in for stage, slips_in in zip(setup.load_path.stages, slips, strict=True)}
        if any(slips) and (setup.load_path.path_dependent or setup.model.terms.in_plane_coupling):
            even = not any(count % 2 for count in compress(counts, slips))
            enough = FEWEST_HALVED if setup.load_path.path_dependent else FEWEST_TURNED
            if min(compress(counts, slips)) >= enough:
                other = fewer = halved(counts, slips)
            else:  # half only if the errors of all stages grow by one factor
                other, fewer = twice(counts), halved(counts, slips) if even else counts
            # until something slips, one increment leads to the same state as many
            other = tuple(count if slips_in else 1 for count, slips_in in zip(other, slips, strict=True))
        self._left_out = set[int]()
        self.third = CoarseRun(coarser(setup, 3, counts, self._left_out), threads)
        self.half = CoarseRun(coarser(setup, 2, fewer, self._left_out), threads)
        self.other_increments = None
        if other is not None:
            apart = tuple(max(count // asked, 1) for count, asked in zip(other, counts, strict=True))
            self.other_increments = CoarseRun(coarser(setup, 3, other, self._left_out), threads, apart)
        self._points = math.prod(setup.grid.shape)
        self._directions = len(setup.grid.axes)

    @property
    def tolerance(self) -> float:
        """Tolerance of the coarse runs."""
        return self.third.setup.case.solver.tolerance

    @property
    def all(self) -> list[CoarseRun]:
        """The runs."""
        return [coarse for coarse in (self.third, self.other_increments, self.half) if coarse is not None]

    def leave_out(self, numbers: Collection[int]) -> None:
        """Leave out the stages of these numbers, as the run does whose cycles are periodic."""
        self._left_out |= set(numbers)
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
                cells = " x ".join(map(str, coarse.setup.grid.shape[: self._directions]))
                return f"the coarse run on {cells} cells has no solution: {coarse.failure.message}"
        return None

    def change_by_increments(self, step: int) -> DoubleArray:
        """Return what infinitely many increments would add to the values at `step`, to first order."""
        if self.other_increments is None or step < 0:
            return np.zeros(len(ESTIMATED))
        other = self.other_increments.setup.load_path
        return between_common_points(self._change, self.third.setup.load_path, other, step)

    def _change(self, point: PathPoint) -> DoubleArray:
        other = self.other_increments
        assert other is not None  # only runs that need it ask for it
        if not self._slips[other.setup.load_path.stages[point.stage].number]:
            return np.zeros(len(ESTIMATED))
        ratio = self.third.setup.load_path.counts[point.stage] / other.setup.load_path.counts[point.stage]
        change: DoubleArray = (other.values_at(point) - self.third.values_at(point)) / (1.0 - ratio)
        return change

    def half_less_third(self, step: int) -> DoubleArray:
        """Return the values at `step` on half of the points less those on a third, interpolated between increments."""
        return between_common_points(self._half_less_third, self.third.setup.load_path, self.half.setup.load_path, step)

    def _half_less_third(self, point: PathPoint) -> DoubleArray:
        counts, fewer = (coarse.setup.load_path.counts for coarse in (self.third, self.half))
        other = self.other_increments
        if other is not None and other.setup.load_path.counts[point.stage] == fewer[point.stage]:
            return self.half.values_at(point) - other.values_at(point)
        missing = counts[point.stage] / fewer[point.stage] - 1.0
        difference: DoubleArray = self.half.values_at(point) - self.third.values_at(point)
        # The radii and the largest pressure change by their edges' place in the cells rather than by the increments.
        return difference + missing * CORRECTABLE * self._change(point) if missing else difference


def slipping_stages(setup: ProblemSetup) -> tuple[bool, ...]:
    """Return for each stage whether something may slip in it: all between dissimilar bodies, or once one is sheared."""
    moved = (any(name in SHEARING and value for name, value in stage.targets) for stage in setup.case.stages())
    return tuple(setup.model.coupled or sheared for sheared in accumulate(moved, or_))


def coarser(setup: ProblemSetup, factor: int, counts: tuple[int, ...], left_out: Collection[int] = ()) -> ProblemSetup:
    """Return the problem on a `factor`-th of the points per side (rounded up), with `counts` increments per stage.

    left_out: see `LoadPath.with_counts`.
    """
    nx, ny = (max(min(points, FEWEST_POINTS), -(-points // factor)) for points in setup.grid.shape)
    grid = setup.grid.cut_into(nx, ny)
    solver = setup.case.solver
    looser = max(solver.tolerance, min(LOOSER * solver.tolerance, LOOSEST))
    case = setup.case.model_copy(update={"solver": solver.model_copy(update={"tolerance": looser})})
    return replace(setup, case=case, grid=grid, load_path=setup.load_path.with_counts(counts, left_out))


def twice(counts: tuple[int, ...]) -> tuple[int, ...]:
    """Return twice as many increments per stage."""
    return tuple(2 * count for count in counts)


def halved(counts: tuple[int, ...], matter: tuple[bool, ...]) -> tuple[int, ...]:
    """Return half as many increments (rounded up) in the stages that `matter`."""
    return tuple(-(-count // 2) if whether else count for count, whether in zip(counts, matter, strict=True))


def common_points(fine: LoadPath, coarse: LoadPath, step: int) -> tuple[PathPoint, PathPoint, float]:
    """Return the points around `step` of `fine` at which `coarse` has increments too, and the share between them.

    The first may be the end of the stage before, or the start of the path (the share 0 of its first stage).
    """
    ends = fine.last_steps
    stage = next(number for number, last in enumerate(ends) if step <= last)
    count = fine.counts[stage]
    common = min(count, coarse.counts[stage])
    position = (step - ends[stage] + count) * common / count
    low, high = math.floor(position + 1e-9), math.ceil(position - 1e-9)
    first = PathPoint(stage - 1, 1.0) if stage and not low else PathPoint(stage, low / common)
    return first, PathPoint(stage, high / common), position - low


def between_common_points(
    value: Callable[[PathPoint], DoubleArray], fine: LoadPath, coarse: LoadPath, step: int
) -> DoubleArray:
    """Return `value` at `step` of `fine`, interpolated between the points at which `coarse` has increments too."""
    first, second, share = common_points(fine, coarse, step)
    end = value(second)
    if share == 0.0 or share == 1.0:
        return end
    start = value(first)
    return start + share * (end - start)
