"""The elastic operator on one half of fields that are mirror images of themselves about y = 0.

p, qx, ux and uz are even in y, qy and uy are odd. Of each field the half y > 0 is given and computed; the other half
acts, too.
"""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.mirrored.convolution import MirroredConvolution
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.preconditioner import Preconditioner
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import FloatArray


class MirroredPreconditioner(Preconditioner):
    """Computes tractions from displacements, roughly, on the half y > 0 of a grid; ``shape``: of this half."""

    _convolution: MirroredConvolution

    def _convolution_on(
        self, shape: tuple[int, int], dtype: type[np.floating], team: ThreadTeam
    ) -> MirroredConvolution:
        return MirroredConvolution(shape, dtype, team, periodic=True)

    def normal(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (1, nx, ny) from displacement (1, nx, ny)."""
        self._convolution.scalar(self._spectra["zz"], False, displacement[0], traction[0])

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (2, nx, ny) from displacement (2, nx, ny)."""
        self._convolution.in_plane(self._spectra, self._in_plane, displacement, traction)


class MirroredOperator(ElasticOperator):
    """Applies the influence coefficients on the half y > 0 of a grid; ``shape``: of this half."""

    _convolution: MirroredConvolution
    _preconditioner = MirroredPreconditioner

    def _convolution_on(self, shape: tuple[int, int], dtype: type[np.floating]) -> MirroredConvolution:
        return MirroredConvolution(shape, dtype, self._team)

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from pressure."""
        self.applications += 1
        self._convolution.scalar(self._spectra["zz"], False, _plane(pressure), _plane(uz))

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from shear."""
        self.applications += 1
        self._convolution.in_plane(self._spectra, self.terms.in_plane_coupling, shear, displacement)

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from pressure; `terms` must couple."""
        self.applications += 1
        self._convolution.sideways(self._spectra, _plane(pressure), displacement)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from shear; `terms` must couple."""
        self.applications += 1
        self._convolution.upright(self._spectra, shear, _plane(uz))

    def _all_coupled(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        self._convolution.coupled(self._spectra, pressure, shear, uz, displacement)


def _plane(field: FloatArray) -> FloatArray:
    """Return a field (nx, ny) or (1, nx, ny) as (nx, ny)."""
    return field if field.ndim == 2 else field[0]
