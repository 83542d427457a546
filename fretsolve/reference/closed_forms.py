"""Closed-form solutions that the numerical ones are checked against.

Lengths in mm, forces in N, torques in N.mm, pressures and moduli in MPa, compliances in 1/MPa, angles in rad.
Sources: Johnson, Contact Mechanics (1985), chapters 3, 4, 7; Cattaneo (1938), Mindlin (1949), Lubkin (1951),
Spence (1975), Love (1939), Boussinesq (1885); Carlson's integrals as in DLMF chapter 19. Formulas are
arranged so that nothing cancels at small loads. Every function raises ValueError outside its stated range.
Compliances and moduli are those of `fretsolve.model.materials.Compliances`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:

    from fretsolve.system.arrays import DoubleArray



@dataclass(frozen=True)
class HertzContact:
    """Circular Hertz contact: load P, contact radius a, peak pressure p0, approach delta_z."""

    load: float
    contact_radius: float
    max_pressure: float
    delta_z: float

    def pressure(self, r: DoubleArray) -> DoubleArray:
        """Pressure p0 sqrt(1 - r^2/a^2) at distances `r` from the centre; 0 outside."""
        return self.max_pressure * _semicircle(r, self.contact_radius)


def hertz_sphere(load: float, radius: float, contact_modulus: float) -> HertzContact:
    """Sphere on a flat, load > 0; Johnson (4.22-4.24): a^3 = 3 P R/4E*, p0 = 3P/2 pi a^2, delta_z = a^2/R."""
    _require(min(load, radius, contact_modulus) > 0.0, "load, radius and modulus must be positive")
    a = math.cbrt(0.75 * load * radius / contact_modulus)
    return HertzContact(load, a, 1.5 * load / (math.pi * a**2), a**2 / radius)


@dataclass(frozen=True)
class EllipticContact:
    """Elliptic Hertz contact: load P, semi-axes along x and y, peak pressure p0, approach delta_z."""

    load: float
    semi_axis_x: float
    semi_axis_y: float
    max_pressure: float
    delta_z: float

    def pressure(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Pressure at points `x`, `y` (of shapes that broadcast) along the principal axes; 0 outside."""
        import numpy as np

        return self.max_pressure * _semicircle(np.hypot(x / self.semi_axis_x, y / self.semi_axis_y), 1.0)


def hertz_elliptic(load: float, radius_x: float, radius_y: float, contact_modulus: float) -> EllipticContact:
    """Separation x^2/2Rx + y^2/2Ry with positive radii, load > 0; Johnson, section 4.2.

    With k' = b/a, the shorter over the longer semi-axis, the curvatures are 1/2R_a = s R_D(0, k'^2, 1) and
    1/2R_b = s R_D(0, 1, k'^2), s = p0 b/3E* a^2, Carlson's R_D being the complete integrals (K - E)/k^2 and
    (E/k'^2 - K)/k^2 that Johnson has; their ratio gives k'. The approach is (p0 b/E*) K(k).
    """
    from scipy.optimize import brentq
    from scipy.special import ellipkm1, elliprd

    _require(min(load, radius_x, radius_y, contact_modulus) > 0.0, "load, radii and modulus must be positive")
    long_radius, short_radius = max(radius_x, radius_y), min(radius_x, radius_y)

    def mismatch(log_axis_ratio: float) -> float:
        square = math.exp(2.0 * log_axis_ratio)
        curvature_ratio = elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0)
        return math.log(curvature_ratio) - math.log(long_radius / short_radius)

    # b/a lies between R_b/R_a and 1: it is (R_b/R_a)^(2/3) for a nearly round ellipse, larger for a slim one
    lowest = math.log(short_radius / long_radius)
    ratio = math.exp(brentq(mismatch, lowest, 0.0, xtol=1e-15, rtol=1e-15)) if lowest < 0.0 else 1.0
    a = math.cbrt(load * long_radius * elliprd(0.0, ratio**2, 1.0) / (math.pi * contact_modulus))
    b = ratio * a
    p0 = 1.5 * load / (math.pi * a * b)
    delta_z = p0 * b / contact_modulus * ellipkm1(ratio**2)
    axis_x, axis_y = (a, b) if radius_x >= radius_y else (b, a)
    return EllipticContact(load, axis_x, axis_y, p0, float(delta_z))


