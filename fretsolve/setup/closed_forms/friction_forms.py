"""Closed forms where the friction limit is not one coefficient times the pressure, and fixed over the load path."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.keys.unrolled_path import stage_friction
from fretsolve.case.models import Case
from fretsolve.friction.law import friction_field
from fretsolve.friction.limit import FrictionOnGrid
from fretsolve.reference.hertz import HertzContact
from fretsolve.reference.slip_from_rim import RimSlipBound
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.reference.line import LineContact

ANGLES, RADII = 32, 64
"""Places at which a formula must have the same value all round."""

NODES = 400
"""Radii of a quadrature over an ellipse."""

LINE_POINTS = 4000
"""Points of a quadrature over the width of a line contact, dense at its ends."""


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


def line_gross_slip_force(friction: FrictionOnContact, contact: LineContact) -> float | None:
    """Return the force (N/mm) at which a line contact slips, int b dx; None unless the coefficient is known."""
    if not friction.is_known:
        return None
    turn = (np.arange(LINE_POINTS) + 0.5) * (math.pi / LINE_POINTS)
    x = contact.half_width * np.cos(turn)
    limit = friction.limit(x, np.zeros_like(x), contact.pressure(x))
    return contact.half_width * math.pi / LINE_POINTS * float(np.sum(np.sin(turn) * limit))


@dataclass(frozen=True)
class FrictionForms:
    """Closed forms for the friction limit of a case on Hertz's contact."""

    friction: FrictionOnContact
    hertz: HertzContact

    @cached_property
    def is_fixed(self) -> bool:
        """True if the limit depends on place and pressure alone, alike in all directions."""
        case = self.friction.case
        number = isinstance(case.friction.coefficient, float) and not stage_friction(case.load_path)
        return number or case.friction.expression is not None

    @cached_property
    def gross_slip_force(self) -> float | None:
        """The force (N) of gross slip, int b dA; None unless the coefficient is a number or a formula."""
        if not self.friction.is_known:
            return None
        nodes, weights = np.polynomial.legendre.leggauss(NODES)
        rho, turn = 0.5 * (nodes + 1.0), np.arange(4 * ANGLES) * (2.0 * math.pi / (4 * ANGLES))
        a, b = self.hertz.semi_axes
        along, across = a * rho[:, None] * np.cos(turn), b * rho[:, None] * np.sin(turn)
        cosine, sine = math.cos(self.hertz.angle), math.sin(self.hertz.angle)
        limit = self._at(along * cosine - across * sine, along * sine + across * cosine, rho[:, None])
        return math.pi * a * b * float(np.sum(weights * rho * limit.mean(axis=1)))

    def rim_slip(self, compliance: float) -> RimSlipBound | None:
        """Return the limit for Abel's transform; None unless it is fixed, axisymmetric, and slip grows from the rim.

        compliance: the tangential one (1/MPa).
        """
        if not self.is_fixed or not self.hertz.is_circle or not self._is_axisymmetric:
            return None
        bound = RimSlipBound(self._on_radius, self.hertz.contact_radius, compliance)
        return bound if bound.slips_from_rim else None

    @cached_property
    def _is_axisymmetric(self) -> bool:
        if self.friction.case.friction.expression is None:
            return True
        r = np.linspace(0.0, self.hertz.contact_radius, RADII)[:, None]
        turn = (np.arange(ANGLES) + 0.3) * (2.0 * math.pi / ANGLES)
        values = self.friction.coefficient(r * np.cos(turn), r * np.sin(turn))
        if not np.isfinite(values).all():
            return False
        return bool(np.ptp(values, axis=1).max() <= 1e-9 * np.abs(values).max())

    def _on_radius(self, r: DoubleArray) -> DoubleArray:
        return self._at(r, np.zeros_like(r), r / self.hertz.contact_radius)

    def _at(self, x: DoubleArray, y: DoubleArray, rho: DoubleArray) -> DoubleArray:
        """Return the limit (MPa) at x, y (mm) from the middle; rho: distance over the contact's in that direction."""
        return self.friction.limit(x, y, self.hertz.max_pressure * np.sqrt(np.maximum(1.0 - rho**2, 0.0)))
