"""Companion runs: a case on half of the points per side, and there with other numbers of increments as well.

They are advanced as far as the run that they accompany has come, so that a run can be stopped after each increment.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.errors import NoSolutionError
from fretsolve.model.grid import Grid
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import ERROR_SUFFIX, SummaryErrors
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result.state import Summary

COARSER = 2
"""Cells of the run along a side of one of its companions' cells."""

LOOSER, LOOSEST = 10.0, 1e-4
"""A companion's tolerance in units of the run's, and its limit. That shifts values by some 1e-6 of theirs, well below
what the companions are to tell, and saves a quarter of their work."""


ESTIMATED = tuple(
    field.name.removesuffix(ERROR_SUFFIX) for field in fields(SummaryErrors) if field.name.endswith(ERROR_SUFFIX)
)
"""What has error bars, in the order in which values are handled here."""


def values_of(summary: Summary) -> DoubleArray:
    """The values of `ESTIMATED`, in their order."""
    return np.array([getattr(summary, name) for name in ESTIMATED])


@dataclass(frozen=True)
class Place:
    """A point of the load path: the share `part` of the stage `stage` (0-based)."""

    stage: int
    part: float


class Companion:
    """The run of a coarser scene, as far as it was asked for. failure: why it goes no farther, if that is so.

    applications: of the elastic operator so far, those of the scene's grid; seconds: what they took.
    """

    def __init__(self, setup: ProblemSetup, threads: int):
        self.setup = setup
        self.failure: NoSolutionError | None = None
        self.applications, self.seconds = 0, 0.0
        self._states = run(setup, threads=threads)
        self._values: list[DoubleArray] = []

    def values(self, step: int) -> DoubleArray | None:
        """Those after the increment `step`; zeros before the first one, None where the companion does not get there."""
        if step < 0:
            return np.zeros(len(ESTIMATED))
        while len(self._values) <= step and self.failure is None:
            self._advance()
        return self._values[step] if step < len(self._values) else None

    def values_at(self, place: Place) -> DoubleArray | None:
        """DoubleArray at a point of the load path, between increments in proportion."""
        counts = self.setup.load_path.counts
        step = sum(counts[: place.stage]) + place.part * counts[place.stage] - 1.0
        low, high = math.floor(step + 1e-9), math.ceil(step - 1e-9)
        before, after = self.values(low), self.values(high)
        if before is None or after is None:
            return None
        return before + (step - low) * (after - before) if high > low else before

    def _advance(self) -> None:
        began = time.perf_counter()
        try:
            summary = next(self._states).summary
        except NoSolutionError as error:
            self.failure = error
        else:
            self._values.append(values_of(summary))
            self.applications += summary.operator_applications
        self.seconds += time.perf_counter() - began


def coarser(setup: ProblemSetup, counts: tuple[int, ...]) -> ProblemSetup:
    """The scene on half of the points per side (rounded up) of the same area, with `counts` increments per stage."""
    nx, ny = (-(-points // COARSER) for points in setup.grid.shape)
    grid = Grid.from_size((nx, ny), setup.grid.size, setup.grid.center)
    solver = setup.case.solver
    looser = max(solver.tolerance, min(LOOSER * solver.tolerance, LOOSEST))
    case = setup.case.model_copy(update={"solver": solver.model_copy(update={"tolerance": looser})})
    return ProblemSetup(case, setup.model, grid, setup.load_path.with_counts(counts))


def fewer_increments(counts: tuple[int, ...]) -> tuple[int, ...]:
    """Half as many in each stage; two where there is one, which has no half."""
    return tuple(count // 2 if count > 1 else 2 for count in counts)


def nodes(fine: LoadPath, coarse: LoadPath, step: int) -> tuple[Place, Place, float]:
    """The points about `step` of `fine` at which `coarse` has increments too, and the share of the way to the second.

    The first may be the end of the stage before, or the start of the path, the share 0 of its first stage.
    """
    ends = fine.last_steps
    stage = next(number for number, last in enumerate(ends) if step <= last)
    count = fine.counts[stage]
    common = min(count, coarse.counts[stage])
    position = (step - ends[stage] + count) * common / count
    low = math.floor(position + 1e-9)
    high = math.ceil(position - 1e-9)
    first = Place(stage - 1, 1.0) if stage and not low else Place(stage, low / common)
    return first, Place(stage, high / common), position - low