@dataclass(frozen=True)
class FlatPunch:
    """Flat cylindrical punch without friction: load P, contact radius a, approach delta_z."""

    load: float
    contact_radius: float
    delta_z: float

    @property
    def mean_pressure(self) -> float:
        """P/(pi a^2)."""
        return self.load / (math.pi * self.contact_radius**2)

    def pressure(self, r: DoubleArray) -> DoubleArray:
        """Pressure P/(2 pi a sqrt(a^2 - r^2)) at distances `r` < a; infinite at the edge, 0 outside."""
        import numpy as np

        a = self.contact_radius
        with np.errstate(divide="ignore"):
            inside = self.load / (2.0 * np.pi * a * np.sqrt(np.maximum(a**2 - np.square(r), 0.0)))
        return np.where(np.asarray(r) <= a, inside, 0.0)


def boussinesq_punch(load: float, radius: float, contact_modulus: float) -> FlatPunch:
    """Flat punch of `radius` > 0, load >= 0: P = 2 a E* delta_z, Johnson, section 3.4."""
    _require(load >= 0.0 and radius > 0.0 and contact_modulus > 0.0, "radius and modulus must be positive")
    return FlatPunch(load, radius, load / (2.0 * radius * contact_modulus))


@dataclass(frozen=True)
class ConeContact:
    """Cone on a flat: load P, contact radius a, approach delta_z, mean pressure p_m."""

    load: float
    contact_radius: float
    delta_z: float
    mean_pressure: float

    def pressure(self, r: DoubleArray) -> DoubleArray:
        """Pressure p_m arcosh(a/r) at distances `r` from the apex; infinite there, 0 outside."""
        import numpy as np

        with np.errstate(divide="ignore"):
            return self.mean_pressure * np.arccosh(np.maximum(self.contact_radius / np.asarray(r), 1.0))


def love_cone(load: float, angle: float, contact_modulus: float) -> ConeContact:
    """Cone whose flank makes `angle` (rad, in (0, pi/2)) with the contact plane, load > 0.

    Love (1939), with t = tan(angle): P = (pi/2) a^2 E* t, delta_z = (pi/2) a t, p_m = (E*/2) t.
    """
    _require(load > 0.0 and contact_modulus > 0.0, "load and modulus must be positive")
    _require(0.0 < angle < math.pi / 2, "the angle must lie between 0 and pi/2")
    slope = math.tan(angle)
    a = math.sqrt(2.0 * load / (math.pi * contact_modulus * slope))
    return ConeContact(load, a, 0.5 * math.pi * a * slope, 0.5 * contact_modulus * slope)


@dataclass(frozen=True)
class CattaneoMindlin:
    """Hertz contact under a shear force below sliding, after loading from zero.

    stick_radius: c. center_shear: q0 at the centre, in the direction of the force. delta_x: rigid
    displacement. work_per_cycle: dissipated in a full cycle between plus and minus the force (N.mm).
    """

    hertz: HertzContact
    friction: float
    shear_force: float
    stick_radius: float
    center_shear: float
    delta_x: float
    work_per_cycle: float

    def shear(self, r: DoubleArray) -> DoubleArray:
        """Shear in the direction of x at distances `r` from the centre: mu p minus the stick zone's part."""
        import numpy as np

        a, c = self.hertz.contact_radius, self.stick_radius
        relief = c / a * _semicircle(r, c) if c > 0.0 else 0.0
        limit = self.friction * self.hertz.max_pressure
        return math.copysign(limit, self.shear_force) * np.asarray(_semicircle(r, a) - relief)


def cattaneo_mindlin(
    hertz: HertzContact, friction: float, shear_force: float, tangential_compliance: float
) -> CattaneoMindlin:
    """Shear force Q, |Q| <= mu P, mu > 0, applied at constant load; Johnson, section 7.2.

    With f = |Q|/mu P and S the tangential compliance: c = a(1 - f)^(1/3), q0 = mu p0 (1 - c/a),
    delta_x = (3 mu P S/16a) (1 - (1 - f)^(2/3)), and the work per cycle is
    (9 mu^2 P^2 S/10a) {1 - (1 - f)^(5/3) - (5f/6)[1 + (1 - f)^(2/3)]}. The braces are O(f^3); their binomial
    series, all of whose terms are positive, sums up to (5/162) f^3 2F1(4/3, 2; 4; f).
    """
    from scipy.special import hyp2f1

    fraction = _force_fraction(hertz, friction, shear_force)
    limit, a = friction * hertz.load, hertz.contact_radius
    center_shear = friction * hertz.max_pressure * _one_minus_power(fraction, 1 / 3)
    braces = 5.0 / 162.0 * fraction**3 * float(hyp2f1(4.0 / 3.0, 2.0, 4.0, fraction))
    return CattaneoMindlin(
        hertz,
        friction,
        shear_force,
        stick_radius=a * math.cbrt(1.0 - fraction),
        center_shear=math.copysign(center_shear, shear_force),
        delta_x=mindlin_displacement(hertz, friction, shear_force, tangential_compliance),
        work_per_cycle=0.9 * limit**2 / a * tangential_compliance * braces,
    )


