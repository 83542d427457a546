"""Choose the elastic operator of a grid, and scale it for orthotropic friction."""

from __future__ import annotations

from typing import Any

import numpy as np

from fretsolve.elastic.operator import ElasticOperator, Preconditioner
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.grid import Grid, HalfGrid, LineGrid
from fretsolve.problem.model.materials import Compliances, Orthotropy
from fretsolve.problem.model.required_terms import Terms
from fretsolve.system.arrays import FloatArray


def operator_on(
    grid: Grid,
    compliances: Compliances,
    terms: Terms,
    team: ThreadTeam | None = None,
    dtype: type[np.floating] = np.float64,
    orthotropy: Orthotropy | None = None,
    whole: ElasticOperator | None = None,
) -> ElasticOperator:
    """Return the elastic operator on a grid, of strips, of rectangles, or of rectangles and their mirror images.

    orthotropy: scales shear and slip; whole: as for `ElasticOperator`.
    """
    if isinstance(grid, LineGrid):
        from fretsolve.elastic.line_operator import LineOperator  # other cases need none of it

        return LineOperator(grid, compliances, terms, team, dtype)
    if orthotropy is not None:
        return OrthotropicOperator(orthotropy, grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype)
    if isinstance(grid, HalfGrid):
        from fretsolve.elastic.mirrored_operator import MirroredOperator

        return MirroredOperator(grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype, whole=whole)
    return ElasticOperator(grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype, whole=whole)


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
