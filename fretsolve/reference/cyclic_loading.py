"""Cattaneo, Mindlin and Lubkin on a load that goes to and fro at a constant normal force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.reference.closed_forms import (
    CattaneoMindlin,
    HertzContact,
    LubkinContact,
    cattaneo_mindlin,
    full_slip_torque,
    lubkin,
)
from fretsolve.system.arrays import DoubleArray

SAME = 1e-6
"""Loads that differ by no more than this, relative to the load they go with, are equal."""


def remembered(loads: Sequence[float], least: float = 0.0) -> tuple[float, ...]:
    """The turning points of `loads` that the contact still remembers, from 0 to the last load.

    A branch that goes beyond the one before it closes that loop and wipes it out (Mindlin & Deresiewicz 1953).
    Changes of no more than `least` are none.
    """
    points = [0.0]
    for load in loads:
        if abs(load - points[-1]) <= least:
            continue
        if len(points) > 1 and (load - points[-1]) * (points[-1] - points[-2]) > 0.0:
            points[-1] = load
        else:
            points.append(load)
        while len(points) > 2:
            first_loading = len(points) == 3
            before = abs(points[-2] - points[-3]) * (2.0 if first_loading else 1.0)
            if abs(points[-1] - points[-2]) < before * (1.0 - SAME):
                break
            del points[-2 if first_loading else -3 : -1]
    return tuple(points)


@dataclass(frozen=True)
class TangentialForm:
    """A Hertz contact about `center` (mm) under a force along `direction`, or (None) under a torque.

    compliance: tangential or torsional (1/MPa); points: the load's turning points as `remembered` has them.
    """

    hertz: HertzContact
    center: tuple[float, float]
    friction: float
    compliance: float
    direction: tuple[float, float] | None
    points: tuple[float, ...]

    @property
    def name(self) -> str:
        """Its authors."""
        return "Lubkin" if self.direction is None else "Cattaneo-Mindlin"

    @property
    def force(self) -> str:
        """The load component that is moved most."""
        if self.direction is None:
            return "Mz"
        return "Qx" if abs(self.direction[0]) >= abs(self.direction[1]) else "Qy"

    def shear(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Shear (2, n) at points (n,): that of first loading, and twice that of half of each later branch."""
        across, along = x - self.center[0], y - self.center[1]
        r = np.hypot(across, along)
        total = np.zeros_like(r)
        for index, (before, after) in enumerate(zip(self.points, self.points[1:], strict=False)):
            times = 1.0 if index == 0 else 2.0
            total += times * self._on_loading((after - before) / times).shear(r)
        if self.direction is None:
            return np.stack([-total * along, total * across]) / np.maximum(r, np.finfo(float).tiny)
        return np.stack([total * self.direction[0], total * self.direction[1]])

    def stick_ratio(self) -> float:
        """c/a, which the branch after the last turning point decides."""
        if len(self.points) < 2:
            return 1.0
        times = 1.0 if len(self.points) == 2 else 2.0
        solution = self._on_loading((self.points[-1] - self.points[-2]) / times)
        return solution.stick_radius / self.hertz.contact_radius

    def _on_loading(self, load: float) -> CattaneoMindlin | LubkinContact:
        """The solution on first loading, at most that of full slip."""
        if self.direction is None:
            limit = full_slip_torque(self.hertz, self.friction) * (1.0 - SAME)
            return lubkin(self.hertz, self.friction, max(-limit, min(limit, load)), self.compliance)
        limit = self.friction * self.hertz.load
        return cattaneo_mindlin(self.hertz, self.friction, max(-limit, min(limit, load)), self.compliance)