def mindlin_displacement(
    hertz: HertzContact, friction: float, shear_force: float, tangential_compliance: float
) -> float:
    """Rigid displacement d(Q) on first loading, |Q| <= mu P, mu > 0; Mindlin (1949)."""
    fraction = _force_fraction(hertz, friction, shear_force)
    scale = 3.0 * friction * hertz.load * tangential_compliance / (16.0 * hertz.contact_radius)
    return math.copysign(scale * _one_minus_power(fraction, 2 / 3), shear_force)


def mindlin_unloading(
    hertz: HertzContact, friction: float, largest: float, shear_force: float, tangential_compliance: float
) -> float:
    """Rigid displacement at `shear_force` on the way from `largest` = Q* to -Q*: d(Q*) - 2 d((Q* - Q)/2).

    Mindlin & Deresiewicz (1953), |Q| <= |Q*| <= mu P.
    """
    _require(abs(shear_force) <= abs(largest), "the shear force must lie between plus and minus the largest")
    peak = mindlin_displacement(hertz, friction, largest, tangential_compliance)
    back = mindlin_displacement(hertz, friction, 0.5 * (largest - shear_force), tangential_compliance)
    return peak - 2.0 * back


def full_stick_compliance(contact_radius: float, tangential_compliance: float) -> float:
    """Rigid displacement per shear force (mm/N) of a circular contact without slip: S/8a, Mindlin (1949)."""
    _require(contact_radius > 0.0, "the contact radius must be positive")
    return tangential_compliance / (8.0 * contact_radius)


def spence_stick_ratio(friction: float, dundurs_constant: float) -> float:
    """c/a of a sphere indenting with friction >= 0, shear not acting back on the pressure; Spence (1975).

    Root of (a/2c) ln((a + c)/(a - c)) = (mu/|beta|) K(sqrt(1 - c^2/a^2)): 1 for beta = 0, 0 for mu = 0.
    """
    from scipy.optimize import brentq
    from scipy.special import ellipkm1

    _require(friction >= 0.0, "the friction coefficient must not be negative")
    if dundurs_constant == 0.0:
        return 1.0
    ratio = friction / abs(dundurs_constant)
    if ratio < 0.04:  # c/a < 1e-10: K = ln(4a/c) and the left side is 1, to the last digit
        return 4.0 * math.exp(-1.0 / ratio) if ratio > 0.0 else 0.0

    def mismatch(log_v: float) -> float:
        v = math.exp(log_v)  # c/a = tanh v, so that the left side is v/tanh v
        return v / math.tanh(v) - ratio * float(ellipkm1(math.tanh(v) ** 2))

    # K falls with v, and v < v/tanh v: a root above 1 lies below the right side's value at v = 1
    upper = max(1.0, ratio * float(ellipkm1(math.tanh(1.0) ** 2)))
    return math.tanh(math.exp(brentq(mismatch, math.log(1e-11), math.log(upper), xtol=1e-15, rtol=1e-15)))


