"""Find the cycles of a load path in a history, how far the last one is from the limit of all, and measure their loops.

A cycle is one repetition of an innermost `cycle` of the load path. Its loop of force over displacement is known at the
ends of increments only. Each measure of a loop comes with the error that this leaves, from the shape of a branch: after
a reversal the compliance grows with the force, so that the curve lies between the chord of an increment and the chords
beside it, continued.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.history import PAIRS
from fretsolve.result.layout import has_cycles
from fretsolve.result.verdict import LEAST_MOTION_SCALE, ROUNDING
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.case.keys.unrolled_path import Stage


History = Mapping[str, NDArray[Any]]

CHANGE_COLUMNS = ("stage", "contact_radius", "work_total", *(name for pair in PAIRS for name in pair))
"""Columns that `distance_to_limit` needs."""

ENERGY = "dissipated energy"
"""The name of the energy among the changes."""

MOST_CHANGES = 100.0
"""Largest distance to the limit over the last change. It holds where one change alone is known, and where two are the
noise of the solver, whose ratio says nothing."""


@dataclass(frozen=True, slots=True)
class CycleSteps:
    """A cycle in a history: from the increment `first` (-1: the start) to `last`.

    number: of the cycles in the history, from 1; run: which `cycle` of the load path, from 1; turn: which repetition of
    that cycle; until: the tolerance of a cycle that runs until it is periodic, most: its most repetitions. moved:
    components that its stages name; key: where it stands in the case.
    """

    number: int
    first: int
    last: int
    run: int
    turn: int
    until: float | None
    moved: frozenset[str]
    key: str
    most: int


@dataclass(frozen=True)
class LimitDistance:
    """The estimated distance of a cycle from the limit of its repetitions.

    energy: distance of the dissipated energy, over itself; value: distance of the value at the end that is farthest,
    `name`, over the range of its kind in the cycle.
    """

    energy: float
    value: float
    name: str

    @property
    def largest(self) -> float:
        """The larger one of both."""
        return max(self.energy, self.value)


def stages_of(effective_case: Mapping[str, Any]) -> tuple[Stage, ...]:
    """Return the stages of a case, none if it has no cycle or is not understood."""
    if not has_cycles(effective_case):
        return ()
    from fretsolve.case.loading import stored_case

    case = stored_case(effective_case)
    return () if case is None else case.stages()


def cycles_in(stages: Sequence[Stage], stage_column: NDArray[Any], *, ended: bool = True) -> list[CycleSteps]:
    """Return the cycles that a history holds whole. ended: whether its last stage has ended."""
    ends = np.flatnonzero(np.append(np.diff(stage_column) != 0, ended))[: len(stage_column)]
    last_of = dict(zip(stage_column[ends].tolist(), ends.tolist(), strict=True))
    first_of = dict(zip(*np.unique(stage_column, return_index=True), strict=True)) if len(stage_column) else {}
    members: dict[tuple[int, int], list[Stage]] = {}
    most: dict[int, int] = {}
    for stage in stages:
        if stage.cycle is not None:
            members.setdefault((stage.cycle.cycle, stage.cycle.turn), []).append(stage)
            most[stage.cycle.cycle] = stage.cycle.turn
    found: list[CycleSteps] = []
    alike: dict[object, Any] = {}  # repetitions share what they have in common
    for (run, turn), inside in members.items():
        if all(stage.number in last_of for stage in inside):
            one = inside[0].cycle
            assert one is not None  # see above
            moved = frozenset(name for stage in inside for name, _ in stage.targets if name != "friction")
            first, last = int(first_of[inside[0].number]) - 1, last_of[inside[-1].number]
            moved, key = (alike.setdefault(of, of) for of in (moved, ".".join(map(str, one.key))))
            found.append(CycleSteps(len(found) + 1, first, last, run, turn, one.until, moved, key, most[run]))
    return found


def distance_to_limit(history: History, cycles: Sequence[CycleSteps]) -> LimitDistance:
    """Return how far the last of `cycles`, two or three in a row, is from the limit of all repetitions.

    The changes d from cycle to cycle are taken to die out as a power of the number k of cycles, or faster. With the
    ratio r of the last two, what all later cycles change is then at most d/(1 - r - 1/k) (Raabe's test of a series).
    history: has `CHANGE_COLUMNS`.
    """
    scales = _scales(history, cycles[-1])
    changes = [_changes(history, before, now, scales) for before, now in pairwise(cycles)]
    left = {name: _left([one[name] for one in changes], cycles[-1].turn) for name in changes[-1]}
    energy = left.pop(ENERGY)
    worst = max(left, key=left.__getitem__, default="P")
    return LimitDistance(energy, left.get(worst, 0.0), worst)


def _left(changes: Sequence[float], turn: int) -> float:
    """Return what is left to the limit after the last of one or two changes, that to the repetition `turn`.

    The larger change counts: the last one may be small because a value turns there.
    """
    if len(changes) < 2 or changes[0] == 0.0:
        return MOST_CHANGES * changes[-1]
    falling = 1.0 - changes[1] / changes[0] - 1.0 / turn
    return max(changes) * (min(MOST_CHANGES, 1.0 / falling) if falling > 0.0 else MOST_CHANGES)


def _changes(history: History, before: CycleSteps, now: CycleSteps, scales: Mapping[str, float]) -> dict[str, float]:
    """Return the changes from one cycle to the next: of the energy over itself, of values at the end over `scales`."""
    energies = [change_within(history["work_total"], one) for one in (before, now)]
    largest = max(map(abs, energies))
    found = {ENERGY: abs(energies[1] - energies[0]) / largest if largest else 0.0}
    for name, scale in scales.items():
        found[name] = float(np.nan_to_num(abs(history[name][now.last] - history[name][before.last]))) / scale
    return found


def _scales(history: History, cycle: CycleSteps) -> dict[str, float]:
    """Return the ranges above 0 in a cycle, over which loads and displacements at its end are measured."""
    rows = slice(max(cycle.first, 0), cycle.last + 1)

    def span(*names: str) -> float:
        return max(float(np.nan_to_num(np.ptp(history[name][rows]))) for name in names)

    radius, force, approach = (
        float(np.nan_to_num(abs(history[n][rows]).max())) for n in ("contact_radius", "P", "delta_z")
    )
    shear = max(span("Qx", "Qy"), span("Mz") / radius if radius else 0.0, LEAST_MOTION_SCALE * force)
    motion = max(span("delta_x", "delta_y"), span("phi_z") * radius, LEAST_MOTION_SCALE * approach)
    scales = {"P": force, "Mx": force * radius, "My": force * radius, "Qx": shear, "Qy": shear, "Mz": shear * radius}
    scales |= dict.fromkeys(("delta_z", "delta_x", "delta_y"), motion)
    scales |= dict.fromkeys(("phi_x", "phi_y", "phi_z"), motion / radius if radius else 0.0)
    return {name: scale for name, scale in scales.items() if scale > 0.0}


def change_within(column: NDArray[Any], cycle: CycleSteps) -> float:
    """Return the value of a column at the end of a cycle less that at its beginning."""
    return float(column[cycle.last]) - (float(column[cycle.first]) if cycle.first >= 0 else 0.0)


OF_A_PARABOLA = 0.25
"""Distance of a parabola from the chord of an increment over the distance from there to the chord beside it, continued,
in the middle of equal increments."""

LEAST_COMPLIANCE = 0.5
"""Least extrapolated compliance at a reversal over the first increment's compliance: where the increment has more slip
than elastic displacement, its points do not tell the slope."""


class Measure(NamedTuple):
    """A measure of a loop and its error by the increments, NaN where the increments do not tell it."""

    value: float
    error: float


UNKNOWN = Measure(math.nan, math.nan)


def ends_of_loop(motion: DoubleArray) -> tuple[int, int]:
    """Return the places of the ends of a loop, the first one first."""
    low, high = int(motion.argmin()), int(motion.argmax())
    return min(low, high), max(low, high)


def half_width(force: DoubleArray, motion: DoubleArray, begin: int, end: int) -> Measure:
    """Return half of the width of a loop at the mean of its largest and smallest force.

    begin, end: the places of its ends, between which one branch lies; the other one is what is left.
    """
    middle = 0.5 * float(force.max() + force.min())
    rest = slice(0, begin + 1 if begin else 0)  # of the branch back, where the cycle begins within it
    back_force, back_motion = (np.concatenate([one[end:], one[rest]]) for one in (force, motion))
    going = _crossing(force[begin : end + 1], motion[begin : end + 1], middle)
    coming = _crossing(back_force, back_motion, middle)
    return Measure(0.5 * abs(going.value - coming.value), 0.5 * (going.error + coming.error))


def _crossing(force: DoubleArray, motion: DoubleArray, middle: float) -> Measure:
    """Return the motion where a branch of two increments or more, from its reversal on, first crosses a force."""
    over = force - middle
    crossed = np.flatnonzero((over[:-1] * over[1:] <= 0.0) & (over[:-1] != over[1:]))
    if not len(crossed) or len(force) < 3:
        return UNKNOWN
    at = int(crossed[0])

    def on_chord(first: int) -> float:
        rise = force[first + 1] - force[first]
        return float(motion[first] - over[first] / rise * (motion[first + 1] - motion[first])) if rise else math.nan

    # The motion at the reversal stands for a chord before the first one: no motion goes back there.
    beside = [on_chord(at - 1) if at else float(motion[0]), on_chord(at + 1) if at + 2 < len(force) else math.nan]
    chord, (low, high) = on_chord(at), sorted(motion[at : at + 2].tolist())
    # Within the increment the motion does not leave its ends; a chord that rises by a rounding does.
    ways = sorted((min(max(one, low), high) - chord for one in beside if math.isfinite(one)), key=abs)
    return Measure(chord + OF_A_PARABOLA * ways[0], (1.0 - OF_A_PARABOLA) * abs(ways[0])) if ways else UNKNOWN


def reversal_stiffness(force: DoubleArray, motion: DoubleArray) -> Measure:
    """Return the mean slope of a loop just after its reversals.

    The compliance over the first one and two increments after a reversal grows in proportion to the force at first, as
    slip begins at the edge; so the slope at the reversal follows from both. Since the compliance grows ever faster, the
    slope lies between this one and the slope of the first increment.
    """
    # Where the force is held, rounding turns the motion.
    least = ROUNDING * float(np.ptp(force))
    turns = [turn for turn in _reversals(motion) if abs(force[turn + 1] - force[turn]) > least]
    found = [_stiffness_after(force[turn:], motion[turn:]) for turn in turns]
    if not found:
        return UNKNOWN
    return Measure(float(np.mean([one.value for one in found])), max(one.error for one in found))


def _reversals(motion: DoubleArray) -> list[int]:
    """Return the places where a motion turns; the first place if the loop, once closed, turns there."""
    steps = np.diff(motion)
    moving = np.flatnonzero(steps)
    signs = np.sign(steps[moving])
    turns = moving[1:][signs[1:] != signs[:-1]].tolist()
    return [0, *turns] if len(moving) and signs[0] != signs[-1] else turns


def _stiffness_after(force: DoubleArray, motion: DoubleArray) -> Measure:
    """Return the slope at the first place, from the first two increments after it."""
    forces, motions = np.abs(force[1:3] - force[0]), np.abs(motion[1:3] - motion[0])
    if len(forces) < 2 or not 0.0 < forces[0] < forces[1] or not motions[0] > 0.0:
        return UNKNOWN
    near, far = (motions / forces).tolist()
    compliance = near - (far - near) * float(forces[0] / (forces[1] - forces[0]))
    if compliance < LEAST_COMPLIANCE * near:
        return UNKNOWN
    return Measure(1.0 / compliance, abs(1.0 / compliance - 1.0 / near))


def range_error(values: DoubleArray, stage: DoubleArray) -> float:
    """Return by how much the largest and smallest value may lie beyond the values at the ends of increments.

    They do not where a stage ends with them, since the load turns there. stage: of each value.
    """
    return sum(_peak_error(sign * values, stage) for sign in (1.0, -1.0))


def _peak_error(values: DoubleArray, stage: DoubleArray) -> float:
    """Return by how much a parabola through the largest value and its neighbours rises above that value, at most."""
    at = int(values.argmax())
    if not 0 < at < len(values) - 1 or stage[at] != stage[at + 1]:
        return 0.0
    return float(2.0 * values[at] - values[at - 1] - values[at + 1]) / 8.0


def area(force: DoubleArray, motion: DoubleArray) -> Measure:
    """Return the area that a loop encloses, and its error from every other point: unbounded where there are few."""
    some = np.unique([*range(0, len(force), 2), len(force) - 1])
    whole, coarse = (
        abs(0.5 * float(np.dot(force[at][1:] + force[at][:-1], np.diff(motion[at])))) for at in (slice(None), some)
    )
    many = len(force) > 8  # two increments or more for each quarter of the loop
    return Measure(whole, abs(whole - coarse) if many else math.inf)
