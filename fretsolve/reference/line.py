"""Line contact in plane strain without friction, all loads per mm of its length: cylinder and rounded punch.

Sources: Hertz as in Johnson, Contact Mechanics (1985), section 4.2; Ciavarella, Hills & Monno (1998) for the rounded
punch; Spence (1973) for the stick zone of contacts that grow without changing shape. Every function raises ValueError
outside its stated range. `line_slip` has partial slip on these contacts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fretsolve.reference.elliptic import growing_root, modulus
from fretsolve.system.arrays import DoubleArray

NEAREST_ANGLE = 1e-9
"""Angle between a point of the rounded punch and the end of its flat, where two infinite terms cancel, at least."""


class LineContact(Protocol):
    """A symmetric line contact: load (N/mm), half-width a (mm), largest pressure (MPa)."""

    @property
    def load(self) -> float: ...

    @property
    def half_width(self) -> float: ...

    @property
    def max_pressure(self) -> float: ...

    def pressure(self, x: DoubleArray) -> DoubleArray:
        """Return the pressure at `x` from the middle; 0 outside."""

    def under(self, load: float) -> LineContact:
        """Return the contact of the same bodies at another load > 0."""


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

    def under(self, load: float) -> RoundedPunch:
        """Return the contact at another load > 0."""
        return RoundedPunch(load, self.flat, self.radius, self.contact_modulus)


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
