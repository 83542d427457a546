"""Tangential force and torque on a Hertz contact, and friction under pressing alone.

Sources: Cattaneo (1938), Mindlin (1949), Mindlin & Deresiewicz (1953), Lubkin (1951), Spence (1975), Nowell & Hills
(1987); Johnson, Contact Mechanics (1985), chapters 3 and 7. Formulas are arranged so that nothing cancels at small
loads. Compliances are defined in `fretsolve.problem.model.materials`, a mismatch in `line_slip`. Every
function raises ValueError outside its stated range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from fretsolve.reference.hertz import HertzContact, complete_integral, growing_root
from fretsolve.system.arrays import DoubleArray


def mindlin_stick_ratio(fraction: DoubleArray) -> DoubleArray:
    """Return c/a = (1 - f)^(1/3) for the tangential force over mu P, f <= 1; Johnson, section 7.2."""
    return np.asarray(np.cbrt(1.0 - fraction))


@dataclass(frozen=True)
class CattaneoMindlin:
    """Hertz contact under a shear force |Q| <= mu P, after loading from zero; Johnson, section 7.2.

    compliance: the tangential one (1/MPa). Below, f = |Q|/mu P.
    """

    hertz: HertzContact
    friction: float
    shear_force: float
    compliance: float

    @property
    def stick_radius(self) -> float:
        """c = a (1 - f)^(1/3)."""
        return self.hertz.contact_radius * float(mindlin_stick_ratio(np.array(self._fraction)))

    @property
    def center_shear(self) -> float:
        """q0 = mu p0 (1 - c/a) at the centre, with the sign of the force."""
        value = self.friction * self.hertz.max_pressure * _one_minus_power(self._fraction, 1 / 3)
        return math.copysign(value, self.shear_force)

    @property
    def delta_x(self) -> float:
        """Rigid displacement (3 mu P S/16a) (1 - (1 - f)^(2/3)) in the direction of the force; Mindlin (1949)."""
        scale = 3.0 * self.friction * self.hertz.load * self.compliance / (16.0 * self.hertz.contact_radius)
        return math.copysign(scale * _one_minus_power(self._fraction, 2 / 3), self.shear_force)

    @property
    def work_per_cycle(self) -> float:
        """Energy (N mm) dissipated in a full cycle between plus and minus the force.

        (9 mu^2 P^2 S/10a) {1 - (1 - f)^(5/3) - (5f/6)[1 + (1 - f)^(2/3)]}. The braces are O(f^3); their binomial
        series, all of whose terms are positive, sums to (5/162) f^3 2F1(4/3, 2; 4; f).
        """
        from scipy.special import hyp2f1

        limit, f = self.friction * self.hertz.load, self._fraction
        braces = 5.0 / 162.0 * f**3 * float(hyp2f1(4.0 / 3.0, 2.0, 4.0, f))
        return 0.9 * limit**2 / self.hertz.contact_radius * self.compliance * braces

    def shear(self, r: DoubleArray) -> DoubleArray:
        """Return the shear traction at distances `r`: mu p minus mu times Hertz's pressure on the stick zone."""
        a, c = self.hertz.contact_radius, self.stick_radius
        pressure = self.hertz.pressure(r)
        if c > 0.0:
            pressure -= replace(self.hertz, semi_axes=(c, c), max_pressure=c / a * self.hertz.max_pressure).pressure(r)
        return math.copysign(self.friction, self.shear_force) * pressure

    def slip(self, r: DoubleArray) -> DoubleArray:
        """Return the length of the slip (mm) at distances `r` up to the contact radius.

        (3 mu P S/32a) (r/a)^2 (2/pi) {(1 - 2 t^2) acos t + t sqrt(1 - t^2)} with t = c/r; 0 on the stick zone.
        """
        a = self.hertz.contact_radius
        t = np.divide(self.stick_radius, r, out=np.ones_like(r), where=r > self.stick_radius)
        braces = (1.0 - 2.0 * t**2) * np.arccos(t) + t * np.sqrt(1.0 - t**2)
        scale = 3.0 * self.friction * self.hertz.load * self.compliance / (16.0 * math.pi * a)
        return np.asarray(scale * np.square(r / a) * braces)

    @property
    def _fraction(self) -> float:
        return abs(self.shear_force) / (self.friction * self.hertz.load)


def cattaneo_mindlin(
    hertz: HertzContact, friction: float, shear_force: float, tangential_compliance: float
) -> CattaneoMindlin:
    """Return the contact under a shear force Q, |Q| <= mu P, mu > 0, at constant load."""
    limit = friction * hertz.load
    if friction <= 0.0 or abs(shear_force) > limit:
        raise ValueError(f"the force must not exceed mu P = {limit:g} N")
    return CattaneoMindlin(hertz, friction, shear_force, tangential_compliance)


def cattaneo_mindlin_moved(
    hertz: HertzContact, friction: float, displacement: float, tangential_compliance: float
) -> CattaneoMindlin | None:
    """Return the contact under a rigid displacement (mm) at constant load; None from gross slip on.

    Q = mu P (1 - (1 - delta/delta_g)^(3/2)), delta_g the displacement at gross slip; Mindlin (1949).
    """
    limit = friction * hertz.load
    share = abs(displacement) / cattaneo_mindlin(hertz, friction, limit, tangential_compliance).delta_x
    if share >= 1.0:
        return None
    force = math.copysign(limit * _one_minus_power(share, 1.5), displacement)
    return cattaneo_mindlin(hertz, friction, force, tangential_compliance)


