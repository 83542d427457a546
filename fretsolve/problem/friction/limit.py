"""The friction limit of each cell as a function of its pressure, and the law that fixes it for each increment."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.models import Case
from fretsolve.problem.model.grid import Grid
from fretsolve.result.state import Fields
from fretsolve.system.arrays import TINY, BoolArray, FloatArray

MOST_GROWTH = 10.0
"""Cap on mu(p)/mu, which would diverge as p goes to 0."""


@dataclass(frozen=True)
class FrictionLimit:
    """The friction limit b = mu p, or b = min(mu p, shear_limit) with mu growing like p^(exponent - 1).

    coefficient: mu, or mu at the `reference_pressure` (MPa), a number or (nx, ny); shear_limit: in MPa; varied: whether
    it may differ from cell to cell, or from increment to increment.
    """

    coefficient: float | FloatArray
    shear_limit: float = math.inf
    exponent: float = 1.0
    reference_pressure: float = 1.0
    varied: bool = False

    def limit(self, pressure: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """Return the friction limit (MPa) under `pressure` >= 0 (MPa), an array of the same shape."""
        limit = np.multiply(pressure, self.coefficient, out=out)
        if self.exponent != 1.0:
            limit *= self._growth(pressure)[0]
        if self.shear_limit < math.inf:
            np.minimum(limit, self.shear_limit, out=limit)
        return limit

    def slope(self, pressure: FloatArray) -> FloatArray | float:
        """Return the derivative of the friction limit by the pressure, of its shape, or one number for all."""
        slope: FloatArray | float = self.coefficient
        if self.exponent != 1.0:
            growth, limited = self._growth(pressure)
            slope = slope * growth * np.where(limited, 1.0, self.exponent)
        if self.shear_limit < math.inf:
            slope = np.where(self.limit(pressure) < self.shear_limit, slope, 0.0)
        return slope

    def coefficient_at(self, pressure: FloatArray) -> FloatArray | float:
        """Return mu under `pressure` (MPa), without the shear limit; one number where all cells have it."""
        return self.coefficient if self.exponent == 1.0 else self.coefficient * self._growth(pressure)[0]

    def part(self, cells: Any) -> FrictionLimit:
        """Return the friction limit of some cells; cells: an index of fields (nx, ny)."""
        if isinstance(self.coefficient, float):
            return self
        return replace(self, coefficient=self.coefficient[cells])

    def _growth(self, pressure: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the factor on the coefficient by the pressure, and where it is limited."""
        ratio = np.maximum(pressure, TINY) / self.reference_pressure
        growth = ratio ** (self.exponent - 1.0)
        return np.minimum(growth, MOST_GROWTH), growth > MOST_GROWTH


@dataclass(frozen=True)
class FrictionOnGrid:
    """The friction of a case on a grid, from which the limit of each increment follows.

    values: the coefficient (nx, ny), where it varies from place to place; unknown: cells where a map does not give it;
    varied: as in `FrictionLimit`.
    """

    spec: FrictionSpec
    values: FloatArray | None = None
    unknown: BoolArray | None = None
    varied: bool = True

    def limit(self, before: Fields | None = None, coefficient: float | None = None) -> FrictionLimit:
        """Return the friction limit in an increment.

        before: the fields at its start, which friction that runs in depends on; coefficient: of the stage.
        """
        spec = self.spec
        return FrictionLimit(
            self._coefficient(before, coefficient),
            math.inf if spec.shear_limit is None else spec.shear_limit,
            1.0 if spec.exponent is None else spec.exponent,
            1.0 if spec.reference_pressure is None else spec.reference_pressure,
            self.varied,
        )

    def _coefficient(self, before: Fields | None, coefficient: float | None) -> float | FloatArray:
        if self.values is not None:
            return self.values
        spec = self.spec
        if spec.initial is not None and spec.final is not None:
            assert before is not None
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
