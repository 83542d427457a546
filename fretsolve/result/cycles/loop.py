"""Measure one loop of force over displacement: its width, its ends and its slopes.

A loop is known at the ends of increments only. Each measure comes with the error that this leaves, from the shape of a
branch: after a reversal the compliance grows with the force, so that the curve lies between the chord of an increment
and the chords beside it, continued.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fretsolve.system.arrays import DoubleArray

OF_A_PARABOLA = 0.25
"""Distance of a parabola from the chord of an increment over the distance from there to the chord beside it, continued,
in the middle of equal increments."""

ROUNDING = 1e-9
"""Largest change of the force over its range that is rounding."""

FEWEST_INCREMENTS = 8
"""Increments from which the polygon through them tells the area of a loop: two for each quarter of it."""

LEAST_COMPLIANCE = 0.5
"""Least extrapolated compliance at a reversal over that of the first increment: where the increment has more slip than
elastic displacement, its points do not tell the slope."""


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
    """Return by how much the largest and smallest value may lie beyond those at the ends of increments.

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
    return Measure(whole, abs(whole - coarse) if len(force) > FEWEST_INCREMENTS else math.inf)
