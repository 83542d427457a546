"""Partial slip on line contacts of similar bodies, under a tangential force and bulk stress, all per mm of the line.

Without bulk stress: Cattaneo and Mindlin as in Johnson, Contact Mechanics (1985), section 7.2, for a cylinder,
Ciavarella (1998) and Jaeger (1998) for any other contact. Bulk stress strains the two surfaces differently, which
shifts the stick zone (Nowell & Hills 1987; Hills & Nowell, Mechanics of Fretting Fatigue (1994)). A mismatch is the
strain of body 2's surface less the strain of body 1's surface: positive where body 2 is pulled. Force and mismatch are
applied at once, from full stick. Every function raises ValueError outside its stated range.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretsolve.reference.cyclic_loading import SAME, MasingPath, dissipated
from fretsolve.reference.hertz import HertzLine, LineContact
from fretsolve.system.arrays import DoubleArray

NODES, WEIGHTS = np.polynomial.legendre.leggauss(80)
"""Points and weights of Gauss's rule on (-1, 1). The integrands are smooth, with roots removed by substitution."""

NARROWEST = 1e-9
"""Half-width of a stick zone over a, below which it is lost in the rounding of its ends."""


@dataclass(frozen=True)
class LinePartialSlip:
    """A line contact under Q per length (N/mm, either sign), |Q| < mu P, and on a cylinder a mismatch De_xx.

    compliance: A for Qx, A + B for Qy (1/MPa). Below, f = |Q|/mu P and b = De_xx/(A mu p0).
    """

    contact: LineContact
    friction: float
    shear_force: float
    compliance: float
    mismatch: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.shear_force) < self.friction * self.contact.load:
            raise ValueError("the tangential force must be below mu P")
        if self.mismatch and not isinstance(self.contact, HertzLine):
            raise ValueError("the contact under bulk stress must be that of a cylinder")

    @property
    def fraction(self) -> float:
        """f = |Q|/mu P."""
        return abs(self.shear_force) / (self.friction * self.contact.load)

    @property
    def bulk(self) -> float:
        """b = De_xx/(A mu p0), with the sign of the mismatch."""
        return self.mismatch / self._strain if self.mismatch else 0.0

    @property
    def reverses(self) -> bool:
        """True if the two slip zones have opposite signs: |b| > 1 - sqrt(1 - f)."""
        return abs(self.bulk) > 1.0 - math.sqrt(1.0 - self.fraction)

    @cached_property
    def is_reached_in_proportion(self) -> bool:
        """True if force and mismatch that grow in proportion, in many increments, lead here.

        They do while no slip zone shrinks on the way: |b| <= f/2, or a zone of backward slip that still grows. Where a
        slip zone shrinks, its cells stick at once, and the stick zone is wider than if both loads came in one step.
        """
        if abs(self.bulk) <= 0.5 * self.fraction * (1.0 + SAME):
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
        if not self.mismatch:
            return -self.sticking.half_width, self.sticking.half_width
        a, b, f = self.contact.half_width, self.bulk, self.fraction
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
    def sticking(self) -> LineContact:
        """The contact at the load P - Q/mu, whose width sticks."""
        return self.contact.under(self.contact.load - abs(self.shear_force) / self.friction)

    @property
    def stick_half_width(self) -> float:
        """Half of the stick zone's width (mm); c = a sqrt(1 - f) of a cylinder without reversed slip."""
        low, high = self.stick_zone
        return 0.5 * (high - low)

    @property
    def stick_center(self) -> float:
        """Middle of the stick zone (mm); e = a b for Q > 0 without reversed slip."""
        low, high = self.stick_zone
        return 0.5 * (low + high)

    def shear(self, x: DoubleArray) -> DoubleArray:
        """Return the shear traction at `x` (MPa): mu p less mu times the pressure at P - Q/mu about the stick zone."""
        self._require_one_sign()
        less = self.contact.pressure(x) - self.sticking.pressure(x - self.stick_center)
        return math.copysign(self.friction, self.shear_force) * less

    def slip(self, x: DoubleArray) -> DoubleArray:
        """Return the slip at `x` of a cylinder (mm), with the sign of Q; 0 in the stick zone and outside the contact.

        s = (A mu p0/2a) c^2 (t sqrt(t^2 - 1) - acosh t), t = |x - e|/c >= 1.
        """
        self._require_one_sign()
        a, c, e = self.contact.half_width, self.stick_half_width, self.stick_center
        t = np.maximum(np.abs(x - e) / c, 1.0)
        moved = self._strain * c**2 / (2.0 * a) * (t * np.sqrt(t * t - 1.0) - np.arccosh(t))
        return math.copysign(1.0, self.shear_force) * np.where(np.abs(x) <= a, moved, 0.0)

    @property
    def work_per_cycle(self) -> float:
        """Energy (mJ/mm) dissipated on a cylinder in a cycle between plus and minus Q and mismatch.

        The mismatch is in phase or opposite. It is 4 times the integral of mu p s over both slip zones.
        """
        self._require_one_sign()
        a, total = self.contact.half_width, 0.0
        low, high = self.stick_zone
        for begin, end in ((high, a), (low, -a)):
            # x = begin + (end - begin) sin^2 t removes the roots at both ends
            angle = 0.25 * math.pi * (NODES + 1.0)
            x = begin + (end - begin) * np.sin(angle) ** 2
            dx = abs(end - begin) * np.sin(2.0 * angle) * 0.25 * math.pi * WEIGHTS
            total += float(np.sum(self.friction * self.contact.pressure(x) * np.abs(self.slip(x)) * dx))
        return 4.0 * total

    @property
    def _strain(self) -> float:
        """A mu p0."""
        return self.compliance * self.friction * self.contact.max_pressure

    def _require_one_sign(self) -> None:
        if self.mismatch and self.reverses:
            raise ValueError("no closed form where the slip zones have opposite signs")


