"""Cut a measured record of force and motion into the two half cycles of its last whole cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.signal import savgol_filter

from fretsolve.errors import CaseError
from fretsolve.sweep.fit.loop_file import FEWEST_POINTS
from fretsolve.system.arrays import DoubleArray, IndexArray

TURN = 0.25
"""Part of the motion's range by which it has to go back to have turned: more than noise and drift do."""

GAP = 0.05
"""Part of the motion's range that may be missing where a record of one cycle is closed, or that it may drift by."""

BEGUN = 0.02
"""Part of the motion's range before a first turn, up to which noise may have made that turn at the record's start."""

NEAR = 0.12
"""Part of a half cycle on each side of a turn that tells where the motion turned: a sine is a parabola there to within
0.1 % of its amplitude.
"""

FAR_BETTER = 6.0
"""Ratio of variances (F) from which a turn has an edge: of 200 smooth turns, noise gives one such a ratio."""

EDGE_NUMBERS = 3
"""What an edge has beside a parabola: another slope, another curvature, and its place."""

SMOOTHING = 0.1
"""Part of a half cycle whose parabola smooths the motion in its middle: noise of 3 % of the motion makes a loop 1 % too
soft then, 3 % without.
"""

NO_MORE_THAN_NOISE = 1.5
"""Ratio to the noise up to which smoothing took out noise alone: noise of a short record is known this well."""

SMOOTHED = 25
"""Points of a smoothed half cycle, of which the others are means: as many as a solved half cycle has."""

EVEN = 0.2
"""Part of an increment that is equally long for all, so that none vanishes where the motion rests."""


