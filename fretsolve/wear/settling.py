"""The distance of a solved cycle from those that would follow it between the same surfaces.

Only a cycle that repeats itself may stand for others: what it dissipates more than they would is worn as often as it
stands for. Such an excess stays behind from the first loading, and comes anew with each jump, since the surfaces then
change all at once and not from cycle to cycle. Slip lets it die out over the next cycles. It is small where pressure
and shear do not change each other; between unlike bodies it is about proportional to the jump.

So after a jump one more cycle is solved to look at it, unless a look before has shown that it does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence

from fretsolve.case.keys.unrolled_path import CYCLES_TO_SETTLE
from fretsolve.errors import NotConvergedError
from fretsolve.wear.progress import SolvedCycle

SHAKEN_DOWN = 0.5
"""Change of the dissipated energy over the tolerance of the wear up to which the first cycle may stand for others."""

SETTLED = 0.01
"""The same change over the energy itself, where wear or friction change it from the first cycles on."""

TAIL = 2.0
"""Excess of the second cycle after a jump over its fall from the first one to the second. Much of it is left from the
jumps before, as all but its first part dies out slowly; 1 to 2.3 measured between unlike bodies."""

UNSEEN_TAIL = 4.5
"""Excess of the first cycle after a jump over the same fall, where each cycle is followed by a jump. With it the errors
of nine cases by which it was not chosen (other bodies, P in and out of phase with Q, line contacts, running in) are
within `wear_error`; it is nearest, at 0.7 to 0.75 of it, where P is out of phase with Q between unlike bodies."""

DYING_OUT = 0.75
"""Part of the excess that is left one cycle later, from the second one after a jump on; 0.7 to 0.77 measured."""

SHARE = 0.5
"""Part of the allowed error of a jump that the excess may have, the rest is for the change of the rates. Half and twice
as much take more increments between unlike bodies, by a fifth and a twelfth."""

UNSEEN_SHARE = 0.1
"""The same where no more cycle is solved to look at it: the excess is then estimated from an earlier jump. With half of
it gross slip takes a seventh more increments; with five times as much it saves as many, and has 1.6 times the error."""

MOST_LOOKS, LOOKS_AT_GIVEN = 4, 2
"""Most cycles that are solved after a jump before the next one; where the jump is given, so that all have room."""


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
    return share <= (UNSEEN_SHARE if looks == 1 else SHARE) * allowed or looks >= most_looks


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