@dataclass(frozen=True)
class LubkinContact:
    """Hertz contact under a torque Mz about its axis, below full slip: stick radius c and rotation phi_z."""

    hertz: HertzContact
    friction: float
    torque: float
    stick_radius: float
    phi_z: float

    def shear(self, r: DoubleArray) -> DoubleArray:
        """Circumferential shear at distances `r`, positive about +z for a positive torque; 0 outside.

        Lubkin (1951): mu p for r >= c, and (2/pi) mu p [pi/2 + (K - E) F(psi, k') - K E(psi, k')] for r < c,
        with k' = c/a, K and E of the modulus k = sqrt(1 - k'^2), sin^2 psi = (1 - r^2/c^2)/(1 - r^2/a^2). The
        bracket's rounding error is that of 1, however small its value.
        """
        import numpy as np
        from scipy.special import ellipe, ellipeinc, ellipkinc, ellipkm1

        a, c = self.hertz.contact_radius, self.stick_radius
        limit = math.copysign(self.friction, self.torque) * self.hertz.pressure(r)
        if c == 0.0:
            return limit
        inside = np.minimum(np.abs(r) / c, 1.0)
        square = min((c / a) ** 2, 1.0 - 2.0**-52)  # F is infinite at 1, where it is multiplied by K - E = 0
        sine_squared = (1.0 - inside) * (1.0 + inside) / (1.0 - square * inside**2)
        psi = np.arcsin(np.sqrt(sine_squared))
        K, E = ellipkm1(square), ellipe(1.0 - square)
        bracket = np.pi / 2 + (K - E) * ellipkinc(psi, square) - K * ellipeinc(psi, square)
        return np.asarray(limit * np.where(inside < 1.0, 2.0 / np.pi * bracket, 1.0))


def full_slip_torque(hertz: HertzContact, friction: float) -> float:
    """Torque (3 pi/16) mu P a at which the whole circular contact slips."""
    return 3.0 * math.pi / 16.0 * friction * hertz.load * hertz.contact_radius


def lubkin(hertz: HertzContact, friction: float, torque: float, torsional_compliance: float) -> LubkinContact:
    """Torque below full slip in magnitude, mu > 0, on a Hertz contact; Lubkin (1951).

    The shear is a superposition g(b) r/sqrt(b^2 - r^2) of rigid rotations of circles with radii b from c to a
    (Johnson, 3.9). An Abel transform of mu p gives g = (2 mu p0/pi) E/b, E of the modulus sqrt(1 - b^2/a^2);
    hence Mz = (8/3) mu p0 a^3 int_{c/a}^1 t^2 E(sqrt(1 - t^2)) dt and phi_z = (1/2) mu p0 (K - E) sum 1/G_i,
    K and E of the modulus sqrt(1 - c^2/a^2).
    """
    from scipy.integrate import quad
    from scipy.optimize import brentq
    from scipy.special import ellipe, elliprd

    full = full_slip_torque(hertz, friction)
    _require(abs(torque) < full, f"the torque must be below that of full slip, {full:g} N.mm")
    p0, a = hertz.max_pressure, hertz.contact_radius

    def excess(share: float) -> float:  # t = 1 - width s keeps small widths 1 - c/a exact
        width = share * widest
        value, _ = quad(
            lambda s: (1.0 - width * s) ** 2 * ellipe(width * s * (2.0 - width * s)), 0.0, 1.0, epsrel=1e-12
        )
        return share * float(value) / mean - 1.0

    # the torque is concave in the width, with the slope 4 pi/3 mu p0 a^3 at 0: Mz/(that) < width < Mz/full
    widest, mean = abs(torque) / full, 3.0 * math.pi**2 / 64.0
    width = widest * brentq(excess, 0.25, min(1.01, 1.0 / widest), xtol=1e-15, rtol=1e-15) if torque else 0.0
    modulus = width * (2.0 - width)  # k^2 = 1 - c^2/a^2
    difference = modulus / 3.0 * float(elliprd(0.0, 1.0 - modulus, 1.0))  # K - E
    phi_z = 0.5 * friction * p0 * difference * torsional_compliance
    return LubkinContact(hertz, friction, torque, a * (1.0 - width), math.copysign(phi_z, torque))


def _semicircle(r: DoubleArray, radius: float) -> DoubleArray:
    """sqrt(1 - r^2/radius^2), 0 outside."""
    import numpy as np

    return np.asarray(np.sqrt(np.maximum(1.0 - np.square(r / radius), 0.0)))


def _force_fraction(hertz: HertzContact, friction: float, shear_force: float) -> float:
    """|Q|/mu P, checked."""
    limit = friction * hertz.load
    _require(friction > 0.0 and abs(shear_force) <= limit, f"the force must not exceed mu P = {limit:g} N")
    return abs(shear_force) / limit


def _one_minus_power(fraction: float, exponent: float) -> float:
    """1 - (1 - fraction)^exponent without loss of digits for a small fraction."""
    return -math.expm1(exponent * math.log1p(-fraction)) if fraction < 1.0 else 1.0


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)
