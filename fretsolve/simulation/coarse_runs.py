"""Coarse runs: a case on half or a third of the points per side, also with other numbers of increments.

They advance with the run whose error bars they give, so that it can be stopped after each increment.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fretsolve.errors import NoSolutionError
from fretsolve.model.grid import Grid
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import ESTIMATED, Summary
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import DoubleArray

LOOSER, LOOSEST = 10.0, 1e-4
"""Tolerance of a coarse run in units of the run's, and its limit. It saves a quarter of the cost, and shifts values by
some 1e-6 of theirs, well below the differences of interest."""

FEWEST_COARSE_POINTS = 8
"""With fewer, a contact has no inside."""


def values_of(summary: Summary) -> DoubleArray:
    """Return the values of `ESTIMATED`, in their order."""
    return np.array([getattr(summary, name) for name in ESTIMATED])


class PathPoint(NamedTuple):
    """A point of the load path: the share `part` of the stage `stage` (0-based)."""

    stage: int
    part: float


class CoarseRun:
    """The run of a coarser problem, solved only as far as its values are asked for.

    failure: why it stopped, if it did; applications, seconds: of the elastic operator on the coarse grid so far.
    """

    def __init__(self, setup: ProblemSetup, threads: int):
        self.setup = setup
        self.failure: NoSolutionError | None = None
        self.applications, self.seconds = 0, 0.0
        self._states = run(setup, threads=threads)
        self._values: list[DoubleArray] = []

    def values(self, step: int) -> DoubleArray:
        """Return the values after the increment `step`; zeros before the first one, NaN after a failure."""
        if step < 0:
            return np.zeros(len(ESTIMATED))
        began = time.perf_counter()
        while len(self._values) <= step and self.failure is None:
            try:
                summary = next(self._states).summary
            except NoSolutionError as error:
                self.failure = error
            else:
                self._values.append(values_of(summary))
                self.applications += summary.operator_applications
        self.seconds += time.perf_counter() - began
        return self._values[step] if step < len(self._values) else np.full(len(ESTIMATED), np.nan)

    def values_at(self, point: PathPoint) -> DoubleArray:
        """Return the values at a point of the load path, interpolated between increments."""
        counts = self.setup.load_path.counts
        step = sum(counts[: point.stage]) + point.part * counts[point.stage] - 1.0
        low, high = math.floor(step + 1e-9), math.ceil(step - 1e-9)
        before, after = self.values(low), self.values(high)
        return before + (step - low) * (after - before) if high > low else before


def coarser(setup: ProblemSetup, factor: int, counts: tuple[int, ...]) -> ProblemSetup:
    """Return the problem with its points per side divided by `factor`, rounded up, and `counts` increments per stage.

    It keeps `FEWEST_COARSE_POINTS` per side.
    """
    nx, ny = (max(-(-points // factor), FEWEST_COARSE_POINTS) for points in setup.grid.shape)
    grid = Grid.from_size((nx, ny), setup.grid.size, setup.grid.center)
    solver = setup.case.solver
    looser = max(solver.tolerance, min(LOOSER * solver.tolerance, LOOSEST))
    case = setup.case.model_copy(update={"solver": solver.model_copy(update={"tolerance": looser})})
    return replace(setup, case=case, grid=grid, load_path=setup.load_path.with_counts(counts))


def fewer_increments(counts: tuple[int, ...]) -> tuple[int, ...]:
    """Return half as many increments per stage; two if there is one, which cannot be halved."""
    return tuple(count // 2 if count > 1 else 2 for count in counts)


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
