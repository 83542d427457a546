"""The friction law of a case that is not one coefficient, such as a formula of the place or a measured map.

A step of the coefficient costs an error of the order of a cell's side. The mean coefficient of each cell, from a few
points in the cell, halves that error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.expression import Expression
from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.keys.surface_specs import HeightsSurface
from fretsolve.case.keys.unrolled_path import stage_friction
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.friction.limit import FrictionOnGrid
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.model.height_map import HeightMap, load_height_map
from fretsolve.system.arrays import DoubleArray

POINTS_IN_A_CELL = 8
"""Points per side of a cell, of which the mean is taken."""

SCALES = np.concatenate([[0.0], np.geomspace(1e-6, 1e3, 181)])
"""Distances (mm) from the middle at which a formula is tried for its largest value."""

LARGEST_ESTIMATE, USUAL = 10.0, 0.3


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
            return USUAL  # it may have friction in places so small that none was tried
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
        values = load_height_map(_as_heights(spec, case.plane is not None), ("friction",))
    except CaseError as error:
        key = tuple("map" if part == "file" else part for part in error.key)
        raise case.source.problem(_of_friction(error.message), key) from None
    except FileError as error:
        raise FileError(_of_friction(error.message), error.file) from None
    return FrictionField(None, values, spec.center or (0.0, 0.0))


def _of_friction(message: str) -> str:
    """Return a message about a map of heights as one about a map of friction."""
    return message.replace("height map", "friction map").replace("height", "value")


def _as_heights(spec: FrictionSpec, line: bool) -> HeightsSurface:
    """Return the map as heights in mm, which are read alike."""
    kind: type[HeightsSurface] = HeightsSurface
    if line:
        from fretsolve.case.line_case import LineHeights  # other cases need none of it

        kind = LineHeights
    return kind.model_construct(
        file=spec.map, dataset=spec.dataset, spacing=spec.spacing, unit=1.0, invert=False, center=(0.0, 0.0)
    )