class Turn(NamedTuple):
    """A point of a record at which the motion turns, the motion there (mm), and the variance of that motion over the
    variance of noise.
    """

    place: float
    motion: float
    variance: float


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """The last whole cycle of a record: force (N) and motion (mm) ``(n,)``, from a turn to the next and back.

    ends: the motion at the three turns; branch: 0 or 1, the half cycle of each point; time: its place in the record,
    in cycles. hidden: what smoothing has taken out of
    the motion ``(n,)``, whose noise would make a loop less steep. errors: by how much the motion ``(n,)`` and half the
    way between the turns (mm) are off where one of the turns, or the drift of a closed record, is off by its error.
    """

    force: DoubleArray
    motion: DoubleArray
    branch: IndexArray
    time: DoubleArray
    ends: tuple[float, float, float]
    hidden: DoubleArray
    errors: list[tuple[DoubleArray, float]]

    def way(self, branch: int, count: int) -> tuple[float, ...]:
        """Return `count` motions along a half cycle, the last one at its end: closer where the force changes more."""
        start, end = self.ends[branch : branch + 2]
        here, window = self.branch == branch, max(1, int(np.count_nonzero(self.branch == branch)) // SMOOTHED)
        smooth = [np.convolve(one[here], np.full(window, 1.0 / window), "valid") for one in (self.motion, self.force)]
        motion, force = (np.maximum.accumulate(np.sign(end - start) * one) for one in smooth)
        moved = np.clip(np.sign(end - start) * motion, min(start, end), max(start, end))
        equal = np.linspace(0.0, 1.0, count + 1)[1:]
        done = 0.5 * (_part(force) + _part(motion))
        graded = np.interp(equal, done, (moved - start) / (end - start))
        places = EVEN * equal + (1.0 - EVEN) * graded
        return (*(start + (end - start) * places[:-1]).tolist(), end)

    def corrected(self, parts: DoubleArray) -> MeasuredLoop:
        """Return the loop with a part ``(k,)`` of each of its errors added."""
        pairs = list(zip(parts, self.errors, strict=True))
        longer = 1.0 + sum(part * reach for part, (_, reach) in pairs) / self.reach
        middle = 0.5 * (self.ends[0] + self.ends[1])
        first, turn, last = (middle + longer * (end - middle) for end in self.ends)
        moved = self.motion + sum(part * motion for part, (motion, _) in pairs)
        return replace(self, motion=moved, ends=(first, turn, last))

    @property
    def reach(self) -> float:
        """Half the way between the turns."""
        return _reach(self.ends)

    @property
    def range(self) -> float:
        """The range of the force."""
        return float(np.ptp(self.force))


def cut(force: DoubleArray, motion: DoubleArray, path: Path, *, offset: bool) -> MeasuredLoop:
    """Return the last whole cycle of a record. path: of the file, for messages.

    offset: whether zero and drift of the motion mean nothing. The motion is then about the middle of the cycle, and
    what it drifts over the cycle is taken out, so that it ends where it began. Raises CaseError without a whole cycle.
    """
    parts, turns, closed = _last_cycle(motion, path)
    order, branch = np.concatenate(parts), np.repeat((0, 1), [len(part) for part in parts])
    motion_noise = noise_of(motion)
    smooth = _smoothed(motion, parts, motion_noise)[order]
    moved, ends = _placed(smooth, order, turns, offset)
    errors = []
    for place, turn in enumerate(turns):
        off = turn._replace(motion=turn.motion + motion_noise * math.sqrt(turn.variance))
        others = _placed(smooth, order, [*turns[:place], off, *turns[place + 1 :]], offset)
        errors.append((others[0] - moved, _reach(others[1]) - _reach(ends)))
    if closed and offset:
        # a drift and what is missing where the record is closed look the same
        others = _placed(smooth, order, turns, offset, GAP * float(np.ptp(smooth)))
        errors.append((others[0] - moved, _reach(others[1]) - _reach(ends)))
    return MeasuredLoop(force[order], moved, branch, order / len(order), ends, motion[order] - smooth, errors)


def _placed(
    motion: DoubleArray, order: IndexArray, turns: Sequence[Turn], offset: bool, drift: float = 0.0
) -> tuple[DoubleArray, tuple[float, float, float]]:
    """Return the motion of a cycle about its middle and without drift, and so its turns; as they are without `offset`.

    The drift is what a turn and its return one cycle later differ by, and `drift` (mm per cycle) beside it.
    """
    first, middle, last = turns
    if not offset:
        return motion, (first.motion, middle.motion, last.motion)
    trend = (last.motion - first.motion) / (last.place - first.place) if last.place != first.place else 0.0
    trend += drift / len(order)
    turned = middle.motion - trend * (middle.place - first.place)
    zero = 0.5 * (first.motion + turned)
    return motion - trend * (order - first.place) - zero, (first.motion - zero, turned - zero, first.motion - zero)


def _reach(ends: tuple[float, float, float]) -> float:
    return 0.5 * abs(ends[0] - ends[1])


def _last_cycle(motion: DoubleArray, path: Path) -> tuple[list[IndexArray], list[Turn], bool]:
    """Return the points of the two half cycles in order, the three turns, and whether the record had to be closed.

    A record of one cycle may start anywhere: its end then goes on at its start.
    """
    turns = _turns(motion)
    closed = len(turns) < 3
    whole = (1.0 - GAP) * float(np.ptp(motion)) - float(np.abs(np.diff(motion)).max())
    times = ("does not turn", "turns once", "turns twice", "turns often")[min(len(turns), 3)]
    first = _farthest(motion, np.arange(turns[0]), turns[0]) if turns else 0
    last = _farthest(motion, np.arange(turns[-1], len(motion)), turns[-1]) if turns else 0
    head, tail = (abs(motion[first] - motion[turns[0]]), abs(motion[last] - motion[turns[-1]])) if turns else (0.0, 0.0)
    if len(turns) == 1 and tail >= whole and head >= whole and last == len(motion) - 1:
        turns = [first, *turns, last]
    elif len(turns) == 1 and tail >= whole:  # and there the motion has just begun to go back
        turns, last, tail = [*turns, last], len(motion) - 1, abs(motion[-1] - motion[last])
    if len(turns) >= 3:
        start, middle, end = turns[-3:]
        parts = [np.arange(start, middle + 1), np.arange(middle + 1, end + 1)]
    elif len(turns) == 2 and head + tail >= whole:
        start, middle = turns
        end, way = start, np.sign(motion[start] - motion[middle])
        before = np.arange(first, start)
        before = before[way * (motion[before] - motion[last]) > 0.0]
        parts = [np.arange(start, middle + 1), np.r_[middle + 1 : last + 1, before]]
    else:
        message = f"holds no whole cycle: the motion {times}; a motion there and back is needed"
        raise CaseError(message, (), path)
    if (fewest := sum(map(len, parts))) < FEWEST_POINTS:
        message = f"the last whole cycle has {fewest} points; at least {FEWEST_POINTS} are needed"
        raise CaseError(message, (), path)
    width = max(3, round(NEAR * min(abs(middle - start), abs(middle - end))))
    return parts, [_turn(motion, turn, width) for turn in (start, middle, end)], closed


def _farthest(motion: DoubleArray, points: IndexArray, turn: int) -> int:
    """Return which of some points is farthest from a turn."""
    return int(points[np.argmax(np.abs(motion[points] - motion[turn]))]) if len(points) else turn


def _part(rising: DoubleArray) -> DoubleArray:
    """Return a rising curve from 0 to 1, or zeros where it does not rise."""
    span = float(np.ptp(rising))
    found: DoubleArray = (rising - rising[0]) / span if span else np.zeros_like(rising)
    return found


def _turns(motion: DoubleArray) -> list[int]:
    """Return the points at which a motion turns, however noisy it is: its extremes between large ways back."""
    least, found, way = TURN * float(np.ptp(motion)), list[int](), 0
    high = low = 0
    for index, value in enumerate(motion):
        high = index if value > motion[high] else high
        low = index if value < motion[low] else low
        if way >= 0 and motion[high] - value > least:
            found, way, low = [*found, high], -1, index
        elif way <= 0 and value - motion[low] > least:
            found, way, high = [*found, low], 1, index
    # the first one may be where the record starts
    return [turn for turn in found if np.ptp(motion[: turn + 1]) > BEGUN * np.ptp(motion)]


def _turn(motion: DoubleArray, turn: int, width: int) -> Turn:
    """Return where a motion turns, and the motion there, both near the point `turn`, which noise has chosen.

    That is the extreme of a parabola through the points near it, or, where that fits far better, of two parabolas that
    meet at an edge, as a triangular motion has. width: points on each side.
    """
    near = np.arange(max(0, turn - width), min(len(motion), turn + width + 1))
    way = float(np.sign(motion[turn] - np.mean(motion[near])))
    error, found = _extreme(_parabola, (near - turn) / width, motion[near], way)
    edges = []
    for place in range(turn - width // 2, turn + width // 2 + 1, 1 + width // 20):
        least, edge = _extreme(_edge, (near - place) / width, motion[near], way)
        edges.append((least, edge._replace(place=place + edge.place * width)))
    least, edge = min(edges, key=lambda one: one[0])
    freedom = max(len(near) - 3 - EDGE_NUMBERS, 1)
    found = found._replace(place=turn + found.place * width)
    found = edge if (error - least) * freedom > EDGE_NUMBERS * FAR_BETTER * least else found
    return found._replace(place=int(np.clip(round(found.place), near[0], near[-1])))


def _parabola(x: DoubleArray) -> DoubleArray:
    return np.stack([np.ones_like(x), x, x**2], axis=1)


def _edge(x: DoubleArray) -> DoubleArray:
    before, after = np.minimum(x, 0.0), np.maximum(x, 0.0)
    return np.stack([np.ones_like(x), before, before**2, after, after**2], axis=1)


def _extreme(
    curve: Callable[[DoubleArray], DoubleArray], x: DoubleArray, values: DoubleArray, way: float
) -> tuple[float, Turn]:
    """Return the squared error of the curve that fits `values` at `x` best, and its extreme with the place in `x`."""
    inverse = np.linalg.pinv(curve(x))
    found = inverse @ values
    fine = np.linspace(x[0], x[-1], 10 * (len(x) - 1) + 1)
    place = int(np.argmax(way * (curve(fine) @ found)))
    row = curve(fine[place : place + 1])[0]
    error = float(np.sum((curve(x) @ found - values) ** 2))
    return error, Turn(float(fine[place]), float(row @ found), float(np.sum((row @ inverse) ** 2)))


def _smoothed(motion: DoubleArray, parts: Sequence[IndexArray], noise: float) -> DoubleArray:
    """Return a motion whose half cycles are smooth, where smoothing takes out no more than noise."""
    found = motion.copy()
    for part in parts:
        window = round(SMOOTHING * len(part)) | 1
        for piece in np.split(part, np.flatnonzero(np.diff(part) != 1) + 1):
            if 5 <= window <= len(piece):
                smooth = savgol_filter(motion[piece], window, 2)
                found[piece] = smooth if np.std(smooth - motion[piece]) <= NO_MORE_THAN_NOISE * noise else motion[piece]
    return found


def noise_of(record: DoubleArray) -> float:
    """Return the standard deviation of noise on a smooth record, by the median of third differences.

    Third differences have 20 times the variance of noise; the median leaves out the few at turns.
    """
    return float(np.median(np.abs(np.diff(record, 3)))) / (0.6745 * math.sqrt(20.0))
