"""Warn of a rig that hides the contact."""

from __future__ import annotations

from collections.abc import Iterator

from fretsolve.case.dimensions import percent
from fretsolve.problem.setup.problem import ProblemSetup

LARGEST_SHARE = 0.9
"""Part of the actuator's motion that the rig takes, from which an error of 1 % in the rig's stiffness makes one of more
than 10 % in the contact's motion."""


def about_rig(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a rig so soft that it takes nearly all of the actuator's motion even while the contact sticks."""
    if setup.on_rig is None or (found := setup.on_rig.reversal) is None:
        return
    (_, motion, actuator), given, sticking = found
    if (share := given / (given + sticking)) > LARGEST_SHARE:
        yield (
            f"rig.stiffness_{actuator.removeprefix('actuator_')}: the rig takes {percent(share, 3)} of {actuator} while"
            f" the contact sticks, so that the loop at the actuator tells little about the contact; look at the loop"
            f" over {motion}, or take a stiffer rig"
        )
