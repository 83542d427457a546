"""Warn of a rig that hides the contact, or on which the contact jumps."""

from __future__ import annotations

from collections.abc import Iterator

from fretsolve.case.dimensions import percent
from fretsolve.problem.setup.problem import ProblemSetup

Names = tuple[str, str, str]
"""Force, motion and actuator of a mode."""

LARGEST_SHARE = 0.9
"""Part of the actuator's motion that the rig takes, from which an error of 1 % in the rig's stiffness makes one of more
than 10 % in the contact's motion."""


def about_rig(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a rig that is too soft: for the contact to be seen, and for friction that falls with slip."""
    if setup.on_rig is not None and (found := setup.on_rig.reversal) is not None:
        yield from _about_softness(*found)
        yield from _about_jumps(setup, *found[:2])


def _about_softness(names: Names, given: float, sticking: float) -> Iterator[str]:
    """Warn of a rig so soft that it takes nearly all of the actuator's motion even while the contact sticks."""
    _, motion, actuator = names
    if (share := given / (given + sticking)) > LARGEST_SHARE:
        yield (
            f"{_stiffness(actuator)}: the rig takes {percent(share, 3)} of {actuator} while"
            f" the contact sticks, so that the loop at the actuator tells little about the contact; look at the loop"
            f" over {motion}, or take a stiffer rig"
        )


def _about_jumps(setup: ProblemSetup, names: Names, given: float) -> Iterator[str]:
    """Warn of friction that falls faster with slip than the rig unloads, where the actuator may make it slide."""
    spec, hertz, (force, motion, actuator) = setup.case.friction, setup.closed_forms.largest, names
    if hertz is None or spec.initial is None or spec.final is None or spec.weakening == "allow" or force == "Mz":
        return
    if spec.exponent is not None or spec.shear_limit is not None:
        return
    farthest = max((abs(load.get(actuator, 0.0)) for load in setup.load_path.imposed), default=0.0)
    # The integral of Hertz's pressure squared is 3/4 P p0.
    weight = 1.0 / spec.slip if spec.slip else 0.75 * spec.initial * hertz.max_pressure / (spec.energy or 1.0)
    growth = given * (spec.initial - spec.final) * hertz.load * weight
    if growth >= 1.0 and farthest > given * spec.initial * hertz.load:
        yield (
            f"{_stiffness(actuator)}: once the contact slides as a whole, friction falls {growth:.3g} times as fast"
            f" with slip as the rig unloads, which ends the run; a stiffer rig, or {motion} imposed on the contact"
            " itself, follows it"
        )


def _stiffness(actuator: str) -> str:
    return f"rig.stiffness_{actuator.removeprefix('actuator_')}"
