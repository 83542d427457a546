"""The rounds of an accuracy: judge a round by its error bars, and pick the points and increments of the next one.

The first round is as coarse as error bars allow. The next one takes the cheapest points and increments with which all
bars would be within the accuracy, if the part of the cells falls by `POINTS_ORDER` and the part of the increments by
first order, but at most twice as many of each: bars of coarse runs are too wide, so a leap would go too far.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fretsolve.case.dimensions import cell_counts
from fretsolve.case.history import USUAL, WORN
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.problem.setup.cost_estimate import estimate, require_memory, rounded_time
from fretsolve.problem.setup.picked_settings import Picks, points_of_cells
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import cost_of, stage_ends
from fretsolve.result.verdict import POINTS_ORDER, Cycles, Judged, Verdict, judged, scales, verdict
from fretsolve.simulation.problem_setup import set_up
from fretsolve.system.arrays import DoubleArray

AIM = 0.8
"""Part of the accuracy at which a round aims: orders are estimates, and a round that misses narrowly is lost."""

MOST_FINER = 2.0
"""The most times as many points per side, or increments, in the next round."""

IN_VAIN = 0.9
"""Part of the worst error bar that is left after a round, from which on the round was in vain: by first order it is 0.7
after a round with 1.4 times as many increments."""

UNKNOWN = 1.0
"""Error over the scale by which the next round is picked where none is known: a coarse run of the error bars has no
solution, or only another round can show the error."""

POINTS_TRIED, INCREMENTS_TRIED = np.geomspace(1.0, 32.0, 48), np.geomspace(1.0, 32.0, 11)
"""Factors on the points per side and on the increments that are considered, also beyond the next round. By the first
one above 1 each stage gets an increment more."""


@dataclass(frozen=True)
class Record:
    """A round that is done: its picks, its number of increments, what it is known to, and what it cost.

    worst, quantity: the worst error bar over its scale, and of what, empty where there is none; at_end: where coarse
    runs give no error bars, the values at the end.
    """

    points: tuple[int, int]
    refinement: float
    increments: int
    worst: float
    quantity: str
    seconds: float
    applications: float
    at_end: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Round:
    """A round to be solved.

    asked: the case as it was read; before: the rounds that are done; compiled: as asked of `set_up`.
    """

    asked: Case
    setup: ProblemSetup
    before: tuple[Record, ...] = ()
    compiled: bool | None = None

    @property
    def picks_points(self) -> bool:
        """True if the case leaves the points out."""
        return self.asked.grid.points is None

    @property
    def picks_increments(self) -> bool:
        """True if the case leaves out numbers of increments, and their factor, where there is more than one."""
        counts = zip(self.asked.stages(), self.setup.load_path.counts, strict=True)
        automatic = any(stage.increments is None and count > 1 for stage, count in counts)
        return automatic and "refinement" not in self.asked.solver.model_fields_set

    @property
    def picked_keys(self) -> tuple[str, ...]:
        """The keys of the case that rounds pick."""
        if self.asked.solver.accuracy is None:
            return ()
        picks = {"grid.points": self.picks_points, "solver.refinement": self.picks_increments}
        return tuple(key for key, is_picked in picks.items() if is_picked)

    @property
    def refinement(self) -> float:
        """The factor on automatic numbers of increments."""
        return self.setup.case.solver.refinement or 1.0


@dataclass(frozen=True)
class Judgement:
    """The verdict on a round, None without an accuracy, and the round that follows it, None after the last one."""

    verdict: Verdict | None
    following: Round | None = None


def first_round(case: Case, compiled: bool | None = None) -> Round:
    """Return the first round of a case; without an accuracy it is the only one."""
    return Round(case, set_up(case, compiled), compiled=compiled)


def judge(done: Round, history: Mapping[str, DoubleArray], cycles: Cycles, elapsed: float = 0.0) -> Judgement:
    """Judge a round that is done, and find the round that follows it.

    history: of the round; cycles: returns the columns of its table of cycles; elapsed: seconds since the round began,
    with its setup and its saving.
    """
    accuracy, setup = done.asked.solver.accuracy, done.setup
    if accuracy is None:
        return Judgement(None)
    at_end: dict[str, float] = {}
    if setup.case.solver.error_bars:
        bars = judged(accuracy.of, history, cycles)
    else:
        bars, at_end = _against_the_last_round(done, history)
    found = verdict(accuracy.target, bars, history, setup.grid.shape[: len(setup.grid.axes)])
    bars = [one for one in bars if one.quantity not in found.unbounded]
    if found.worst <= accuracy.target or not bars:
        return Judgement(found)
    known = (UNKNOWN, "") if math.isnan(found.worst) else (found.worst, found.quantity)
    finer = _why_in_vain(done, known[0]) or _finer(done, bars)
    if isinstance(finer, str):
        return Judgement(replace(found, reason=f"no round follows: {finer}"))
    picked = setup.grid.shape, done.refinement, setup.load_path.increments
    seconds, applications = cost_of(history)
    seconds = max(seconds, elapsed)
    record = Record(*picked, *known, seconds, applications, at_end)
    try:
        finer_setup = set_up(done.asked, done.compiled, finer)
        following = Round(done.asked, finer_setup, (*done.before, record), done.compiled)
        reason = _beyond(done, following, seconds)
    except CaseError as error:
        reason = f"the next round, on {cell_counts(finer.points)} points, has a problem: {error.message}"
    return Judgement(replace(found, reason=reason)) if reason else Judgement(found, following)


def _against_the_last_round(done: Round, history: Mapping[str, DoubleArray]) -> tuple[list[Judged], dict[str, float]]:
    """Return error bars at the end where no coarse runs give them, as with wear, and the values that they belong to.

    The error is taken to fall with the first power of the cells' side from the last round to this one; in the first
    round it is NaN. Stages in between stand for different cycles in each round.
    """
    accuracy, setup = done.asked.solver.accuracy, done.setup
    assert accuracy is not None
    last, ends = done.before[-1] if done.before else None, stage_ends(history["stage"])
    known, end = scales(history, ends), ends[-1:]
    at_end = {name: float(history[name][end[0]]) for name in accuracy.of or (*USUAL, *WORN) if known.get(name)}
    errors = dict.fromkeys(at_end, math.nan)
    if last is not None:
        ratio = (math.prod(setup.grid.shape) / math.prod(last.points)) ** (1.0 / len(setup.grid.axes))
        ratio = max(ratio, done.refinement / last.refinement)
        before = {name: last.at_end.get(name, 0.0) for name in at_end}  # what was 0 had no place in it
        errors = {name: abs(value - before[name]) / (known[name] * (ratio - 1.0)) for name, value in at_end.items()}
    number = history["stage"][end].astype(int)
    bars = [
        Judged(name, name, known[name], np.array([error]), np.zeros(1), number, end) for name, error in errors.items()
    ]
    return bars, at_end


def _finer(done: Round, bars: Sequence[Judged]) -> Picks | str:
    """Return finer points or increments, or why there are none."""
    setup, accuracy = done.setup, done.asked.solver.accuracy
    assert accuracy is not None
    why_no_points = _why_no_points(done)
    why_no_increments = "" if done.picks_increments else "the increments that matter are given"
    may_grow = not why_no_points, not why_no_increments
    cells, increments = _factors(setup, bars, accuracy.target, may_grow)
    if not setup.case.solver.error_bars and done.picks_increments:  # the errors of both are seen as one
        increments = cells
    if cells == increments == 1.0:
        parts = zip(_largest_parts(bars), (why_no_points, why_no_increments), strict=True)
        blocking = [why for part, why in parts if part > accuracy.target and why]
        return " and ".join(blocking or filter(None, (why_no_points, why_no_increments)))
    points = setup.grid.shape if cells == 1.0 else _finer_points(setup, cells)
    return Picks(points, done.refinement * increments)


def _why_no_points(done: Round) -> str:
    """Return why there cannot be more points, empty if there can."""
    if not done.picks_points:
        return "grid.points is given"
    if math.prod(_finer_points(done.setup, MOST_FINER)) <= math.prod(done.setup.grid.shape):
        return "the cells are as small as the spacing of the height map, below which nothing is known"
    return ""


def _why_in_vain(done: Round, worst: float) -> str:
    """Return why finer rounds are in vain, empty if they are not: the last two have hardly lowered the worst bar.

    So it is where the bar is of increments that the case gives for some stages. Cells that miss waves of a height map
    or of a roughness have large bars until they see the waves.
    """
    grid, known = done.setup.grid, [*(one.worst for one in done.before), worst]
    stayed = [after > IN_VAIN * before for before, after in pairwise(known[-3:])]
    if len(stayed) < 2 or not all(stayed) or done.setup.heights().flattening_pressure((grid.dx, grid.dy)) > 0.0:
        return ""
    return "the last two rounds have hardly lowered the error"


def _finer_points(setup: ProblemSetup, factor: float) -> tuple[int, int]:
    """Return the points along x and y with a factor on the points per side, on cells no less than a map's spacing."""
    cell = max(side / count for side, count in zip(setup.grid.size, setup.grid.shape, strict=True))
    finest = 0.0
    if any(surface.kind == "heights" for surface in setup.case.surface):
        finest = min(min(one.spacing) for one in setup.heights().maps)
    return points_of_cells(setup.closed_forms, setup.grid.size, max(cell / factor, finest))


