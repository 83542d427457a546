"""Follow the shear along the load path, as a part of what friction carries."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretsolve.case.history import Summary

Shares = tuple[float, float, float]

TORQUE_ARM = 1.5
"""Under a torque the shear traction at the edge of a round punch is so many times that of a force over the radius."""

TURNS_SEEN = 2
"""Number of increments by which a stage that turns the shear converges later than with the first order."""


@dataclass(frozen=True)
class ShearPath:
    """The path of the shear so far, in parts of what friction carries: forces, and the torque over its arm.

    at: where it is, (3,); way: in the last increment, (3,); largest: how far from 0 it has been, at most 1; length: of
    all ways; turned: ways across the direction of the shear, each over TURNS_SEEN more than its stage's increments.
    """

    at: Shares = (0.0, 0.0, 0.0)
    way: Shares = (0.0, 0.0, 0.0)
    largest: float = 0.0
    length: float = 0.0
    turned: float = 0.0

    def after(self, summary: Summary, carried: float, count: int) -> ShearPath:
        """Return the path after an increment; carried: the force (N) that friction carries; count: of its stage."""
        if carried <= 0.0:
            return ShearPath(largest=self.largest, length=self.length, turned=self.turned)
        arm = torque_arm(summary)
        at = summary.Qx / carried, summary.Qy / carried, summary.Mz / (arm * carried) if arm else 0.0
        way = at[0] - self.at[0], at[1] - self.at[1], at[2] - self.at[2]
        share, length, before = math.hypot(*at), math.hypot(*way), math.hypot(*self.at)
        along = sum(a * b for a, b in zip(way, self.at, strict=True)) / before if before else length
        across = math.sqrt(max(length**2 - along**2, 0.0))
        turned = self.turned + across / (count + TURNS_SEEN)
        return ShearPath(at, way, max(self.largest, min(share, 1.0)), self.length + length, turned)

    @property
    def left(self) -> float:
        """The part of the friction limit that is left, 0 where the bodies slide."""
        return max(1.0 - math.hypot(*self.at), 0.0)

    @property
    def moves_on(self) -> bool:
        """Whether the last increment moved the shear farther from 0, by more than round-off."""
        return sum(a * b for a, b in zip(self.at, self.way, strict=True)) > 1e-5


def torque_arm(summary: Summary) -> float:
    """Return the arm (mm) by which a torque counts like a force."""
    return summary.contact_radius / TORQUE_ARM
