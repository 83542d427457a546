"""The choice of how many cycles a solved one stands for, from the history of the dissipated energy and worn volume.

Only a cycle that repeats itself may stand for others: what it dissipates more than they would is worn as often as it
stands for. Such an excess stays behind from the first loading, and comes anew with each jump, since the surfaces then
change all at once and not from cycle to cycle. Slip lets the excess die out over the next cycles. It is small where
pressure and shear do not change each other; between dissimilar bodies it is about proportional to the jump. So after a
jump one more cycle is solved to look at it, unless a look before has shown that it does not matter.

The error of a jump follows from the rates at its two ends (`wear_law.owed`). Over the volume that the jump wears it
falls with the second power of the jump, so the next one follows from it; the excess adds an error of the first
power. The jump is such that both stay within what is left of the tolerance, which is of the whole volume.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.case.keys.unrolled_path import CYCLES_TO_SETTLE, CyclePass
from fretsolve.errors import NotConvergedError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.result.state import Summary

FIRST_DEPTH = 0.005
"""Depth of the first jump over the largest elastic displacement: its error shows how long the next one may be. Half or
twice this depth changes the increments of a run by less than a fifth. A jump of two cycles may be deeper."""

USUAL_TOLERANCE = 0.01
"""Below this tolerance the first jump shrinks; otherwise 1e-3 was not met in partial slip at T = 1."""

FIRST_SHARE = 0.1
"""Part of all cycles that the first jump may have, and of the cycles over which friction stays nearly constant, so that
its own error is small over the whole: without it dissimilar bodies took four times the increments."""

MOST_GROWTH = 2.0
"""Largest jump over the jump before, since its error is known only after it. With 1.5 gross slip takes a quarter more
increments; with 4 it saves a seventh, and partial slip has three times the error."""

SAFETY = 0.5
"""Part of the allowed error that a jump is chosen for, since its error is known only after it, and that the excess may
have besides. With the whole error runs are hardly shorter, and `wear_error` may exceed the tolerance."""

AIM = 0.9
"""Part of the tolerance that all jumps together aim at, as the last ones may have a little more than is allowed."""

LEAST_ALLOWED = 0.1
"""Smallest error of a jump over the tolerance where earlier jumps had too much error, so that there is a jump."""

SHAKEN_DOWN = 0.5
"""Change of the dissipated energy over the tolerance of the wear up to which the first cycle may stand for others."""

SETTLED = 0.01
"""Largest change of the energy over the energy itself, where wear or friction change it from the first cycles on."""

TAIL = 2.0
"""Excess of the second cycle after a jump over its fall from the first one to the second; 1 to 2.3 measured between
dissimilar bodies, as all but the first part of the excess dies out slowly."""

UNSEEN_TAIL = 4.5
"""Excess of the first cycle after a jump over the same fall, where each cycle is followed by a jump: errors of nine
cases by which it was not chosen stay within `wear_error`."""

DYING_OUT = 0.75
"""Part of the excess that is left one cycle later, from the second one after a jump on; 0.7 to 0.77 measured."""

UNSEEN_SHARE = 0.1
"""Part of the allowed error that the excess may have where it is estimated from an earlier jump, without a look."""

MOST_LOOKS, LOOKS_AT_GIVEN = 4, 2
"""Most cycles that are solved after a jump before the next one; where the jump is given, so that all have room."""


@dataclass(frozen=True)
class SolvedCycle:
    """A solved cycle in a history.

    energy: that it dissipates (mJ); volume: that it wears itself (mm^3); error: of the volume by the jump before it;
    jump: the cycles that it stands for, and jumped_volume: the volume that these wear, both 0 as long as the surfaces
    have not changed for it.
    """

    energy: float
    volume: float = 0.0
    error: float = 0.0
    jump: float = 0.0
    jumped_volume: float = 0.0


@dataclass(frozen=True)
class Progress:
    """A load path and the history so far."""

    path: LoadPath
    history: Sequence[Summary]

    def solved(self, cycle: CyclePass) -> list[SolvedCycle]:
        """Return the last repetitions of a cycle up to this one, with which or with whose jump the history ends."""
        first = max(1, cycle.turn - CYCLES_TO_SETTLE)
        return [self._one(*self.path.steps_of(cycle.cycle, turn)) for turn in range(first, cycle.turn + 1)]

    def worn(self, cycle: CyclePass) -> tuple[float, float]:
        """Return the volume that all repetitions of a cycle have worn so far (mm^3), and its estimated error."""
        volume, error = self._before(self.path.steps_of(cycle.cycle, 1)[0])
        return self.history[-1].wear_volume - volume, self.history[-1].wear_error - error

    def jump_before(self, cycle: CyclePass) -> float:
        """Return the cycles that the repetition before this one stood for."""
        return self.history[self.path.steps_of(cycle.cycle, cycle.turn)[0] - 1].jump

    def _before(self, step: int) -> tuple[float, float]:
        """Return the worn volume and its error before a step."""
        return (self.history[step - 1].wear_volume, self.history[step - 1].wear_error) if step else (0.0, 0.0)

    def _one(self, first: int, last: int) -> SolvedCycle:
        history, (before, error) = self.history, self._before(first)
        energy = math.fsum(one.work for one in history[first : last + 1])
        volume, error = history[last].wear_volume - before, history[last].wear_error - error
        if len(history) <= last + 1:
            return SolvedCycle(energy, volume, error)
        return SolvedCycle(energy, volume, error, history[last + 1].jump, history[last + 1].wear_volume - before)


@dataclass(frozen=True)
class JumpLimits:
    """The limits of a jump besides its error.

    depth: largest depth that the last cycle wears (mm); scale: largest elastic displacement (mm), of the first jump;
    left: the cycles that are left, without the last one; most: the cycles over which friction stays nearly the same.
    """

    depth: float
    scale: float
    left: float
    most: float = math.inf


def allowed_error(tolerance: float, worn: float, error: float, per_cycle: float, left: float) -> float:
    """Return the error that the next jump may have over what it wears, for `tolerance` to hold for all in the end.

    worn, error: volume so far (mm^3) and its error; per_cycle: volume that the last cycle wears; left: the cycles that
    are left.
    """
    to_come, aim = per_cycle * left, AIM * tolerance
    if to_come <= 0.0:
        return aim
    unused = aim * worn - error
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
        # its error goes with its square, and no later jump can take back what wear_error counts of this jump
        part = min(1.0, math.sqrt(jumps.tolerance / USUAL_TOLERANCE))
        first = min(part * FIRST_DEPTH * limits.scale / depth, part * FIRST_SHARE * left, FIRST_SHARE * limits.most)
        most = min(most, max(2.0, first), FIRST_SHARE * left)
    else:
        before, error = cycles[last], cycles[last + 1].error
        growth = math.sqrt(SAFETY * allowed * before.jumped_volume / error) if error > 0.0 else MOST_GROWTH
        if per_cycle := excess_per_cycle(cycles):
            growth = min(growth, SAFETY * allowed / (per_cycle * before.jump))
        most = min(most, before.jump * min(growth, MOST_GROWTH))
    return min(max(1.0, float(math.floor(most))), left)


def excess(cycles: Sequence[SolvedCycle]) -> float | None:
    """Return by what part of its energy the last cycle dissipates more, or less, than cycles would that follow it, as
    an estimate; None where that is not known yet."""
    place = last_jump(cycles)
    if place is None:
        return TAIL * _change(cycles) if len(cycles) > 1 else None
    looks = len(cycles) - 1 - place
    if looks == 1:
        if (looked := _last_look(cycles)) is None:
            return None
        return UNSEEN_TAIL * _fall(cycles, looked) * cycles[place].jump / cycles[looked].jump
    return _excess_after(cycles, place, looks)


def excess_per_cycle(cycles: Sequence[SolvedCycle]) -> float | None:
    """Return the excess of the second cycle after a jump over the cycles of the jump, by the last look at one; None
    before the first look."""
    looked = _last_look(cycles)
    if looked is None:
        return None
    second = TAIL * _fall(cycles, looked)
    if looked + 3 < len(cycles) and cycles[looked + 2].jump <= 1.0:
        second = min(second, _excess_after(cycles, looked, 3) / DYING_OUT)
    return second / cycles[looked].jump


def _last_look(cycles: Sequence[SolvedCycle]) -> int | None:
    """Return the place of the last jump after which a second cycle was solved; None before the first such jump."""
    jumps = [place for place, one in enumerate(cycles) if one.jump > 1.0]
    return next((place for place in reversed(jumps) if place + 2 < len(cycles) and cycles[place + 1].jump <= 1.0), None)


def _excess_after(cycles: Sequence[SolvedCycle], place: int, looks: int) -> float:
    """Return the excess of the cycle that is the number `looks` after a jump, at least 2.

    From the third one on, the energies themselves show how much is left.
    """
    by_first = TAIL * _fall(cycles, place) * DYING_OUT ** (looks - 2)
    if looks == 2:
        return by_first
    return min(by_first, _fall(cycles, place, looks) * DYING_OUT / (1.0 - DYING_OUT))


def is_settled(cycles: Sequence[SolvedCycle], tolerance: float, allowed: float, most_looks: int = MOST_LOOKS) -> bool:
    """Return whether the last cycle may stand for others.

    tolerance: of the worn volume; allowed: error of the next jump over what it wears; most_looks: cycles after a jump.
    """
    place, share = last_jump(cycles), excess(cycles)
    if share is None:
        return False
    if place is None:
        # wear and friction that runs in change the energy, too: it does not have to settle further for ever
        return _change(cycles) <= (SHAKEN_DOWN * tolerance if len(cycles) <= CYCLES_TO_SETTLE else SETTLED)
    looks = len(cycles) - 1 - place
    return share <= (UNSEEN_SHARE if looks == 1 else SAFETY) * allowed or looks >= most_looks


def require_periodic(cycles: Sequence[SolvedCycle], tolerance: float) -> None:
    """Raise NotConvergedError where the cycles before the first jump do not become periodic."""
    if len(cycles) <= CYCLES_TO_SETTLE or last_jump(cycles) is not None:
        return
    if not any(is_settled(cycles[:count], tolerance, tolerance) for count in range(2, len(cycles) + 1)):
        raise NotConvergedError(
            f"the cycle is not periodic after {len(cycles)} repetitions: from the last one but one to the last its"
            f" dissipated energy changes by {100.0 * _change(cycles):.2g} %, so that it cannot stand for others; if its"
            " own wear changes it as much, set jump: 1, which solves each cycle, or wear less; otherwise run it with"
            " times and without represents until it is"
        )


def last_jump(cycles: Sequence[SolvedCycle]) -> int | None:
    """Return the place of the last cycle before this one that stands for others; None before the first one."""
    return max((place for place, one in enumerate(cycles[:-1]) if one.jump > 1.0), default=None)


def _change(cycles: Sequence[SolvedCycle]) -> float:
    """Return the change of the energy from the last cycle but one to the last, over the larger of the two."""
    before, last = cycles[-2].energy, cycles[-1].energy
    return abs(last - before) / max(before, last) if max(before, last) > 0.0 else 0.0


def _fall(cycles: Sequence[SolvedCycle], place: int, look: int = 2) -> float:
    """Return by what the energy falls to the cycle that is the number `look` after a jump, over the energy.

    place: of the cycle before the jump. What wear itself changes in a cycle is taken off, as the mean over the jump.
    """
    before, last, now = (cycles[at].energy for at in (place, place + look - 1, place + look))
    by_wear = (now - before) / (cycles[place].jump + look - 1.0)
    return abs(now - last - by_wear) / now if now > 0.0 else 0.0