@dataclass(frozen=True)
class LineShear(MasingPath[LinePartialSlip]):
    """Partial slip after a path of a tangential force in one direction, at constant load.

    path: the forces (N/mm) from the unloaded contact on, or the mismatches where bulk stress acts alone; first_loading:
    the solution on first loading by such a force, with the bulk stress in proportion; axis: 0 for Qx, 1 for Qy.
    """

    path: tuple[float, ...]
    contact: LineContact
    axis: int
    first_loading: Callable[[float], LinePartialSlip]

    def on_loading(self, load: float) -> LinePartialSlip:
        return self.first_loading(load)

    @property
    def least(self) -> float:
        return SAME * max(map(abs, self.path))

    @property
    def slips_one_way(self) -> bool:
        """True if all slip zones of each branch slip alike, so that shear traction and energy are known."""
        return not any(branch.mismatch and branch.reverses for _, branch in self.branches)

    @property
    def is_reached(self) -> bool:
        """True if the closed form of each branch is known, and its increments lead there."""
        return all(branch.is_known and branch.is_reached_in_proportion for _, branch in self.branches)

    @property
    def stick_half_width(self) -> float:
        """Half-width of the stick zone (mm) at the end of the path."""
        return self.contact.half_width if self.last is None else self.last.stick_half_width

    @property
    def stick_center(self) -> float:
        """Middle of the stick zone (mm) from the middle of the contact, at the end of the path."""
        return 0.0 if self.last is None else self.last.stick_center

    def shear(self, x: DoubleArray) -> DoubleArray | None:
        """Return the shear traction along its axis at `x` from the middle (MPa); None where slip reverses."""
        if not self.slips_one_way:
            return None
        return sum((factor * branch.shear(x) for factor, branch in self.branches), start=np.zeros_like(x))

    def slip(self, x: DoubleArray) -> DoubleArray | None:
        """Return the slip along its axis at `x` from the middle (mm), since the start; None where it is not known."""
        if not self.slips_one_way or not isinstance(self.contact, HertzLine):
            return None
        return sum((factor * branch.slip(x) for factor, branch in self.branches), start=np.zeros_like(x))

    def dissipated_energy(self) -> float | None:
        """Return the energy dissipated on the path (mJ/mm); None where no closed form gives the slip."""
        if not isinstance(self.contact, HertzLine) or not self.slips_one_way:
            return None
        return dissipated(self.path, lambda load: self.on_loading(load).work_per_cycle)


@dataclass(frozen=True)
class LineMotion(MasingPath[float]):
    """The motion of points deep in both bodies past each other along x under a path of forces Qx, at constant load.

    A surface moves against a point at depth d by the integral of q [ln(d/|x - s|) + 1/(2 (1 - nu))] for d >> a, which
    the stick zone does as a whole (Johnson, eq. 5.56, for shear). So mu times the potentials of pressures gives it.
    compliance: A (1/MPa); depth: d exp((A + B)/2A), which takes up the second term; path: as in `LineShear`.
    """

    contact: LineContact
    friction: float
    compliance: float
    depth: float
    path: tuple[float, ...] = ()

    @property
    def limit(self) -> float:
        """The force mu P (N/mm)."""
        return self.friction * self.contact.load

    @property
    def least(self) -> float:
        return SAME * self.limit

    @property
    def sticking(self) -> float:
        """The motion per force without slip (mm^2/N), as just after a reversal: under a flat punch's traction."""
        return self.compliance / math.pi * math.log(2.0 * self.depth / self.contact.half_width)

    def on_loading(self, load: float) -> float:
        """Return delta_x (mm) on first loading by `load`, or by the limit beyond it."""
        left = self.contact.load - min(abs(load) / self.friction, self.contact.load)
        sticking = self.contact.under(left).potential(self.depth) if left > 0.0 else 0.0
        moved = self.friction * (self.contact.potential(self.depth) - sticking)
        return math.copysign(self.compliance / math.pi * moved, load)

    @property
    def work_of_gross_slip(self) -> float:
        """Energy (mJ/mm) of a cycle of a cylinder between both onsets of gross slip, A (mu P)^2/pi."""
        return self.compliance * self.limit**2 / math.pi

    def displacements(self) -> dict[str, float]:
        """Return delta_x (mm) at the end of the path."""
        return {"delta_x": math.fsum(factor * branch for factor, branch in self.branches)}


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
    the integral of q/R over the slip zones is -pi b, the integral of (x-m) q/R is Q.
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
