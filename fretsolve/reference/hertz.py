"""Bodies pressed together without friction: sphere, ellipsoid, cylinder, cone and flat punch.

Sources: Johnson, Contact Mechanics (1985), chapters 3 and 4; Love (1939); Boussinesq (1885). Every function raises
ValueError outside its stated range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.reference.elliptic import complete_integral, growing_root
from fretsolve.system.arrays import DoubleArray


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
