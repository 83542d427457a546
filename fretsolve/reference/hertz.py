"""Bodies pressed together without friction: sphere, ellipsoid, cone and punch, and per mm of a line cylinder and punch.

Sources: Johnson, Contact Mechanics (1985), chapters 3 and 4; Love (1939); Boussinesq (1885); Ciavarella, Hills & Monno
(1998) for the rounded punch; Spence (1973) for the stick zone of line contacts that grow without changing shape. Every
function raises ValueError outside its stated range. `line_slip` has partial slip on line contacts.

Elliptic integrals and roots are in plain Python: importing `scipy.special` takes 0.2 s of processor time and
`scipy.optimize` 0.4 s, which is more than many a small case takes to solve.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.system.arrays import DoubleArray


def complete_integral(complement: float, cosine: float = 1.0, sine: float = 1.0) -> float:
    """Return the integral of (cosine cos^2 f + sine sin^2 f)/sqrt(1 - k^2 sin^2 f) over f from 0 to pi/2.

    complement: k' = sqrt(1 - k^2) > 0. With k^2 D = K - E and k^2 B = E - k'^2 K, (1, 1) gives K, (0, 1) D, (1, 0) B
    and (1, k'^2) E. Nothing cancels. By Landen's transformation; Bulirsch (1965), procedure cel2.
    """
    mean, before, total, rest = 1.0, cosine, cosine + sine, sine
    while True:
        rest = 2.0 * (before * complement + rest)
        before, former, mean = total, mean, complement + mean
        total += rest / mean
        if abs(former - complement) <= 1e-8 * former:  # it converges quadratically
            return 0.25 * math.pi * total / mean
        complement = 2.0 * math.sqrt(complement * former)


def modulus(ratio: float) -> float:
    """Return the modulus k with K(k)/K(k') = ratio > 0, as theta functions of the nome give it; 0 or 1 by rounding."""
    if ratio > 1.0:
        complement = modulus(1.0 / ratio)
        return math.sqrt((1.0 - complement) * (1.0 + complement))
    root = math.exp(-0.25 * math.pi / ratio)
    nome = root**4  # 0.043 at most: nome^12 and nome^16 are left out
    return (2.0 * root * (1.0 + nome**2 + nome**6) / (1.0 + 2.0 * (nome + nome**4 + nome**9))) ** 2


def growing_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where `function`, which is not above 0 at `low` and not below 0 at `high`, grows through 0.

    Brent's method takes a sixth of the calls, which are of microseconds, but an import.
    """
    for _ in range(60):  # they leave 1e-18 of the interval
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)


@dataclass(frozen=True)
class HertzContact:
    """Hertz contact, circular or elliptic: load P, semi-axes, peak pressure p0, approach delta_z.

    radii: of curvature along the semi-axes; angle: from x to the first of them (rad).
    """

    load: float
    semi_axes: tuple[float, float]
    max_pressure: float
    delta_z: float
    radii: tuple[float, float]
    angle: float = 0.0

    @property
    def is_circle(self) -> bool:
        """True if both semi-axes are equal."""
        return self.semi_axes[0] == self.semi_axes[1]

    @property
    def contact_radius(self) -> float:
        """Radius a of a circle, or of the circle with the area of an ellipse."""
        a, b = self.semi_axes
        return a if a == b else math.sqrt(a * b)

    @property
    def size_over_radius(self) -> float:
        """a/R, the larger one of both directions."""
        return max(axis / radius for axis, radius in zip(self.semi_axes, self.radii, strict=True))

    @property
    def half_extent(self) -> tuple[float, float]:
        """Distances that the contact reaches from its centre along x and along y."""
        (a, b), cosine, sine = self.semi_axes, math.cos(self.angle), math.sin(self.angle)
        return math.hypot(a * cosine, b * sine), math.hypot(a * sine, b * cosine)

    def pressure(self, x: DoubleArray, y: DoubleArray | float = 0.0) -> DoubleArray:
        """Return the pressure at points `x`, `y` (of shapes that broadcast) about the centre; 0 outside."""
        (a, b), cosine, sine = self.semi_axes, math.cos(self.angle), math.sin(self.angle)
        along, across = cosine * x + sine * y, cosine * y - sine * x
        return self.max_pressure * np.sqrt(np.maximum(1.0 - np.square(np.hypot(along / a, across / b)), 0.0))


def hertz_sphere(load: float, radius: float, contact_modulus: float) -> HertzContact:
    """Return a sphere's contact at `load` > 0; Johnson (4.22-4.24).

    a^3 = 3 P R/4E*, p0 = 3P/2 pi a^2, delta_z = a^2/R.
    """
    _require(min(load, radius, contact_modulus) > 0.0, "load, radius and modulus must be positive")
    a = math.cbrt(0.75 * load * radius / contact_modulus)
    return HertzContact(load, (a, a), 1.5 * load / (math.pi * a**2), a**2 / radius, (radius, radius))


def hertz_sphere_at(delta_z: float, radius: float, contact_modulus: float) -> HertzContact:
    """Return a sphere's contact at `delta_z` > 0: a^2 = R delta_z, P = (4/3) E* a delta_z, p0 = 2 E* a/pi R."""
    _require(min(delta_z, radius, contact_modulus) > 0.0, "approach, radius and modulus must be positive")
    a, load = math.sqrt(radius * delta_z), 4.0 / 3.0 * contact_modulus * math.sqrt(radius * delta_z**3)
    return HertzContact(load, (a, a), 2.0 * contact_modulus * a / (math.pi * radius), delta_z, (radius, radius))


def hertz_elliptic(load: float, radius_x: float, radius_y: float, contact_modulus: float) -> HertzContact:
    """Return the contact at `load` > 0 for the separation x^2/2Rx + y^2/2Ry, radii > 0; Johnson, section 4.2.

    With k' = b/a, the shorter over the longer semi-axis, the curvatures are 1/2R_a = s D and 1/2R_b = s B/k'^2,
    s = p0 b/E* a^2, with the complete integrals D = (K - E)/k^2 and B = (E - k'^2 K)/k^2 of Johnson. Their ratio gives
    k'. The approach is (p0 b/E*) K(k).
    """
    _require(min(load, radius_x, radius_y, contact_modulus) > 0.0, "load, radii and modulus must be positive")
    long_radius, short_radius = max(radius_x, radius_y), min(radius_x, radius_y)

    def mismatch(log_axis_ratio: float) -> float:
        ratio = math.exp(log_axis_ratio)
        curvature_ratio = complete_integral(ratio, sine=0.0) / complete_integral(ratio, cosine=0.0) / ratio**2
        return math.log(long_radius / short_radius) - math.log(curvature_ratio)

    # b/a lies between R_b/R_a and 1: near (R_b/R_a)^(2/3) for a nearly round ellipse, larger for a slim one
    lowest = math.log(short_radius / long_radius)
    ratio = math.exp(growing_root(mismatch, lowest, 0.0)) if lowest < 0.0 else 1.0
    a = math.cbrt(3.0 * load * long_radius * complete_integral(ratio, cosine=0.0) / (math.pi * contact_modulus))
    b = ratio * a
    p0 = 1.5 * load / (math.pi * a * b)
    delta_z = p0 * b / contact_modulus * complete_integral(ratio)
    semi_axes = (a, b) if radius_x >= radius_y else (b, a)
    return HertzContact(load, semi_axes, p0, delta_z, (radius_x, radius_y))


@dataclass(frozen=True)
class RoundContact:
    """Contact of a cone or a flat punch: load P, contact radius a, approach delta_z."""

    load: float
    contact_radius: float
    delta_z: float

    @property
    def mean_pressure(self) -> float:
        """p_m = P/(pi a^2)."""
        return self.load / (math.pi * self.contact_radius**2)


class FlatPunch(RoundContact):
    """Flat cylindrical punch."""

    def pressure(self, r: DoubleArray) -> DoubleArray:
        """Return P/(2 pi a sqrt(a^2 - r^2)) at distances `r` < a; infinite at the edge, 0 outside."""
        a = self.contact_radius
        with np.errstate(divide="ignore"):
            inside = self.load / (2.0 * np.pi * a * np.sqrt(np.maximum(a**2 - np.square(r), 0.0)))
        return np.where(np.asarray(r) <= a, inside, 0.0)


def boussinesq_punch(load: float, radius: float, contact_modulus: float) -> FlatPunch:
    """Return the contact of a flat punch of `radius` > 0 at `load` >= 0: P = 2 a E* delta_z, Johnson, section 3.4."""
    _require(load >= 0.0 and radius > 0.0 and contact_modulus > 0.0, "radius and modulus must be positive")
    return FlatPunch(load, radius, load / (2.0 * radius * contact_modulus))


class ConeContact(RoundContact):
    """Cone on a flat."""

    def pressure(self, r: DoubleArray) -> DoubleArray:
        """Return p_m arcosh(a/r) at distances `r` from the apex; infinite there, 0 outside."""
        with np.errstate(divide="ignore"):
            return self.mean_pressure * np.arccosh(np.maximum(self.contact_radius / np.asarray(r), 1.0))


def love_cone(load: float, angle: float, contact_modulus: float) -> ConeContact:
    """Return the contact at `load` > 0 of a cone whose flank makes `angle` (rad, below pi/2) with the contact plane.

    Love (1939), with t = tan(angle): P = (pi/2) a^2 E* t, delta_z = (pi/2) a t.
    """
    _require(load > 0.0 and contact_modulus > 0.0, "load and modulus must be positive")
    slope = _slope(angle)
    a = math.sqrt(2.0 * load / (math.pi * contact_modulus * slope))
    return ConeContact(load, a, 0.5 * math.pi * a * slope)


def love_cone_at(delta_z: float, angle: float, contact_modulus: float) -> ConeContact:
    """Return the contact of the cone of `love_cone` at the approach `delta_z` > 0."""
    _require(delta_z > 0.0 and contact_modulus > 0.0, "approach and modulus must be positive")
    a = 2.0 * delta_z / (math.pi * _slope(angle))
    return ConeContact(0.5 * math.pi * a**2 * contact_modulus * _slope(angle), a, delta_z)


def _slope(angle: float) -> float:
    _require(0.0 < angle < math.pi / 2, "the angle must lie between 0 and pi/2")
    return math.tan(angle)


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


NEAREST_ANGLE = 1e-9
"""Angle between a point of the rounded punch and the end of its flat, where two infinite terms cancel, at least."""


@dataclass(frozen=True)
class HertzLine:
    """A cylinder of `radius` pressed on a plane by `load` > 0 (N/mm): a^2 = 4 P R/pi E*, p0 = 2 P/pi a."""

    load: float
    radius: float
    contact_modulus: float

    def __post_init__(self) -> None:
        if min(self.load, self.radius, self.contact_modulus) <= 0.0:
            raise ValueError("load, radius and modulus must be positive")

    @property
    def half_width(self) -> float:
        """Half-width a of the contact (mm)."""
        return math.sqrt(4.0 * self.load * self.radius / (math.pi * self.contact_modulus))

    @property
    def max_pressure(self) -> float:
        """Pressure p0 in the middle (MPa)."""
        return 2.0 * self.load / (math.pi * self.half_width)

    def pressure(self, x: DoubleArray) -> DoubleArray:
        """Return the pressure at `x` from the middle; 0 outside."""
        return self.max_pressure * np.sqrt(np.maximum(1.0 - np.square(x / self.half_width), 0.0))

    def potential(self, length: float) -> float:
        """Return the integral of p(s) ln(length/|s|) over the contact, s from its middle (N/mm)."""
        return self.load * (math.log(2.0 * length / self.half_width) + 0.5)

    def under(self, load: float) -> HertzLine:
        """Return the contact at another load > 0."""
        return HertzLine(load, self.radius, self.contact_modulus)


@dataclass(frozen=True)
class RoundedPunch:
    """A punch, flat on abs(x) < `flat` and of `radius` beyond, pressed by `load` > 0 (N/mm).

    With sin f0 = flat/a the load is 4 P R/(E* a^2) = pi - 2 f0 - sin 2 f0.
    """

    load: float
    flat: float
    radius: float
    contact_modulus: float

    def __post_init__(self) -> None:
        if min(self.load, self.flat, self.radius, self.contact_modulus) <= 0.0:
            raise ValueError("load, flat, radius and modulus must be positive")

    @property
    def edge_angle(self) -> float:
        """The angle f0, from the load; the contact is a = flat/sin f0."""
        wanted = 4.0 * self.load * self.radius / (self.contact_modulus * self.flat**2)

        # With f0 = pi/2 - g the load is (2 g - sin 2 g)/cos^2 g, which grows from 0 to infinity.
        def excess(g: float) -> float:
            return _less_sine(2.0 * g) - wanted * math.cos(g) ** 2

        return 0.5 * math.pi - growing_root(excess, 0.0, 0.5 * math.pi)

    @property
    def half_width(self) -> float:
        """Half-width a of the contact (mm)."""
        return self.flat / math.sin(self.edge_angle)

    @property
    def max_pressure(self) -> float:
        """Largest pressure (MPa), near the ends of the flat."""
        from scipy.optimize import minimize_scalar

        a = self.half_width
        least = minimize_scalar(
            lambda x: -float(self.pressure(np.array([x]))[0]), bounds=(0.0, a), options={"xatol": 1e-9 * a}
        )
        return max(-float(least.fun), float(self.pressure(np.zeros(1))[0]))

    def pressure(self, x: DoubleArray) -> DoubleArray:
        """Return the pressure at `x` from the middle; 0 outside."""
        f0, a = self.edge_angle, self.half_width
        inside = np.abs(x) < a
        f = np.arcsin(np.abs(np.where(inside, x, 0.0)) / a)
        f = np.where(np.abs(f - f0) < NEAREST_ANGLE, f0 - NEAREST_ANGLE, f)
        shape = _less_sine(math.pi - 2.0 * f0)
        log_of_sines = np.log(np.abs(np.sin(f + f0) / np.sin(f - f0)))
        log_of_tangents = np.log(np.abs(np.tan(0.5 * (f + f0)) * np.tan(0.5 * (f - f0))))
        braces = (math.pi - 2.0 * f0) * np.cos(f) + np.sin(f) * log_of_sines + math.sin(f0) * log_of_tangents
        return np.where(inside, 2.0 * self.load / (math.pi * a * shape) * braces, 0.0)

    def potential(self, length: float) -> float:
        """Return the integral of p(s) ln(length/|s|) over the contact, s from its middle (N/mm).

        A load more presses as a flat punch does: the integral grows by ln(2 length/a) dP, which is integrated by parts.
        """
        nodes, weights = np.polynomial.legendre.leggauss(40)
        most = 0.5 * math.pi - self.edge_angle
        g = 0.5 * most * (nodes + 1.0)  # as in edge_angle, a = flat/cos g
        loads = 0.25 * self.contact_modulus * self.flat**2 / self.radius * (2.0 * g - np.sin(2.0 * g)) / np.cos(g) ** 2
        grown = 0.5 * most * float(np.sum(weights * loads * np.tan(g)))
        return self.load * math.log(2.0 * length / self.half_width) + grown

    def under(self, load: float) -> RoundedPunch:
        """Return the contact at another load > 0."""
        return RoundedPunch(load, self.flat, self.radius, self.contact_modulus)


LineContact = HertzLine | RoundedPunch
"""A symmetric line contact: load (N/mm), half-width a (mm), largest pressure (MPa)."""


def _less_sine(angle: float) -> float:
    """Return angle - sin(angle), without cancellation for small angles."""
    if abs(angle) > 0.5:
        return angle - math.sin(angle)
    square, term, total = angle * angle, angle**3 / 6.0, 0.0
    for n in range(4, 24, 2):
        total += term
        term *= -square / (n * (n + 1))
    return total


def pressed_stick_ratio(friction: float, dundurs_constant: float) -> float:
    """Return c/a of a cylinder or a flat punch under growing P alone on a dissimilar body; 1 for uncoupled bodies.

    K(c/a)/K(sqrt(1 - c^2/a^2)) = mu/abs(beta), K of the modulus, where shear does not act on the pressure (one-way).
    """
    if dundurs_constant == 0.0:
        return 1.0
    return modulus(friction / abs(dundurs_constant)) if friction > 0.0 else 0.0
