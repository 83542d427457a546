"""Contacts of alike bodies under a tangential force and bulk stress together, both applied at once from full stick.

Bulk stress strains the two surfaces differently, which shifts the stick zone (Nowell & Hills 1987; Hills & Nowell,
Mechanics of Fretting Fatigue (1994)). A mismatch is the strain of body 2's surface less that of body 1's, as
`fretsolve.model.bulk_stress` computes it: positive where body 2 is pulled. Compliances are those of
`fretsolve.model.materials.Compliances`. Every function raises ValueError outside its stated range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretsolve.reference.hertz import HertzContact
from fretsolve.system.arrays import DoubleArray

NODES, WEIGHTS = np.polynomial.legendre.leggauss(80)
"""Points and weights of Gauss's rule on (-1, 1). The integrands are smooth, with roots removed by substitution."""

NARROWEST = 1e-9
"""Half-width of a stick zone over a, below which it is lost in the rounding of its ends."""


@dataclass(frozen=True)
class LineUnderBulk:
    """A cylinder on a flat in plane strain under Q per length (N/mm), |Q| < mu P, and a mismatch De_xx.

    half_width: a (mm); max_pressure: p0 (MPa); compliance: A (1/MPa). Below, f = |Q|/mu P and b = De_xx/(A mu p0).
    """

    half_width: float
    max_pressure: float
    friction: float
    compliance: float
    shear_force: float
    mismatch: float

    def __post_init__(self) -> None:
        positive = min(self.half_width, self.max_pressure, self.friction, self.compliance) > 0.0
        if not positive or not self.fraction < 1.0:
            raise ValueError("half-width, pressure, friction and compliance must be positive, and |Q| below mu P")

    @property
    def fraction(self) -> float:
        """f = |Q|/mu P, with P = pi a p0/2 per length."""
        limit = 0.5 * math.pi * self.friction * self.max_pressure * self.half_width
        return abs(self.shear_force) / limit

    @property
    def bulk(self) -> float:
        """b = De_xx/(A mu p0), with the sign of the mismatch."""
        return self.mismatch / (self.compliance * self.friction * self.max_pressure)

    @property
    def reverses(self) -> bool:
        """True if the two slip zones have opposite signs: |b| > 1 - sqrt(1 - f)."""
        return abs(self.bulk) > 1.0 - math.sqrt(1.0 - self.fraction)

    @cached_property
    def is_reached_in_proportion(self) -> bool:
        """True if force and mismatch that grow in proportion, in many increments, lead here.

        They do while no slip zone shrinks on the way: |b| <= f/2, or a zone of backward slip that still grows. Where it
        shrinks it sticks at once, and the stick zone is wider than that of both applied in one step.
        """
        if abs(self.bulk) <= 0.5 * self.fraction:
            return True
        before = replace(self, shear_force=0.999 * self.shear_force, mismatch=0.999 * self.mismatch)
        if not self.reverses or not before.is_known:
            return False
        return max(map(abs, self.stick_zone)) <= max(map(abs, before.stick_zone))

    @property
    def is_known(self) -> bool:
        """True if the stick zone is found: it may be too narrow under large bulk stress."""
        return self._ends is not None

    @property
    def stick_zone(self) -> tuple[float, float]:
        """Both ends of the stick zone along x (mm)."""
        if self._ends is None:
            raise ValueError("the ends of the stick zone are not known")
        return self._ends

    @cached_property
    def _ends(self) -> tuple[float, float] | None:
        """Both ends of the stick zone (mm); None if they are not found."""
        a, b, f = self.half_width, self.bulk, self.fraction
        if not self.reverses:
            center, half = math.copysign(1.0, self.shear_force) * b, math.sqrt(1.0 - f)
            return a * (center - half), a * (center + half)
        if f == 0.0:
            half = line_stick_ratio_under_bulk_alone(abs(b))
            return (-a * half, a * half) if half > NARROWEST else None
        # Q > 0 and b > 0: the slip zone at +x is small and slips backwards; other signs by symmetry
        ends = _reverse_slip(f, abs(b))
        if ends is None:
            return None
        low, high = ends
        return (a * low, a * high) if (b > 0.0) == (self.shear_force > 0.0) else (-a * high, -a * low)

    @property
    def stick_half_width(self) -> float:
        """Half of the stick zone's width (mm); c = a sqrt(1 - f) without reversed slip."""
        low, high = self.stick_zone
        return 0.5 * (high - low)

    @property
    def stick_center(self) -> float:
        """Middle of the stick zone (mm); e = a b for Q > 0 without reversed slip."""
        low, high = self.stick_zone
        return 0.5 * (low + high)

    def shear(self, x: DoubleArray) -> DoubleArray:
        """Return q(x) = mu p0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - (x-e)^2/c^2)] (MPa), with the sign of Q."""
        self._require_one_sign()
        a, c, e = self.half_width, self.stick_half_width, self.stick_center
        full = np.sqrt(np.maximum(1.0 - np.square(x / a), 0.0))
        stick = (c / a) * np.sqrt(np.maximum(1.0 - np.square((x - e) / c), 0.0))
        return np.asarray(math.copysign(self.friction * self.max_pressure, self.shear_force) * (full - stick))

    def slip(self, x: DoubleArray) -> DoubleArray:
        """Return s(x) = (A mu p0/2a) c^2 (t sqrt(t^2 - 1) - acosh t), t = |x-e|/c >= 1 (mm), with the sign of Q."""
        self._require_one_sign()
        a, c, e = self.half_width, self.stick_half_width, self.stick_center
        t = np.maximum(np.abs(x - e) / c, 1.0)
        scale = 0.5 * self.compliance * self.friction * self.max_pressure * c**2 / a
        return np.asarray(math.copysign(scale, self.shear_force) * (t * np.sqrt(np.square(t) - 1.0) - np.arccosh(t)))

    @property
    def work_per_cycle(self) -> float:
        """Energy (mJ/mm) dissipated in a cycle between plus and minus Q and mismatch, in phase or opposite.

        4 times the integral of mu p s over both slip zones.
        """
        self._require_one_sign()
        a, (low, high) = self.half_width, self.stick_zone
        total = 0.0
        for begin, end in ((high, a), (low, -a)):
            # x = begin + (end - begin) sin^2 t removes the roots at both ends
            angle = 0.25 * math.pi * (NODES + 1.0)
            x = begin + (end - begin) * np.sin(angle) ** 2
            dx = abs(end - begin) * np.sin(2.0 * angle) * 0.25 * math.pi * WEIGHTS
            pressure = self.max_pressure * np.sqrt(np.maximum(1.0 - np.square(x / a), 0.0))
            total += float(np.sum(self.friction * pressure * np.abs(self.slip(x)) * dx))
        return 4.0 * total

    def _require_one_sign(self) -> None:
        if self.reverses:
            raise ValueError("no closed form where the slip zones have opposite signs")


