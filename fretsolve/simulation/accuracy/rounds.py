"""The rounds of an accuracy: judge a round by its error bars, and pick the points and increments of the next one.

The first round is as coarse as error bars allow. The next one takes the cheapest points and increments with which all
bars would be within the accuracy, if the part of the cells falls by `POINTS_ORDER` and the part of the increments by
first order, but at most twice as many of each: bars of coarse runs are too wide, so a leap would go too far.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fretsolve.case.dimensions import cell_counts
from fretsolve.case.keys.accuracy_spec import OF_WORN
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.problem.setup.cost_estimate import estimate, require_memory, rounded_time
from fretsolve.problem.setup.picked_settings import Picks, points_of_cells
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import stage_ends
from fretsolve.result.verdict import POINTS_ORDER, USUAL, Cycles, Judged, Verdict, judged, scales, verdict
from fretsolve.simulation.problem_setup import set_up
from fretsolve.system.arrays import DoubleArray

AIM = 0.8
"""Part of the accuracy at which a round aims: orders are estimates, and a round that misses narrowly is lost."""

MOST_FINER = 2.0
"""The most times as many points per side, or increments, in the next round."""

IN_VAIN = 0.9
"""Part of the errors by the increments that is left after two rounds with more increments, from which on more of them
are in vain: by first order it is a half or less."""

UNKNOWN = 1.0
"""Error of the first round, over the scale, where only another round can show it."""

POINTS_TRIED, INCREMENTS_TRIED = np.geomspace(1.0, 32.0, 48), np.geomspace(1.0, 32.0, 11)
"""Factors on the points per side and on the increments that are considered, also beyond the next round. By the first
one above 1 each stage gets an increment more."""


@dataclass(frozen=True)
class Record:
    """A round that is done: its picks, its increments, its worst bar with the quantity, and the seconds it took.

    by_increments: the largest part of a bar by the increments, over the scale;
    at_end: where there are no error bars, the value of each quantity at the end.
    """

    points: tuple[int, int]
    refinement: float
    increments: int
    worst: float
    quantity: str
    by_increments: float
    seconds: float
    at_end: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Round:
    """A round to be solved. asked: the case as it was read; before: the rounds that are done."""

    asked: Case
    setup: ProblemSetup
    before: tuple[Record, ...] = ()

    @property
    def picks_points(self) -> bool:
        """True if the case leaves the points out."""
        return self.asked.grid.points is None

    @property
    def picks_increments(self) -> bool:
        """True if the case leaves out numbers of increments, and their factor, that matter."""
        automatic = any(stage.increments is None for stage in self.asked.stages())
        given = "refinement" in self.asked.solver.model_fields_set
        return automatic and self.setup.load_path.path_dependent and not given


@dataclass(frozen=True)
class End:
    """Why there is no further round: the accuracy is met, or `reason` says what is missing."""

    verdict: Verdict | None
    reason: str = ""


def first_round(case: Case, compiled: bool | None = None) -> Round:
    """Return the first round of a case; without an accuracy it is the only one."""
    return Round(case, set_up(case, compiled))


def next_round(done: Round, history: Mapping[str, DoubleArray], cycles: Cycles, seconds: float) -> Round | End:
    """Return the round that follows a round that is done, or why there is none.

    history: of the round; cycles: returns the columns of its table of cycles; seconds: that the round took.
    """
    accuracy, setup = done.asked.solver.accuracy, done.setup
    if accuracy is None or not (setup.case.solver.error_bars or setup.case.wear is not None):
        return End(None)
    at_end: dict[str, float] = {}
    if setup.case.solver.error_bars:
        bars = judged(accuracy.of, history, cycles)
    else:
        bars, at_end = _against_the_last_round(done, history)
    found = verdict(accuracy.target, bars, history, setup.grid.shape[: len(setup.grid.axes)])
    if found.met or math.isnan(found.worst):
        return End(found)
    bounded = [one for one in bars if one.quantity not in found.unbounded]
    finer = _finer(done, bounded)
    if isinstance(finer, str):
        return End(found, finer)
    picked = setup.case.solver.refinement or 1.0, setup.load_path.increments
    record = Record(setup.grid.shape, *picked, found.worst, found.quantity, _by_increments(bounded), seconds, at_end)
    following = Round(done.asked, set_up(done.asked, setup.compiled, finer), (*done.before, record))
    reason = _beyond(done, following, seconds)
    return End(found, reason) if reason else following


def _against_the_last_round(done: Round, history: Mapping[str, DoubleArray]) -> tuple[list[Judged], dict[str, float]]:
    """Return error bars at the end where no coarse runs give them, as with wear, and the values that they belong to.

    The error is taken to fall with the first power of the cells' side from the last round to this one. In the first
    round it is unknown, and counts as `UNKNOWN`. Stages in between stand for different cycles in each round.
    """
    accuracy, setup = done.asked.solver.accuracy, done.setup
    assert accuracy is not None
    last, ends = done.before[-1] if done.before else None, stage_ends(history["stage"])
    known, end = scales(history, ends), ends[-1:]
    at_end = {name: float(history[name][end[0]]) for name in accuracy.of or (*USUAL, *OF_WORN) if known.get(name)}
    errors = dict.fromkeys(at_end, UNKNOWN)
    if last is not None:
        ratio = (math.prod(setup.grid.shape) / math.prod(last.points)) ** (1.0 / len(setup.grid.axes))
        ratio = max(ratio, (setup.case.solver.refinement or 1.0) / last.refinement)
        errors = {
            name: abs(value - last.at_end[name]) / (known[name] * (ratio - 1.0)) for name, value in at_end.items()
        }
    number = history["stage"][end].astype(int)
    bars = [
        Judged(name, name, known[name], np.array([error]), np.zeros(1), number, end) for name, error in errors.items()
    ]
    return bars, at_end


def _finer(done: Round, bars: Sequence[Judged]) -> Picks | str:
    """Return finer points or increments, or why there are none."""
    setup, accuracy = done.setup, done.asked.solver.accuracy
    assert accuracy is not None
    refinement, error_bars = setup.case.solver.refinement or 1.0, setup.case.solver.error_bars
    finest = points_of_cells(setup.closed_forms, setup.grid.size, max(_cell(setup) / MOST_FINER, _finest_cell(setup)))
    at_spacing = math.prod(finest) <= math.prod(setup.grid.shape)
    more_points = done.picks_points and not at_spacing
    more_increments = done.picks_increments and error_bars and not _increments_are_in_vain(done, bars)
    cells, increments = _factors(setup, bars, accuracy.target, (more_points, more_increments))
    if not error_bars and done.picks_increments:  # the errors of both are seen as one
        increments = cells
    if cells == increments == 1.0:
        return _why_not_finer(done, at_spacing and done.picks_points, done.picks_increments and not more_increments)
    points = setup.grid.shape
    if cells > 1.0:
        points = points_of_cells(setup.closed_forms, setup.grid.size, max(_cell(setup) / cells, _finest_cell(setup)))
    return Picks(points, refinement * increments)


def _why_not_finer(done: Round, at_spacing: bool, in_vain: bool) -> str:
    """Return why a round is not followed by a finer one. at_spacing, in_vain: whether cells, increments have an end."""
    if at_spacing:
        return "its cells are as small as the spacing of the height map, below which nothing is known"
    if in_vain:
        return "more increments, twice, have hardly made the error by the increments smaller"
    given = {"points": not done.picks_points, "increments": done.setup.load_path.path_dependent}
    return f"the case gives its {' and '.join(name for name, is_given in given.items() if is_given)}, which are kept"


def _increments_are_in_vain(done: Round, bars: Sequence[Judged]) -> bool:
    """Return whether two rounds with more increments have hardly made the errors by the increments smaller.

    Errors by increments that the case gives for some stages stay, however many others there are.
    """
    used = [*(one.refinement for one in done.before[-2:]), done.setup.case.solver.refinement or 1.0]
    if len(used) < 3 or not used[0] < used[1] < used[2]:
        return False
    return _by_increments(bars) > IN_VAIN * done.before[-2].by_increments


def _by_increments(bars: Sequence[Judged]) -> float:
    """Return the largest part of an error bar by the increments, over the scale."""
    return max(float(np.nan_to_num(one.by_increments).max()) for one in bars)


def _cell(setup: ProblemSetup) -> float:
    return max(side / count for side, count in zip(setup.grid.size, setup.grid.shape, strict=True))


def _finest_cell(setup: ProblemSetup) -> float:
    """Return the least spacing (mm) of the height maps, 0 without maps."""
    if all(surface.kind != "heights" for surface in setup.case.surface):
        return 0.0
    return min(min(one.spacing) for one in setup.heights().maps)


def _factors(
    setup: ProblemSetup, bars: Sequence[Judged], target: float, may_grow: tuple[bool, bool] = (True, True)
) -> tuple[float, float]:
    """Return the factors on points per side and on increments with which all bars are cheapest within the target.

    may_grow: whether points and increments may. Both factors are 1 where the one that may not leaves too large bars.
    """
    if _left(bars, *(np.array(math.inf if may else 1.0) for may in may_grow)) > target:
        return 1.0, 1.0
    by_points, by_increments = (
        tried if may else tried[:1] for tried, may in zip((POINTS_TRIED, INCREMENTS_TRIED), may_grow, strict=True)
    )
    by_points = by_points[:, None]
    # Applications per increment grow with the root of the points per side.
    cost = by_points ** (len(setup.grid.axes) + 0.5) * by_increments
    enough = np.where(_left(bars, by_points, by_increments) <= AIM * target, cost, math.inf)
    at, of = np.unravel_index(np.argmin(enough), cost.shape) if np.isfinite(enough).any() else (-1, -1)
    return min(float(by_points[at, 0]), MOST_FINER), min(float(by_increments[of]), MOST_FINER)


def _left(bars: Sequence[Judged], by_points: DoubleArray, by_increments: DoubleArray) -> DoubleArray:
    """Return the largest bar that factors on points per side and on increments leave, over the scale."""
    left = np.zeros(np.broadcast_shapes(by_points.shape, by_increments.shape))
    for one in bars:
        by_cells = np.sqrt(np.maximum(one.bars**2 - one.by_increments**2, 0.0))
        for cell, increment in zip(by_cells, one.by_increments, strict=True):
            left = np.maximum(left, np.hypot(cell * by_points**-POINTS_ORDER, increment / by_increments))
    return left


def _beyond(done: Round, following: Round, seconds: float) -> str:
    """Return which limit the next round would go beyond, and what it would cost; empty if none."""
    accuracy, setup = following.asked.solver.accuracy, following.setup
    assert accuracy is not None
    most, count = accuracy.at_most, math.prod(setup.grid.shape)
    expected = seconds * estimate(setup).seconds / estimate(done.setup).seconds
    cost = f"{cell_counts(setup.grid.shape)} points and about {rounded_time(expected)}"
    if count > most.cells:
        return f"the next round would take {cost}, and at_most.cells is {most.cells}"
    spent = sum(one.seconds for one in following.before)
    if most.time is not None and spent + expected > most.time:
        return f"the next round would take {cost} after {rounded_time(spent)}, and at_most.time is {most.time:g} s"
    try:
        require_memory(setup)
    except CaseError as error:
        return f"the next round would take {cost}: {error.message}"
    return ""


def seconds_of(history: Mapping[str, DoubleArray]) -> float:
    """Return the seconds that a round took, with its coarse runs."""
    names = ("wall_time", "coarse_runs_wall_time")
    return float(sum(history[name].sum() for name in names if name in history))
