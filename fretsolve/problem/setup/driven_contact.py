"""Follow a contact along one tangential mode, by Masing's rule and through gross slip, by force, motion or actuator."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from fretsolve.problem.setup.closed_forms import Load
from fretsolve.reference.cyclic_loading import CyclicLoading, turning_points
from fretsolve.reference.line_slip import LineMotion

DIGITS = 12
"""Digits of a force over its limit, so that cycles that repeat come back to the same numbers."""


@dataclass(frozen=True)
class DrivenContact:
    """A contact at the end of a stage: its force or torque (N, N mm; of a line per mm), its motion and the actuator's
    (mm, rad).

    slides: whether it slides as a whole.
    """

    force: float
    motion: float
    actuator: float
    slides: bool


@dataclass
class DrivenPath:
    """The way of a contact between like bodies, on a rig in series, along one tangential mode.

    names: force, motion and actuator; shear: the contact without shear; load: the normal one; compliance: of the rig
    (mm/N, rad/(N mm)); turns: forces at the turning points that the contact remembers; slid: motion by which it has
    slid as a whole; known: what followed from where it stood, as cycles come back to it.
    """

    names: tuple[str, str, str]
    shear: CyclicLoading | LineMotion
    load: float
    compliance: float
    turns: tuple[float, ...] = ()
    slid: float = 0.0
    known: dict[object, tuple[DrivenContact, tuple[float, ...], float]] = field(default_factory=dict)

    def motion(self, force: float) -> float:
        """Return the motion of the contact under `force` next, without that by which it has slid."""
        return math.fsum(replace(self.shear, path=(*self.turns, force)).displacements().values())

    def given(self, load: Load) -> float:
        """Return the compliance between the contact and what a load moves: of the rig under the actuator's motion."""
        return self.compliance if self.names[2] in load else 0.0

    def follow(self, load: Load) -> DrivenContact | None:
        """Go to a load; return the contact there, None where it has a force that friction does not carry."""
        name = next(name for name in self.names if name in load)
        key = self.turns, self.slid, name, load[name]
        if key not in self.known:
            found = self._at(name, load[name])
            if found is None:
                return None
            turns, _ = turning_points((*self.turns, found.force), self.shear.least)
            self.known[key] = found, turns[1:], found.motion - self.motion(found.force)
        found, self.turns, self.slid = self.known[key]
        return found

    def _at(self, name: str, value: float) -> DrivenContact | None:
        from scipy.optimize import brentq  # most cases need no root

        most = self.shear.limit
        if name == self.names[0]:
            motion = self.motion(value) + self.slid
            return DrivenContact(value, motion, motion + self.compliance * value, False) if abs(value) < most else None
        given = self.given({name: value})

        def excess(force: float) -> float:
            return self.motion(force) + self.slid + given * force - value

        if (slides := excess(most) <= 0.0) or excess(-most) >= 0.0:
            force, slides = most if slides else -most, True
        else:
            force = most * round(brentq(excess, -most, most, xtol=1e-15 * most) / most, DIGITS)
        motion = value - given * force
        return DrivenContact(force, motion, motion + self.compliance * force, slides)