def line_stick_ratio_under_bulk_alone(bulk: float) -> float:
    """Return c/a of a cylinder under bulk stress without Q, from b = (2/pi)(K - E), k^2 = 1 - (c/a)^2; bulk: b >= 0."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipkm1

    if not bulk >= 0.0:
        raise ValueError("bulk must not be negative")
    if bulk == 0.0:
        return 1.0

    def excess(logarithm: float) -> float:
        squared = math.exp(2.0 * logarithm)
        return (2.0 / math.pi) * float(ellipkm1(squared) - ellipe(1.0 - squared)) - bulk

    most = math.log(4.0) - 1.0 - 0.5 * math.pi * bulk  # of c/a << 1
    if most < -20.0:
        return math.exp(most)
    return math.exp(float(brentq(excess, most - 2.0, 0.0, xtol=1e-15)))


def _reverse_slip(f: float, b: float) -> tuple[float, float] | None:
    """Return the ends of the stick zone over a, for Q > 0, b > 0 and backward slip at +x; None if not found.

    With a = mu p0 = 1, R = sgn sqrt((x-s1)(x-s2)), m = (s1+s2)/2, q = p left of the stick zone and -p right of it:
    the integral of q/R over the slip zones is -pi b, that of (x-m) q/R is Q.
    """
    from scipy.optimize import root

    def missed(unknown: DoubleArray) -> list[float]:
        """Return by how much ends of the stick zone miss the two integrals."""
        left, right, stick = _widths(unknown)
        middle, half = 0.5 * (left - right), 0.5 * stick
        sums = []
        for side in (1.0, -1.0):
            # x = m +- half cosh u turns dx/|R| into du; u = end (1 - v^2) removes the root of p at the contact's edge
            end = math.acosh(max((1.0 - side * middle) / half, 1.0))
            v = 0.5 * (NODES + 1.0)
            away = half * np.cosh(end * (1.0 - v**2))
            pressure = np.sqrt(np.maximum(1.0 - np.square(middle + side * away), 0.0)) * end * v * WEIGHTS
            sums.append((float(np.sum(pressure)), float(np.sum(away * pressure))))
        (right_first, right_second), (left_first, left_second) = sums
        return [math.pi * b - right_first - left_first, left_second - right_second - 0.5 * math.pi * f]

    # from the stick zone of bulk stress or of the force alone, moved aside more and more
    half = min(line_stick_ratio_under_bulk_alone(b), math.sqrt(1.0 - f))
    if half < NARROWEST:
        return None
    for part in (0.5, 0.1, 0.01, 1e-4, 1e-8):
        right = part * (1.0 - half)
        left = 2.0 * (1.0 - half) - right
        found = root(missed, np.log([left / (2.0 * half), right / (2.0 * half)]), tol=1e-14)
        if np.max(np.abs(found.fun)) < 1e-11:
            left, right, _ = _widths(found.x)
            low, high = left - 1.0, 1.0 - right
            return (low, high) if high - low > 2.0 * NARROWEST else None
    return None


def _widths(unknown: DoubleArray) -> tuple[float, float, float]:
    """Return the widths of both slip zones and the stick zone in a contact of width 2.

    unknown: the logarithms of the slip zones' widths over the stick zone's. It does not shrink to nothing.
    """
    left, right = np.exp(np.minimum(unknown, -2.0 * math.log(NARROWEST))).tolist()
    stick = 2.0 / (1.0 + left + right)
    return left * stick, right * stick, stick


@dataclass(frozen=True)
class SphereUnderBulk:
    """A sphere on a flat under a force along x, |Q| < mu P, and a mismatch De_xx with De_yy = -De_xx D2/D1.

    compliances: A and B (1/MPa); D1 = 4A + B, D2 = B. An eccentric circle sticks while it lies inside the contact, in
    the sense of Cattaneo and Mindlin, who neglect that slip turns across the force. Without uy from qx (coupling: none)
    it is exact with De_yy = 0. From Johnson, eq. 3.91.
    """

    hertz: HertzContact
    friction: float
    compliances: tuple[float, float]
    shear_force: float
    mismatch: float

    def __post_init__(self) -> None:
        if not self.hertz.is_circle or not abs(self.shear_force) < self.friction * self.hertz.load:
            raise ValueError("a circular contact is needed, and |Q| below mu P")
        if abs(self.stick_center) + self.stick_radius > self.hertz.contact_radius:
            raise ValueError("no closed form where the stick zone reaches the edge of the contact")

    @property
    def stick_radius(self) -> float:
        """c = a (1 - f)^(1/3)."""
        fraction = abs(self.shear_force) / (self.friction * self.hertz.load)
        return self.hertz.contact_radius * math.cbrt(1.0 - fraction)

    @property
    def stick_center(self) -> float:
        """e = 16 a De_xx/(pi mu p0 D1) for Q > 0 (mm)."""
        scale = math.pi * self.friction * self.hertz.max_pressure * self._along
        return math.copysign(16.0 * self.hertz.contact_radius / scale, self.shear_force) * self.mismatch

    @property
    def delta_x(self) -> float:
        """(pi mu p0/32a) [4 S (a^2 - c^2) + D1 e^2] with S = 2A + B (mm), with the sign of Q."""
        a, c, e = self.hertz.contact_radius, self.stick_radius, self.stick_center
        tangential = 2.0 * self.compliances[0] + self.compliances[1]
        scale = math.pi * self.friction * self.hertz.max_pressure / (32.0 * a)
        return math.copysign(scale * (4.0 * tangential * (a**2 - c**2) + self._along * e**2), self.shear_force)

    @property
    def mismatch_across(self) -> float:
        """De_yy = -De_xx D2/D1, which the solution needs."""
        return -self.mismatch * self.compliances[1] / self._along

    @property
    def _along(self) -> float:
        A, B = self.compliances
        return 4.0 * A + B
