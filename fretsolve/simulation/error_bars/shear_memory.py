"""Follow how far a shear slips by Jaeger's superposition.

The shear traction of a round contact or a cylinder is a sum of those of slipping contacts under all smaller loads, of
which an increment replaces the outermost ones (J. Jaeger, Arch. Appl. Mech. 65, 478, 1995). That is exact for like
bodies under a force along one direction, and an estimate for others.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import itemgetter

Shear = tuple[float, float, float]

UNMOVED = 1e-4
"""Part of the load and of the friction limit by which an increment changes them at most that leaves all as it is."""

HALVINGS = 34
"""Of the interval in which the stick zone's load is looked for."""


@dataclass(frozen=True)
class ShearMemory:
    """The shear forces g(P) that the contacts under the loads P up to the present one carry.

    corners: (P, g) of a piecewise linear g, P growing (N; a torque over two thirds of the radius); slipping: part of
    the present load by which that on the stick zone is smaller. So the stick zone is the contact under 1 - slipping of
    the load.
    """

    corners: tuple[tuple[float, Shear], ...] = ((0.0, (0.0, 0.0, 0.0)),)
    slipping: float = 0.0

    def after(self, load: float, shear: Shear, friction: float) -> ShearMemory:
        """Return it after an increment to `load` and `shear`; friction: largest shear force over the load."""
        if load <= 0.0:
            return NO_SHEAR
        last, before = self.corners[-1]
        if abs(load - last) <= UNMOVED * load and math.dist(shear, before) <= UNMOVED * friction * load:
            return replace(self, corners=(*self.corners[:-1], (load, shear)))
        stick = self._stick_load(load, shear, friction)
        kept = self.corners[: bisect_left(self.corners, stick, key=itemgetter(0))]
        slipping = 1.0 - stick / load if stick < min(last, load) else 0.0
        return ShearMemory((*kept, (stick, self._at(stick)), (load, shear)), slipping)

    def after_at_once(self, load: float, shear: Shear, friction: float) -> ShearMemory:
        """Return it after an increment as the run takes it: a contact that grows takes part in the whole shear."""
        grown = self.after(load, self.corners[-1][1], friction) if load > self.corners[-1][0] else self
        return grown.after(load, shear, friction)

    def _stick_load(self, load: float, shear: Shear, friction: float) -> float:
        """Return the largest load up to which g is kept, since from there on all slips to the new load."""
        top = min(self.corners[-1][0], load)

        def holds(stick: float) -> bool:
            return math.dist(shear, self._at(stick)) <= friction * (load - stick)

        # 1. Nothing slips while friction carries the change on what the load adds.
        if holds(top):
            return top
        # 2. Else go down to the first corner that may stick, and look for the place above it.
        above = top
        for corner, _ in reversed(self.corners):
            if corner >= top:
                continue
            if holds(corner):
                return self._between(corner, above, holds)
            above = corner
        return 0.0

    @staticmethod
    def _between(holding: float, slipping: float, holds: Callable[[float], bool]) -> float:
        """Return the largest load that holds, between one that does and one that does not."""
        for _ in range(HALVINGS):
            middle = 0.5 * (holding + slipping)
            holding, slipping = (middle, slipping) if holds(middle) else (holding, middle)
        return holding

    def _at(self, load: float) -> Shear:
        """Return g at a load up to the present one."""
        above = bisect_left(self.corners, load, key=itemgetter(0))
        upper, there = self.corners[above]
        if above == 0 or upper == load:
            return there
        lower, here = self.corners[above - 1]
        share = (load - lower) / (upper - lower)
        x, y, turn = (a + share * (b - a) for a, b in zip(here, there, strict=True))
        return x, y, turn


NO_SHEAR = ShearMemory()
