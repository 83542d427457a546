"""Gross slip and slip from the rim where the friction limit is not one coefficient times the pressure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.case.keys.unrolled_path import stage_friction
from fretsolve.case.models import Case
from fretsolve.problem.friction.law import friction_field
from fretsolve.problem.friction.limit import FrictionOnGrid
from fretsolve.reference.hertz import HertzContact
from fretsolve.reference.line import LineContact
from fretsolve.reference.slip_from_rim import RimFrictionLimit
from fretsolve.system.arrays import DoubleArray

ANGLES, RADII, NODES, LINE_POINTS = 32, 64, 400, 4000
"""Places at which a formula must have one value all round; radii of the quadrature over an ellipse, and points of the
quadrature over the width of a line contact, which are dense at its ends."""


@dataclass(frozen=True)
class FrictionOnContact:
    """The friction limit of a case on a contact. center: of the contact (mm); stage_coefficient: of a stage."""

    case: Case
    center: tuple[float, float]
    stage_coefficient: float | None = None

    @property
    def number(self) -> float | None:
        """The coefficient, where it is one number: that of the stage, or of the case."""
        of_case = self.case.friction.coefficient
        return of_case if self.stage_coefficient is None and isinstance(of_case, float) else self.stage_coefficient

    @property
    def is_known(self) -> bool:
        """True if the coefficient is a number or a formula."""
        return self.number is not None or self.case.friction.expression is not None

    @cached_property
    def coefficient(self) -> Callable[[DoubleArray, DoubleArray], DoubleArray]:
        """The coefficient at x, y (mm) from the middle of the contact."""
        field = friction_field(self.case) if self.case.friction.expression is not None else None
        if field is None or field.formula is None:
            return lambda x, y: np.full(np.broadcast_shapes(x.shape, y.shape), self.number, np.float64)
        formula, (x0, y0) = field.formula, self.center

        def value(x: DoubleArray, y: DoubleArray) -> DoubleArray:
            at_x, at_y = x + x0, y + y0
            found = formula(x=at_x, y=at_y, r=np.hypot(at_x, at_y))
            return np.array(np.broadcast_to(found, np.broadcast_shapes(x.shape, y.shape)), np.float64)

        return value

    def limit(self, x: DoubleArray, y: DoubleArray, pressure: DoubleArray) -> DoubleArray:
        """Return the friction limit (MPa) at x, y (mm) from the middle, under `pressure` (MPa)."""
        values = np.asarray(self.coefficient(x, y))
        shape = np.broadcast_shapes(values.shape, pressure.shape)
        law = FrictionOnGrid(self.case.friction, np.broadcast_to(values, shape))
        return law.limit().limit(np.broadcast_to(pressure, shape)).astype(np.float64)

    def line_gross_slip_force(self, contact: LineContact) -> float | None:
        """Return the force (N/mm) at which a line contact slips, int b dx; None unless the coefficient is known."""
        if not self.is_known:
            return None
        turn = (np.arange(LINE_POINTS) + 0.5) * (math.pi / LINE_POINTS)
        x = contact.half_width * np.cos(turn)
        limit = self.limit(x, np.zeros_like(x), contact.pressure(x))
        return contact.half_width * math.pi / LINE_POINTS * float(np.sum(np.sin(turn) * limit))

    def gross_slip_force(self, hertz: HertzContact) -> float | None:
        """Return the force (N) at which a contact slips, int b dA; None unless the coefficient is known."""
        if not self.is_known:
            return None
        nodes, weights = np.polynomial.legendre.leggauss(NODES)
        rho, turn = 0.5 * (nodes + 1.0), np.arange(4 * ANGLES) * (2.0 * math.pi / (4 * ANGLES))
        a, b = hertz.semi_axes
        along, across = a * rho[:, None] * np.cos(turn), b * rho[:, None] * np.sin(turn)
        cosine, sine = math.cos(hertz.angle), math.sin(hertz.angle)
        x, y = along * cosine - across * sine, along * sine + across * cosine
        limit = self.limit(x, y, _pressure(hertz, rho[:, None]))
        return math.pi * a * b * float(np.sum(weights * rho * limit.mean(axis=1)))

    def rim_slip(self, hertz: HertzContact, compliance: float) -> RimFrictionLimit | None:
        """Return the limit for Abel's transform; None unless it is fixed, axisymmetric, and slip grows from the rim.

        compliance: the tangential one (1/MPa).
        """
        friction, a = self.case.friction, hertz.contact_radius
        of_number = isinstance(friction.coefficient, float) and not stage_friction(self.case.load_path)
        if not hertz.is_circle or not (of_number or self._is_axisymmetric(a)):
            return None

        def on_radius(r: DoubleArray) -> DoubleArray:
            return self.limit(r, np.zeros_like(r), _pressure(hertz, r / a))

        limit = RimFrictionLimit(on_radius, a, compliance)
        return limit if limit.slips_from_rim else None

    def _is_axisymmetric(self, radius: float) -> bool:
        """Return whether the coefficient is a formula with one value all round, out to `radius` (mm)."""
        if self.case.friction.expression is None:
            return False
        r = np.linspace(0.0, radius, RADII)[:, None]
        turn = (np.arange(ANGLES) + 0.3) * (2.0 * math.pi / ANGLES)
        values = self.coefficient(r * np.cos(turn), r * np.sin(turn))
        if not np.isfinite(values).all():
            return False
        return bool(np.ptp(values, axis=1).max() <= 1e-9 * np.abs(values).max())


def _pressure(hertz: HertzContact, rho: DoubleArray) -> DoubleArray:
    """Return Hertz's pressure (MPa) at a distance over the contact's in that direction."""
    return np.asarray(hertz.max_pressure * np.sqrt(np.maximum(1.0 - rho**2, 0.0)))