def full_stick_compliance(contact_radius: float, tangential_compliance: float) -> float:
    """Return the rigid displacement per shear force (mm/N) of a circular contact without slip: S/8a, Mindlin (1949)."""
    if contact_radius <= 0.0:
        raise ValueError("the contact radius must be positive")
    return tangential_compliance / (8.0 * contact_radius)


@dataclass(frozen=True)
class LubkinContact:
    """Hertz contact under a torque Mz about its axis, below gross slip: stick radius c and rotation phi_z."""

    hertz: HertzContact
    friction: float
    torque: float
    stick_radius: float
    phi_z: float

    def shear(self, r: DoubleArray) -> DoubleArray:
        """Return the circumferential shear at distances `r`, positive about +z for a positive torque; 0 outside.

        Lubkin (1951): mu p for r >= c, and (2/pi) mu p [pi/2 + (K - E) F(psi, k') - K E(psi, k')] for r < c,
        with k' = c/a, K and E of the modulus k = sqrt(1 - k'^2), sin^2 psi = (1 - r^2/c^2)/(1 - r^2/a^2). The
        bracket has the rounding error of 1, however small its value.
        """
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

    source: ClassVar[str] = "Cattaneo-Mindlin, shifted"

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


def gross_slip_torque(hertz: HertzContact, friction: float) -> float:
    """Return the torque (3 pi/16) mu P a at which the whole circular contact slips."""
    return 3.0 * math.pi / 16.0 * friction * hertz.load * hertz.contact_radius


def lubkin(hertz: HertzContact, friction: float, torque: float, torsional_compliance: float) -> LubkinContact:
    """Return the contact under a torque below gross slip, mu > 0; Lubkin (1951).

    The shear is a superposition g(b) r/sqrt(b^2 - r^2) of rigid rotations of circles with radii b from c to a
    (Johnson, 3.9). An Abel transform of mu p gives g = (2 mu p0/pi) E/b, E of the modulus sqrt(1 - b^2/a^2);
    hence Mz = (8/3) mu p0 a^3 int_{c/a}^1 t^2 E(sqrt(1 - t^2)) dt and phi_z = (1/2) mu p0 (K - E) sum 1/G_i,
    K and E of the modulus sqrt(1 - c^2/a^2).
    """
    from scipy.integrate import quad
    from scipy.optimize import brentq
    from scipy.special import ellipe, elliprd

    limit = gross_slip_torque(hertz, friction)
    if abs(torque) >= limit:
        raise ValueError(f"the torque must be below that of gross slip, {limit:g} N mm")
    p0, a = hertz.max_pressure, hertz.contact_radius

    def excess(share: float) -> float:  # t = 1 - width s keeps small widths 1 - c/a exact
        width = share * widest
        value, _ = quad(
            lambda s: (1.0 - width * s) ** 2 * ellipe(width * s * (2.0 - width * s)), 0.0, 1.0, epsrel=1e-12
        )
        return share * float(value) / mean - 1.0

    # the torque is concave in the width, with the slope 4 pi/3 mu p0 a^3 at 0: Mz/(that) < width < Mz/limit
    widest, mean = abs(torque) / limit, 3.0 * math.pi**2 / 64.0
    width = widest * brentq(excess, 0.25, min(1.01, 1.0 / widest), xtol=1e-15, rtol=1e-15) if torque else 0.0
    modulus = width * (2.0 - width)  # k^2 = 1 - c^2/a^2
    difference = modulus / 3.0 * float(elliprd(0.0, 1.0 - modulus, 1.0))  # K - E
    phi_z = 0.5 * friction * p0 * difference * torsional_compliance
    return LubkinContact(hertz, friction, torque, a * (1.0 - width), math.copysign(phi_z, torque))


def torsion_error_without_in_plane_coupling(compliance_b: float, torsional_compliance: float) -> float:
    """Return the part of phi_z/Mz that is missed where ux from qy and uy from qx are left out.

    compliance_b: B, sum nu_i/G_i. A torque then meets A + 3B/4 instead of the torsional compliance A + B: the mean of
    A + B (sin^4 + cos^4) over the directions.
    """
    return 0.25 * compliance_b / torsional_compliance


@lru_cache  # error bars ask at each increment, and the root takes a quarter of a millisecond
def spence_stick_ratio(friction: float, dundurs_constant: float) -> float:
    """Return c/a of a sphere pressed on with friction >= 0, the shear not acting back on the pressure; Spence (1975).

    Root of (a/2c) ln((a + c)/(a - c)) = (mu/|beta|) K(sqrt(1 - c^2/a^2)): 1 for beta = 0, 0 for mu = 0.
    """
    if friction < 0.0:
        raise ValueError("the friction coefficient must not be negative")
    if dundurs_constant == 0.0:
        return 1.0
    ratio = friction / abs(dundurs_constant)
    if ratio < 0.04:  # c/a < 1e-10: K = ln(4a/c) and the left side is 1, to the last digit
        return 4.0 * math.exp(-1.0 / ratio) if ratio > 0.0 else 0.0

    def mismatch(log_v: float) -> float:
        v = math.exp(log_v)  # c/a = tanh v, so that the left side is v/tanh v
        return v / math.tanh(v) - ratio * complete_integral(math.tanh(v))

    # K falls with v, and v < v/tanh v: a root above 1 lies below the right side's value at v = 1
    upper = max(1.0, ratio * complete_integral(math.tanh(1.0)))
    return math.tanh(math.exp(growing_root(mismatch, math.log(1e-11), math.log(upper))))


def _one_minus_power(fraction: float, exponent: float) -> float:
    """Return 1 - (1 - fraction)^exponent without loss of digits for a small fraction."""
    return -math.expm1(exponent * math.log1p(-fraction)) if fraction < 1.0 else 1.0
