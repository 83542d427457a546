"""The elastic operator with a layer on it that yields by its own pressure in each cell.

Wear over many cycles is such a layer: under the pressure p at their end it has sunk by D p (`fretsolve.wear.profile`).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from fretsolve.elastic.operator import INNER_PRECISION, ElasticOperator, Preconditioner
from fretsolve.system.arrays import FloatArray


class CompliantOperator(ElasticOperator):
    """Computes uz = (A + D) p with the elastic operator A and a compliance D >= 0 of each cell (mm/MPa), (nx, ny).

    It serves normal problems alone.
    """

    def __init__(self, elastic: ElasticOperator, compliance: FloatArray):
        self._elastic, self._compliance = elastic, compliance
        self.terms, self.dtype, self.shape, self.team = elastic.terms, elastic.dtype, elastic.shape, elastic.team

    @property
    def preconditioner(self) -> Preconditioner:
        return self._elastic.preconditioner

    @cached_property
    def unit(self) -> float:
        return self._elastic.unit

    @cached_property
    def inner(self) -> CompliantOperator:
        return CompliantOperator(self._elastic.inner, (self._compliance / self.unit).astype(INNER_PRECISION))

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from pressure."""
        yielded = np.multiply(self._compliance, pressure, dtype=self.dtype)
        self._elastic.normal(pressure, uz)
        uz += yielded
