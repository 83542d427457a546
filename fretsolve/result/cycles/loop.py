"""Measure one loop of force over displacement: its width and its slopes."""

from __future__ import annotations

import math

import numpy as np

from fretsolve.system.arrays import DoubleArray

STRAIGHT = 0.5
"""Second force step after a reversal over the first one from which both tell the slope at the reversal."""


def ends_of_loop(motion: DoubleArray) -> tuple[int, int]:
    """Return the places of the ends of a loop, the first one first."""
    low, high = int(motion.argmin()), int(motion.argmax())
    return min(low, high), max(low, high)


def half_width(force: DoubleArray, motion: DoubleArray, begin: int, end: int) -> float:
    """Return half of the width of a loop at the mean of its largest and smallest force.

    begin, end: the places of its ends, between which one branch lies; the other one is what is left.
    """
    middle = 0.5 * float(force.max() + force.min())
    closed_force, closed_motion = (np.concatenate([one[end:], one[1 : begin + 1]]) for one in (force, motion))
    going = _crossing(force[begin : end + 1], motion[begin : end + 1], middle)
    return 0.5 * abs(going - _crossing(closed_force, closed_motion, middle))


def _crossing(force: DoubleArray, motion: DoubleArray, middle: float) -> float:
    """Return where a branch first crosses a force, between increments along straight lines; NaN if it does not."""
    over = force - middle
    crossed = np.flatnonzero((over[:-1] * over[1:] <= 0.0) & (over[:-1] != over[1:]))
    if not len(crossed):
        return math.nan
    at = int(crossed[0])
    share = over[at] / (over[at] - over[at + 1])
    return float(motion[at] + share * (motion[at + 1] - motion[at]))


def reversal_stiffness(force: DoubleArray, motion: DoubleArray) -> tuple[float, float]:
    """Return the mean slope of a loop just after its reversals, and its error by the increments.

    The compliance over the first one and two increments after a reversal grows in proportion to the force at first, as
    slip begins at the edge; so the slope at the reversal follows from both.
    """
    turns = [0, *(np.flatnonzero(np.diff(motion)[:-1] * np.diff(motion)[1:] < 0.0) + 1).tolist()]
    slopes, errors = [], []
    for turn, following in zip(turns, [*turns[1:], len(motion) - 1], strict=True):
        steps = np.arange(turn + 1, min(following, turn + 2) + 1)
        forces, motions = np.abs(force[steps] - force[turn]), np.abs(motion[steps] - motion[turn])
        if not len(steps) or not forces[0] > 0.0 or not motions[0] > 0.0:
            continue
        compliance = near = float(motions[0] / forces[0])
        if len(steps) == 2 and forces[1] - forces[0] > STRAIGHT * forces[0]:
            far = float(motions[1] / forces[1])
            compliance = near - (far - near) * float(forces[0] / (forces[1] - forces[0]))
        if compliance > 0.0:
            slopes.append(1.0 / compliance)
            errors.append(abs(1.0 / compliance - 1.0 / near))
    return (float(np.mean(slopes)), float(np.max(errors))) if slopes else (math.nan, math.nan)
