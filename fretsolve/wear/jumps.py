"""The choice of how many cycles a solved one stands for, from the history of the worn volume.

The error of a jump follows from the rates at its two ends (`fretsolve.wear.rates.owed`). Over the volume that the jump
wears it falls with the second power of the jump, so the next one follows from it. What a cycle dissipates more than
those that it stands for (`fretsolve.wear.settling`) adds an error of the first power. The jump is such that both stay
within what is left of the tolerance, which is of the whole volume.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.wear.progress import SolvedCycle, Worn
from fretsolve.wear.settling import LOOKS_AT_GIVEN, MOST_LOOKS, SHARE, excess_per_cycle, is_settled, last_jump

FIRST_DEPTH = 0.005
"""Depth of the first jump over the largest elastic displacement. The first jump shows by its error how long the next
one may be: half or twice this depth changes the increments of a run by less than a fifth. A first jump of two cycles
may be deeper, since a jump of one shows nothing and none would ever follow it."""

USUAL_TOLERANCE = 0.01
"""Tolerance from which on down the first jump shrinks. Without it a tolerance of 1e-3 was not met in partial slip at
T = 1 (`wear_error` 1.04e-3), nor any smaller one."""

SHORTEST_JUMP = 2.0
"""Cycles of the shortest jump."""

FIRST_SHARE = 0.1
"""Part of all cycles that the first jump may have, so that its own error is small over the whole. Where the whole wear
is shallow it is the limit: without it unlike bodies took four times the increments to make up for the first jump; half
of it saves them a fifth.

It holds for the cycles over which friction stays nearly the same, too, but two are allowed. Where a table doubles
friction near gross slip, a first jump over all of them has an error of 9 %, which keeps those after it short; where
friction runs in with slip, this takes a sixteenth more increments."""

MOST_GROWTH = 2.0
"""Largest jump over the one before it, since its error is known only after it. With 1.5 gross slip takes a quarter more
increments; with 4 it saves a seventh, and partial slip has three times the error."""

SAFETY = 0.5
"""Part of the allowed error that a jump is chosen for, since its error is known only after it. With all of it, runs are
hardly shorter, and `wear_error` may be larger than the tolerance."""

AIM = 0.9
"""Part of the tolerance that all jumps together aim at, as the last ones may have a little more than is allowed."""

LEAST_ALLOWED = 0.1
"""Least error that a jump may have, over the tolerance, where those before it had too much. It has to be above 0 for a
jump to be possible at all; runs within their tolerance do not meet it."""


@dataclass(frozen=True)
class JumpLimits:
    """The limits of a jump besides its error.

    depth: largest depth that the last cycle wears (mm); scale: largest elastic displacement (mm), of the first jump;
    left: the cycles that are left, without the last one; most: those over which friction stays nearly the same.
    """

    depth: float
    scale: float
    left: float
    most: float = math.inf


def allowed_error(tolerance: float, worn: Worn, per_cycle: float, left: float) -> float:
    """Return the error that the next jump may have over what it wears, for `tolerance` to hold for all in the end.

    per_cycle: volume that the last cycle wears (mm^3); left: the cycles that are left.
    """
    to_come, aim = per_cycle * left, AIM * tolerance
    if to_come <= 0.0:
        return aim
    unused = aim * worn.volume - worn.error
    return max(aim + unused / to_come, LEAST_ALLOWED * tolerance)


def next_jump(cycles: Sequence[SolvedCycle], jumps: WearJumps, limits: JumpLimits, allowed: float) -> float:
    """Return how many cycles the last of `cycles` is to stand for, at least 1.

    allowed: the error that it may have over what it wears.
    """
    depth, left = limits.depth, limits.left
    most_looks = MOST_LOOKS if jumps.jump is None else LOOKS_AT_GIVEN
    if left <= 1.0 or not is_settled(cycles, jumps.tolerance, allowed, most_looks):
        return 1.0
    if jumps.jump is not None:
        return min(jumps.jump, left)
    if depth <= 0.0:
        return min(limits.most, left)
    most = min(limits.most, math.inf if jumps.max_depth is None else jumps.max_depth / depth)
    last = last_jump(cycles)
    if last is None:
        # its error goes with its square, and no later jump can take back what wear_error counts of it
        part = min(1.0, math.sqrt(jumps.tolerance / USUAL_TOLERANCE))
        first = min(part * FIRST_DEPTH * limits.scale / depth, part * FIRST_SHARE * left, FIRST_SHARE * limits.most)
        most = min(most, max(SHORTEST_JUMP, first), FIRST_SHARE * left)
    else:
        before, error = cycles[last], cycles[last + 1].error
        growth = math.sqrt(SAFETY * allowed * before.jumped_volume / error) if error > 0.0 else MOST_GROWTH
        if per_cycle := excess_per_cycle(cycles):
            growth = min(growth, SHARE * allowed / (per_cycle * before.jump))
        most = min(most, before.jump * min(growth, MOST_GROWTH))
    return min(max(1.0, float(math.floor(most))), left)