def _parts(one: Judged) -> tuple[DoubleArray, DoubleArray]:
    """Return the parts of error bars by the cells and by the increments, over the scale, `UNKNOWN` where it is NaN."""
    bars = np.nan_to_num(one.bars, nan=UNKNOWN)
    return np.sqrt(np.maximum(bars**2 - one.by_increments**2, 0.0)), one.by_increments


def _largest_parts(bars: Sequence[Judged]) -> tuple[float, float]:
    """Return the largest parts of error bars by the cells and by the increments, over the scale."""
    cells, increments = zip(*map(_parts, bars), strict=True)
    return float(np.concatenate(cells).max()), float(np.concatenate(increments).max())


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
        for cell, increment in zip(*_parts(one), strict=True):
            left = np.maximum(left, np.hypot(cell * by_points**-POINTS_ORDER, increment / by_increments))
    return left


def _beyond(done: Round, following: Round, seconds: float) -> str:
    """Return which limit the next round would go beyond, and what it would cost; empty if none."""
    accuracy, setup = following.asked.solver.accuracy, following.setup
    assert accuracy is not None
    most, count = accuracy.at_most, math.prod(setup.grid.shape)
    if setup.grid.shape == done.setup.grid.shape and setup.load_path.counts == done.setup.load_path.counts:
        return "no round follows: the increments that matter are given"
    expected = seconds * estimate(setup).seconds / estimate(done.setup).seconds
    cost = f"{cell_counts(setup.grid.shape)} points and about {rounded_time(expected)}"
    if count > most.cells:
        return f"the next round would take {cost}, and at_most.cells is {most.cells}"
    spent = sum(one.seconds for one in following.before)
    if most.time is not None and spent + expected > most.time:
        return f"the next round would take {cost} after {rounded_time(spent)}, and at_most.time is {most.time:g} s"
    require_memory(setup)
    return ""


def most_memory(first: Round, needed: float) -> float:
    """Return the memory (bytes) that the rounds may take; needed: the first one's."""
    setup, accuracy = first.setup, first.asked.solver.accuracy
    if accuracy is None or not first.picks_points:
        return needed
    finer = (accuracy.at_most.cells / math.prod(setup.grid.shape)) ** (1.0 / len(setup.grid.axes))
    return estimate(replace(setup, grid=setup.grid.cut_into(*_finer_points(setup, max(finer, 1.0))))).memory


def no_solution(failed: Round, error: NoSolutionError) -> str:
    """Return why no round follows, where the one that does has no solution."""
    return f"the next round, on {cell_counts(failed.setup.grid.shape)} points, has no solution: {error}"
