"""The friction limit of each cell as a function of its pressure, which stays the same within an increment."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretsolve.system.arrays import TINY, BoolArray, FloatArray

MOST_GROWTH = 10.0
"""Limit of the factor on the coefficient by a power of the pressure, which has none at pressure 0 otherwise."""


@dataclass(frozen=True)
class FrictionBound:
    """The friction limit b = mu p, or b = min(mu p, shear_limit) with mu growing like p^(exponent - 1).

    coefficient: mu, or mu at the `reference_pressure` (MPa), a number or (nx, ny); shear_limit: in MPa.
    """

    coefficient: float | FloatArray
    shear_limit: float = math.inf
    exponent: float = 1.0
    reference_pressure: float = 1.0

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
        """Return mu under `pressure` (MPa), without the shear limit; one number where it is the same for all."""
        return self.coefficient if self.exponent == 1.0 else self.coefficient * self._growth(pressure)[0]

    def part(self, cells: Any) -> FrictionBound:
        """Return the bound of some cells; cells: an index of fields (nx, ny)."""
        if isinstance(self.coefficient, float):
            return self
        return replace(self, coefficient=self.coefficient[cells])

    def _growth(self, pressure: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the factor on the coefficient by the pressure, and where it is limited."""
        ratio = np.maximum(pressure, TINY) / self.reference_pressure
        growth = ratio ** (self.exponent - 1.0)
        return np.minimum(growth, MOST_GROWTH), growth > MOST_GROWTH
