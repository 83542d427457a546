"""A Hertz contact under a shear force with any axisymmetric friction limit b(r), by Abel's transform.

With bh(x) = 2 int_x^a r b/sqrt(r^2 - x^2) dr, which falls from x = 0 on, the stick zone is the disk of radius c, and

    delta_x = S/4 bh(c),  Q = 2 (c bh(c) + int_c^a bh dx),  W = S/2 int_c^a (bh(c) - bh(x)) bh(x) dx

with the tangential compliance S and the dissipated energy W of first loading. b = mu p gives Cattaneo and Mindlin. As
there, what shear along x moves along y is left out. It follows from the superposition of disks that move as a whole;
Johnson, Contact Mechanics (1985), section 7.2, has the case of mu p.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from fretsolve.system.arrays import DoubleArray

STEP = 0.01
"""Least step of b over the largest b."""


@dataclass(frozen=True)
class RimFrictionLimit:
    """A friction limit b(r) (MPa) on a disk; limit: of radii (mm), an array like them; compliance: S (1/MPa)."""

    limit: Callable[[DoubleArray], DoubleArray]
    contact_radius: float
    compliance: float

    @cached_property
    def gross_slip_force(self) -> float:
        """The force (N) of gross slip, int b dA."""
        return 2.0 * self._integral(0.0)

    @cached_property
    def gross_slip_torque(self) -> float:
        """The torque (N mm) of gross slip about the middle, int b r dA."""
        r, weights = self.points(0.0)
        return 2.0 * math.pi * float(np.sum(weights * r**2 * self.limit(r)))

    @cached_property
    def slips_from_rim(self) -> bool:
        """True if bh falls, so that the slip zone grows from the rim inwards and these formulas hold."""
        values = self.transform(np.linspace(0.0, self.contact_radius, 400))
        return bool((np.diff(values) < 1e-9 * values.max()).all())

    def transform(self, x: DoubleArray) -> DoubleArray:
        """Return bh (N/mm) at `x` (n,): with r^2 = x^2 + s^2 it is twice the integral of b over s."""
        nodes, weights = _nodes()
        total, start = np.zeros_like(x), np.zeros_like(x)
        for end in (*self._steps, self.contact_radius):
            stop = np.sqrt(np.maximum(end**2 - x**2, 0.0))
            half = 0.5 * (stop - start)
            r = np.hypot(x[:, None], start[:, None] + half[:, None] * (nodes + 1.0))
            total += 2.0 * half * (self.limit(np.minimum(r, self.contact_radius)) @ weights)
            start = stop
        return total

    def under(self, shear_force: float) -> RimSlip:
        """Return the contact under a force Q on first loading. Raises ValueError beyond gross slip."""
        from scipy.optimize import brentq

        if abs(shear_force) > self.gross_slip_force * (1.0 + 1e-12):
            raise ValueError(f"the force must not exceed {self.gross_slip_force:g} N")
        a, wanted = self.contact_radius, abs(shear_force)
        if wanted >= self._force(0.0):
            return RimSlip(self, shear_force, 0.0)
        return RimSlip(self, shear_force, float(brentq(lambda c: self._force(c) - wanted, 0.0, a, xtol=1e-13 * a)))

    def _force(self, c: float) -> float:
        return 2.0 * (c * float(self.transform(np.array([c]))[0]) + self._integral(c))

    def _integral(self, c: float) -> float:
        """Return the integral of bh from c to a."""
        x, weights = self.points(c)
        return float(np.sum(weights * self.transform(x)))

    def points(self, c: float) -> tuple[DoubleArray, DoubleArray]:
        """Return nodes and weights of a quadrature from c to a."""
        nodes, weights = _nodes()
        ends = np.array([c, *(step for step in self._steps if step > c), self.contact_radius])
        half = 0.5 * np.diff(ends)[:, None]
        return (ends[:-1, None] + half * (nodes + 1.0)).ravel(), (half * weights).ravel()

    @cached_property
    def _steps(self) -> tuple[float, ...]:
        """The radii at which b steps."""
        r = np.linspace(0.0, self.contact_radius, 2001)
        values = self.limit(r)
        least = STEP * float(np.abs(values).max())
        steps = []
        for i in np.flatnonzero(np.abs(np.diff(values)) > least):
            low, high = float(r[i]), float(r[i + 1])
            for _ in range(50):
                ends, middle = self.limit(np.array([low, 0.5 * (low + high), high])), 0.5 * (low + high)
                if abs(ends[1] - ends[0]) > abs(ends[2] - ends[1]):
                    high = middle
                else:
                    low = middle
            if abs(float(np.diff(self.limit(np.array([low, high])))[0])) > least:
                steps.append(0.5 * (low + high))
        return tuple(steps)


@dataclass(frozen=True)
class RimSlip:
    """A contact under a shear force on first loading, sticking inside of `stick_radius`."""

    law: RimFrictionLimit
    shear_force: float
    stick_radius: float

    @property
    def delta_x(self) -> float:
        """Rigid displacement (mm) in the direction of the force."""
        return math.copysign(0.25 * self.law.compliance * self._at_edge, self.shear_force)

    @property
    def work_per_cycle(self) -> float:
        """Energy (N mm) dissipated in a full cycle between plus and minus the force, four times the loading's."""
        x, weights = self.law.points(self.stick_radius)
        values = self.law.transform(x)
        return 2.0 * self.law.compliance * float(np.sum(weights * (self._at_edge - values) * values))

    def shear(self, r: DoubleArray) -> DoubleArray:
        """Return the shear traction (MPa) at radii `r` (n,).

        It is b less what disks of less than the stick radius would add, -(1/pi) int_r^c bh'/sqrt(x^2 - r^2) dx.
        """
        a, c = self.law.contact_radius, self.stick_radius
        traction = np.where(r <= a, self.law.limit(np.minimum(r, a)), 0.0)
        inside = r < c
        if inside.any():
            # x^2 = r^2 + s^2, with differences of bh between the ends of equal parts of s
            s = np.linspace(0.0, 1.0, 201) * np.sqrt(c**2 - r[inside, None] ** 2)
            x = np.hypot(r[inside, None], s)
            values = self.law.transform(x.ravel()).reshape(x.shape)
            slope = np.diff(values, axis=1) / np.diff(x, axis=1)
            middle = np.sqrt(0.5 * (x[:, 1:] ** 2 + x[:, :-1] ** 2))
            traction[inside] += np.sum(slope / middle * np.diff(s, axis=1), axis=1) / math.pi
        return math.copysign(1.0, self.shear_force) * traction

    @cached_property
    def _at_edge(self) -> float:
        return float(self.law.transform(np.array([self.stick_radius]))[0])


@cache
def _nodes() -> tuple[DoubleArray, DoubleArray]:
    """Return nodes and weights of the quadratures over x and r, between one step of b and the next."""
    return np.polynomial.legendre.leggauss(300)
