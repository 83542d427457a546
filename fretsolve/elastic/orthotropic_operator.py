"""The elastic operator on shear tractions and tangential displacements that are scaled for orthotropic friction."""

from __future__ import annotations

from typing import Any

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.preconditioner import Preconditioner
from fretsolve.model.materials import Orthotropy
from fretsolve.system.arrays import FloatArray


class OrthotropicPreconditioner(Preconditioner):
    """Computes scaled shear tractions from scaled displacements, M^-1 K^-1 M^-1 roughly."""

    def __init__(self, orthotropy: Orthotropy, *arguments: Any):
        super().__init__(*arguments)
        self._inverse = orthotropy.inverse

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute scaled shear (2, nx, ny) from scaled displacement (2, nx, ny)."""
        super().tangential(self._inverse.times(displacement), traction)
        traction[:] = self._inverse.times(traction)


class OrthotropicOperator(ElasticOperator):
    """Applies M K M to scaled shear tractions; arguments as for `ElasticOperator` after `orthotropy`, M."""

    is_plain = False
    _preconditioner = OrthotropicPreconditioner

    def __init__(self, orthotropy: Orthotropy, *arguments: Any):
        super().__init__(*arguments)
        self._orthotropy = orthotropy
        self._arguments = orthotropy, *self._problem

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the scaled tangential displacement from scaled shear."""
        super().tangential(self._orthotropy.times(shear), displacement)
        displacement[:] = self._orthotropy.times(displacement)

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the scaled tangential displacement from pressure; `terms` must couple."""
        super().tangential_from_pressure(pressure, displacement)
        displacement[:] = self._orthotropy.times(displacement)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from scaled shear; `terms` must couple."""
        super().normal_from_shear(self._orthotropy.times(shear), uz)

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Compute normal and scaled tangential displacement from pressure and scaled shear."""
        if not self.terms.normal_tangential_coupling:
            super().all(pressure, shear, uz, displacement)  # by the methods above
            return
        super().all(pressure, self._orthotropy.times(shear), uz, displacement)
        displacement[:] = self._orthotropy.times(displacement)
