"""A sphere worn by fretting at constant load: the limit of partial slip, and gross slip; a cylinder in gross slip.

In partial slip the stick zone keeps its radius c and its shape, and wear ends when no pressure is left around it (Popov
2014): inside c Abel's transform keeps the unworn sphere's function g(x) = x^2/R, and outside the profile that is just
not pressed is, with the approach d,

    h(r) = (2/pi) {(1/R) [(r^2/2) asin(c/r) - (c/2) sqrt(r^2 - c^2)] + d [pi/2 - asin(c/r)]},  c < r < a

Below, r = c sqrt(1 + u^2), by which the worn depth is (c^2/pi R) [D atan u - (1 + u^2) atan u - u], D = 2dR/c^2.
In gross slip all cells slip as far, and the pressure becomes uniform, since the profile sinks as a whole. Compliances
are as in `fretsolve.problem.model.materials.Compliances`. Every function raises ValueError outside its stated range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretsolve.reference.hertz import HertzContact, HertzLine, growing_root, hertz_sphere
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True)
class WornLimit:
    """A sphere of `radius` R that partial slip has worn until nothing wears any more.

    stick_radius: c (mm); delta_z: approach d from first touch of the unworn sphere (mm), at least c^2/R;
    contact_modulus: E* (MPa).
    """

    stick_radius: float
    delta_z: float
    radius: float
    contact_modulus: float

    def __post_init__(self) -> None:
        positive = min(self.stick_radius, self.radius, self.contact_modulus) > 0.0
        if not positive or self._overclosure < -1e-12 * self.delta_z:
            raise ValueError("stick radius, radius and modulus must be positive, and the approach at least c^2/R")

    @property
    def load(self) -> float:
        """P = 2 E* (d c - c^3/3R) (N)."""
        c = self.stick_radius
        return 2.0 * self.contact_modulus * (self.delta_z * c - c**3 / (3.0 * self.radius))

    @cached_property
    def scar_radius(self) -> float:
        """The radius a (mm) where the worn profile meets the sphere, h(a) = a^2/2R; c if nothing is worn."""
        return self.stick_radius * math.hypot(1.0, self._rim)

    @cached_property
    def volume(self) -> float:
        """The worn volume V (mm^3), the integral of h - r^2/2R over the scar."""
        nodes, weights = np.polynomial.legendre.leggauss(120)
        u = 0.5 * self._rim * (nodes + 1.0)
        return math.pi * self._rim * self.stick_radius**2 * float(np.sum(weights * u * self._depth(u)))

    def with_stick_radius(self, radius: float, *, load_kept: bool) -> WornLimit:
        """Return the limit with another stick radius (mm) under the same P, or else at the same approach."""
        depth = self.delta_z
        if load_kept:
            depth = self.load / (2.0 * self.contact_modulus * radius) + radius**2 / (3.0 * self.radius)
        largest = math.sqrt(depth * self.radius)
        return replace(self, stick_radius=min(radius, largest), delta_z=depth)

    def shear_force(self, friction: float) -> float:
        """Return the largest tangential force of the cycle, 2 mu E* c (d - c^2/R) (N)."""
        return 2.0 * friction * self.contact_modulus * self.stick_radius * self._overclosure

    def depth(self, r: DoubleArray) -> DoubleArray:
        """Return the worn depth h - r^2/2R (mm) at distances `r`."""
        worn = (np.abs(r) > self.stick_radius) & (np.abs(r) < self.scar_radius)
        u = np.sqrt(np.maximum(np.square(r / self.stick_radius) - 1.0, 0.0))
        return np.where(worn, np.maximum(self._depth(u), 0.0), 0.0)

    def profile(self, r: DoubleArray) -> DoubleArray:
        """Return the separation h (mm) at distances `r`, worn within the scar and r^2/2R elsewhere."""
        return np.square(r) / (2.0 * self.radius) + self.depth(r)

    def pressure(self, r: DoubleArray) -> DoubleArray:
        """Return (E*/pi) [(d - c^2/R)/sqrt(c^2 - r^2) + (2/R) sqrt(c^2 - r^2)] at `r` (MPa), infinite at c; else 0."""
        root = np.sqrt(np.maximum(self.stick_radius**2 - np.square(r), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            p = self.contact_modulus / math.pi * (self._overclosure / root + 2.0 / self.radius * root)
        return np.where(np.abs(r) <= self.stick_radius, p, 0.0)

    @property
    def _overclosure(self) -> float:
        return self.delta_z - self.stick_radius**2 / self.radius

    @cached_property
    def _rim(self) -> float:
        """u where the worn depth is 0 again: sec^2 t + t^-1 tan t = D with u = tan t."""
        from scipy.optimize import brentq

        ratio = 2.0 * self.delta_z * self.radius / self.stick_radius**2
        if ratio <= 2.0:
            return 0.0

        def excess(t: float) -> float:
            u = math.tan(t)
            return ratio - 1.0 - u**2 - (u / t if t else 1.0)

        return math.tan(float(brentq(excess, 0.0, math.acos(1.0 / math.sqrt(ratio)), xtol=1e-15)))

    def _depth(self, u: DoubleArray) -> DoubleArray:
        c, angle = self.stick_radius, np.arctan(u)
        linear = 2.0 * self.delta_z * self.radius / c**2 - 1.0 - np.square(u)
        return np.asarray(c**2 / (math.pi * self.radius) * (linear * angle - u))


def worn_limit_at_force(
    load: float, shear_force: float, friction: float, radius: float, contact_modulus: float
) -> WornLimit:
    """Return the worn limit of a sphere under P and cycles of force +-Q, 0 < |Q| < mu P, with P kept.

    c = a0 (1 - Q/mu P)^(1/3), as before the wear: Q = mu P - 4 mu E* c^3/3R whatever the profile outside of c.
    d = P/2E*c + c^2/3R.
    """
    if not abs(shear_force) < friction * load:
        raise ValueError("the force must be below mu P")
    unworn = hertz_sphere(load, radius, contact_modulus)
    c = unworn.contact_radius * math.cbrt(1.0 - abs(shear_force) / (friction * load))
    return WornLimit(c, load / (2.0 * contact_modulus * c) + c**2 / (3.0 * radius), radius, contact_modulus)


def worn_limit_at_displacement(
    delta_z: float, delta_x: float, friction: float, radius: float, contact_modulus: float, compliance: float
) -> WornLimit:
    """Return the worn limit of a sphere under cycles of displacement +-delta_x, with the approach kept; P falls.

    d - c^2/R = (G*/E*) delta_x/mu with G* = 4/S. compliance: the tangential one, S (1/MPa).
    """
    square = radius * (delta_z - 4.0 * abs(delta_x) / (compliance * contact_modulus * friction))
    if not square > 0.0:
        raise ValueError("the displacement must be below that of gross slip")
    return WornLimit(math.sqrt(square), delta_z, radius, contact_modulus)


@dataclass(frozen=True)
class WornByGrossSlip:
    """A sphere under a constant load, worn by gross slip until `volume` V (mm^3) is gone.

    The pressure is taken as uniform over the scar, which becomes exact as V grows: at V = pi a0^4/4R, a0 the radius of
    contact before, the scar radius is 4 % too small and the approach 1 %; at ten times that 0.3 % and 0.2 %.
    unworn: Hertz's contact of the sphere.
    """

    unworn: HertzContact
    contact_modulus: float
    volume: float

    def __post_init__(self) -> None:
        if not self.volume > 0.0 or not self.unworn.is_circle:
            raise ValueError("a positive worn volume and a circular contact are needed")

    @cached_property
    def scar_radius(self) -> float:
        """Root of a^4 - (64/9 pi^2) a0^3 a = 4 R V/pi (mm)."""
        from scipy.optimize import brentq

        a0, rigid = self.unworn.contact_radius, self.rigid_scar_radius
        elastic = 64.0 / (9.0 * math.pi**2) * a0**3
        most = rigid + a0  # (rigid + a0)^4 > rigid^4 + a0^3 (rigid + a0)
        return float(brentq(lambda a: a**4 - elastic * a - rigid**4, rigid, most, xtol=1e-15 * most))

    @property
    def rigid_scar_radius(self) -> float:
        """(4 R V/pi)^(1/4), the radius of the cap that is gone (mm)."""
        return math.sqrt(math.sqrt(4.0 * self.unworn.radii[0] * self.volume / math.pi))

    @property
    def delta_z(self) -> float:
        """a^2/2R + 4 P/(pi^2 E* a), from first touch of the unworn sphere (mm)."""
        return self._cap + self._sinking

    @property
    def center_depth(self) -> float:
        """The worn depth in the middle, a^2/2R - (4 P/pi^2 E* a) (pi/2 - 1) (mm)."""
        return self._cap - self._sinking * (0.5 * math.pi - 1.0)

    @property
    def mean_pressure(self) -> float:
        """P/(pi a^2) (MPa)."""
        return self.unworn.load / (math.pi * self.scar_radius**2)

    @property
    def _cap(self) -> float:
        return self.scar_radius**2 / (2.0 * self.unworn.radii[0])

    @property
    def _sinking(self) -> float:
        return 4.0 * self.unworn.load / (math.pi**2 * self.contact_modulus * self.scar_radius)


def worn_by_gross_slip(load: float, radius: float, contact_modulus: float, volume: float) -> WornByGrossSlip:
    """Return a sphere under `load` > 0 of which gross slip has worn `volume` > 0 (mm^3)."""
    return WornByGrossSlip(hertz_sphere(load, radius, contact_modulus), contact_modulus, volume)


@dataclass(frozen=True)
class CylinderWornByGrossSlip:
    """A cylinder under a constant load, worn by gross slip until `volume` V (mm^3/mm) is gone.

    The pressure is taken as uniform, as above: it moves the surface by -(A/pi) times the integral of p ln|x - s|
    (Johnson, Contact Mechanics (1985), section 2.5(a)), which the scar's profile makes up for. unworn: Hertz's contact;
    depth: length of the logarithm in delta_z (mm), in units of which a force does not sink the points it refers to.
    """

    unworn: HertzLine
    volume: float
    depth: float

    def __post_init__(self) -> None:
        if not self.volume > 0.0:
            raise ValueError("a positive worn volume is needed")

    @cached_property
    def scar_radius(self) -> float:
        """Half-width, the root of a^3 - (3/4) a0^2 a = (3/2) R V (mm)."""
        square, cubed = 0.75 * self.unworn.half_width**2, 1.5 * self.unworn.radius * self.volume
        return growing_root(
            lambda a: a**3 - square * a - cubed, math.sqrt(square), math.sqrt(square) + math.cbrt(cubed)
        )

    @property
    def delta_z(self) -> float:
        """a^2/2R + (A P/pi) (1 + ln(depth/2a)), from first touch of the unworn cylinder (mm)."""
        return self._cap + self._sinking * (1.0 + math.log(0.5 * self.depth / self.scar_radius))

    @property
    def center_depth(self) -> float:
        """The worn depth in the middle, a^2/2R - (A P/pi) ln 2 (mm)."""
        return self._cap - self._sinking * math.log(2.0)

    @property
    def mean_pressure(self) -> float:
        """P/2a (MPa)."""
        return 0.5 * self.unworn.load / self.scar_radius

    @property
    def _cap(self) -> float:
        return 0.5 * self.scar_radius**2 / self.unworn.radius

    @property
    def _sinking(self) -> float:
        """A P/pi, A = 2/E*."""
        return 2.0 * self.unworn.load / (math.pi * self.unworn.contact_modulus)


def volume_scale(unworn: HertzContact) -> float:
    """Return V0 = pi a0^4/4R (mm^3), the cap of a sphere within its contact radius before wear."""
    return 0.25 * math.pi * unworn.contact_radius**4 / unworn.radii[0]


def partial_slip_wear_time(
    unworn: HertzContact, friction: float, contact_modulus: float, compliance: float, alpha: float, cycles: float
) -> float:
    """Return T = 4 alpha mu^2 N (E*/G*) E* a0/R of partial slip: little is worn below 0.1, the limit is near above 100.

    G* = 4/S; alpha: mm^3 per mJ, so that alpha mu is k of Archard's law; compliance: the tangential one, S (1/MPa).
    """
    scale = contact_modulus**2 * compliance * unworn.contact_radius / unworn.radii[0]
    return alpha * friction**2 * cycles * scale
