"""The friction law of a case that is not one coefficient, such as a formula of the place or a measured map.

A step of the coefficient costs an error of the order of a cell's side. The mean coefficient of each cell, from a few
points in the cell, halves that error. `FrictionOnContact` gives closed forms their limit on a contact: gross slip, and
slip from the rim.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.case.expression import Expression
from fretsolve.case.keys.unrolled_path import stage_friction
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.friction.limit import FrictionOnGrid
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.load_map import load_value_map
from fretsolve.reference.hertz import HertzContact, LineContact
from fretsolve.reference.slip_from_rim import RimFrictionLimit
from fretsolve.system.arrays import DoubleArray

POINTS_IN_A_CELL = 8
"""Points per side of a cell, of which the mean is taken."""

SCALES = np.concatenate([[0.0], np.geomspace(1e-6, 1e3, 181)])
"""Distances (mm) from the middle at which a formula is tried for its largest value."""

LARGEST_ESTIMATE = 10.0


@dataclass(frozen=True)
class FrictionField:
    """The coefficient at any place; `formula` or `map` about `center` (mm)."""

    formula: Expression | None
    map: HeightMap | None = None
    center: tuple[float, float] = (0.0, 0.0)

    def at(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Return the coefficient (nx, ny) at `x` (nx,), `y` (ny,) in mm; infinite off the map and in its holes."""
        if self.map is not None:
            return self.map.sample(x - self.center[0], y - self.center[1])
        assert self.formula is not None
        across, along = x[:, None], y[None, :]
        value = self.formula(x=across, y=along, r=np.hypot(across, along))
        return np.array(np.broadcast_to(value, (x.size, y.size)), np.float64)

    def on(self, grid: Grid) -> DoubleArray:
        """Return the mean over each cell, (nx, ny).

        It is infinite or NaN where it is so at any of the cell's points, and the least one where that is negative.
        """
        offsets = (np.arange(POINTS_IN_A_CELL) + 0.5) / POINTS_IN_A_CELL - 0.5
        along_y = np.zeros(1) if isinstance(grid, LineGrid) else offsets * grid.dy
        total, least = np.zeros(grid.shape), np.zeros(grid.shape)
        for dx in offsets * grid.dx:
            for dy in along_y[: along_y.size // 2]:  # in pairs, so that mirror images about y = 0 have the same sums
                one, other = self.at(grid.x + dx, grid.y + dy), self.at(grid.x + dx, grid.y - dy)
                total += one + other
                for values in (one, other):
                    np.minimum(least, values, out=least)
            if along_y.size % 2:
                middle = self.at(grid.x + dx, grid.y)
                total += middle
                np.minimum(least, middle, out=least)
        mean: DoubleArray = np.where(least < 0.0, least, total / (POINTS_IN_A_CELL * along_y.size))
        return mean

    def largest(self) -> float:
        """Return an estimate of the largest coefficient, which scales, but never bounds, what depends on it."""
        if self.map is not None:
            return float(np.max(self.map.values, where=np.isfinite(self.map.values), initial=0.0))
        both = np.concatenate([-SCALES[:0:-1], SCALES])
        values = self.at(both, both)
        found = float(np.max(values, where=np.isfinite(values), initial=0.0))
        if found == 0.0 and self.formula is not None and self.formula.varies:
            return 0.3  # a usual one, as it may have friction in places so small that none was tried
        return min(found, LARGEST_ESTIMATE)


@dataclass(frozen=True)
class FrictionLaw:
    """The friction of a case that is not one coefficient throughout. largest: an estimate of its largest coefficient.

    field: the coefficient over the contact, where it varies from place to place.
    """

    case: Case
    field: FrictionField | None
    largest: float

    def on(self, grid: Grid) -> FrictionOnGrid:
        """Return the law on the cells of a grid. Raises CaseError where the coefficient is negative or no number."""
        if self.field is None:
            return FrictionOnGrid(self.case.friction)
        values = self.field.on(grid)
        unknown = None
        if self.field.map is not None:
            unknown = ~np.isfinite(values)
            values[unknown] = 0.0
        wrong = np.argwhere(~(np.isfinite(values) & (values >= 0.0)))
        if len(wrong):
            i, j = wrong[0].tolist()
            raise self.case.source.problem(
                f"the coefficient is {values[i, j]:.4g} at x = {grid.x[i]:.4g} mm, y = {grid.y[j]:.4g} mm; a finite"
                " number >= 0 is needed on all of the grid",
                ("friction", self.case.friction.kind),
            )
        return FrictionOnGrid(self.case.friction, values, unknown)


def friction_law(case: Case) -> FrictionLaw | None:
    """Return the friction law of a case, None where it is one coefficient. Raises FileError, CaseError."""
    if not case.friction_varies:
        return None
    spec, field = case.friction, friction_field(case)
    if spec.pair is not None:
        return FrictionLaw(case, None, math.sqrt(spec.pair[0] * spec.pair[1]))
    known = [spec.initial, spec.final, spec.coefficient, *(mu for _, mu in spec.cycles or ())]
    known += stage_friction(case.load_path)
    known.append(None if field is None else field.largest())
    return FrictionLaw(case, field, max(value for value in known if isinstance(value, float)))


def friction_field(case: Case) -> FrictionField | None:
    """Return the field of a case's friction, None where it has none.

    Raises FileError where a map cannot be read, CaseError where it holds none.
    """
    spec = case.friction
    if spec.expression is not None:
        return FrictionField(Expression(spec.expression))
    if spec.map is None:
        return None
    try:
        values = load_value_map(spec.map, spec, ("friction",), line=case.plane is not None)
    except CaseError as error:
        key = tuple("map" if part == "file" else part for part in error.key)
        raise case.source.problem(_of_friction(error.message), key) from None
    except FileError as error:
        raise FileError(_of_friction(error.message), error.file) from None
    return FrictionField(None, values, spec.center or (0.0, 0.0))


def _of_friction(message: str) -> str:
    """Return a message about a map of heights as one about a map of friction."""
    return message.replace("height map", "friction map").replace("height", "value")


@dataclass(frozen=True)
class FrictionOnContact:
    """The friction limit of a case on a contact. center: of the contact (mm); stage_coefficient: of a stage."""

    case: Case
    center: tuple[float, float]
    stage_coefficient: float | None = None

    @property
    def number(self) -> float | None:
        """The coefficient, where it is one number: the stage's coefficient, or the case's."""
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
        points = 4000  # dense at the ends of the contact
        turn = (np.arange(points) + 0.5) * (math.pi / points)
        x = contact.half_width * np.cos(turn)
        limit = self.limit(x, np.zeros_like(x), contact.pressure(x))
        return contact.half_width * math.pi / points * float(np.sum(np.sin(turn) * limit))

    def gross_slip_force(self, hertz: HertzContact) -> float | None:
        """Return the force (N) at which a contact slips, int b dA; None unless the coefficient is known."""
        if not self.is_known:
            return None
        nodes, weights = np.polynomial.legendre.leggauss(400)
        rho, turn = 0.5 * (nodes + 1.0), np.arange(128) * (2.0 * math.pi / 128)
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
        r = np.linspace(0.0, radius, 64)[:, None]
        turn = (np.arange(32) + 0.3) * (2.0 * math.pi / 32)
        values = self.coefficient(r * np.cos(turn), r * np.sin(turn))
        if not np.isfinite(values).all():
            return False
        return bool(np.ptp(values, axis=1).max() <= 1e-9 * np.abs(values).max())


def _pressure(hertz: HertzContact, rho: DoubleArray) -> DoubleArray:
    """Return Hertz's pressure (MPa) at a distance over the contact's in that direction."""
    return np.asarray(hertz.max_pressure * np.sqrt(np.maximum(1.0 - rho**2, 0.0)))
