"""The friction law of a case: which bound holds in an increment, given the state before it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.keys.unrolled_path import stage_friction
from fretsolve.case.models import Case
from fretsolve.friction.bound import FrictionBound
from fretsolve.friction.field import FrictionField, friction_field
from fretsolve.model.grid import Grid
from fretsolve.result.state import Fields
from fretsolve.system.arrays import BoolArray, FloatArray


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


@dataclass(frozen=True)
class FrictionOnGrid:
    """A friction law on a grid. values: the coefficient (nx, ny); unknown: cells where a map does not give it."""

    spec: FrictionSpec
    values: FloatArray | None = None
    unknown: BoolArray | None = None

    def bound(self, before: Fields, coefficient: float | None = None) -> FrictionBound:
        """Return the bound in an increment. before: the fields at its start; coefficient: that of the stage."""
        return self._bound(self._coefficient(before, coefficient))

    def fixed_bound(self) -> FrictionBound:
        """Return the bound of `values`."""
        assert self.values is not None
        return self._bound(self.values)

    def _bound(self, coefficient: float | FloatArray) -> FrictionBound:
        spec = self.spec
        return FrictionBound(
            coefficient,
            math.inf if spec.shear_limit is None else spec.shear_limit,
            1.0 if spec.exponent is None else spec.exponent,
            1.0 if spec.reference_pressure is None else spec.reference_pressure,
        )

    def _coefficient(self, before: Fields, coefficient: float | None) -> float | FloatArray:
        if self.values is not None:
            return self.values
        spec = self.spec
        if spec.initial is not None and spec.final is not None:
            done = before.slip_path / spec.slip if spec.slip else before.work_density / (spec.energy or 1.0)
            return spec.final + (spec.initial - spec.final) * np.exp(-done.astype(np.float64))
        if spec.pair is not None:
            return math.sqrt(spec.pair[0] * spec.pair[1])
        if coefficient is None:
            assert isinstance(spec.coefficient, float)
            return spec.coefficient
        return coefficient

    def require_known(self, contact: BoolArray, grid: Grid, case: Case) -> None:
        """Raise CaseError where cells in contact, (nx, ny), are among those of which a map gives no coefficient."""
        if self.unknown is None or not (without := self.unknown & contact).any():
            return
        i, j = np.argwhere(without)[0].tolist()
        raise case.source.problem(
            "the contact reaches places of which the map gives no coefficient, beyond its end or in its holes, as at"
            f" x = {grid.x[i]:.4g} mm, y = {grid.y[j]:.4g} mm; take a map that covers the contact",
            ("friction", "map"),
        )


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
