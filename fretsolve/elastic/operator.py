"""The elastic operator: displacements u2 - u1 of the surfaces of two half-spaces under pressure and shear.

Signs: pressure >= 0 is compressive; shear is that on body 2, and tangential displacements have its direction; uz opens
the gap. The block operator on (p, qx, qy) is symmetric and positive definite.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.elastic.convolution import KernelMatrix, KernelSpectrum, PaddedConvolution, RowSpectra
from fretsolve.elastic.incremental_update import IncrementalUpdate
from fretsolve.elastic.influence import Influence, InfluenceSpectra, ScaledSpectra, along_x, inverse_distance
from fretsolve.elastic.interface import Apply, Operators
from fretsolve.elastic.preconditioner import Preconditioner
from fretsolve.elastic.thread_team import ONE_THREAD, ThreadTeam
from fretsolve.model.materials import Compliances
from fretsolve.model.terms import Terms
from fretsolve.system.arrays import FloatArray

INNER_PRECISION = np.float32
"""Precision of the inner iterations. Residuals are computed in double precision."""

UNIT_OF_COMPLIANCE = 2.0
"""Unit of the inner iterations, in self-coefficients of a cell. From one to three the iterations hardly differ."""


class ElasticOperator:
    """Applies the influence coefficients on a grid of ``shape`` cells of ``spacing`` (mm).

    Its methods compute displacements (mm) from tractions (MPa) and write them into their last argument.
    `applications` counts the calls. row_spectra: working memory, which operators that take turns may share; spectra:
    of the influence coefficients, in the precision `dtype`, if they are known already.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        terms: Terms,
        threads: ThreadTeam = ONE_THREAD,
        row_spectra: RowSpectra | None = None,
        dtype: type[np.floating] = np.float64,
        spectra: dict[Influence, KernelSpectrum] | None = None,
    ):
        self.shape, self.spacing, self.compliances, self.terms = shape, spacing, compliances, terms
        self.threads, self.dtype = threads, dtype
        self.applications = 0
        self._row_spectra = row_spectra or RowSpectra()
        self._given_spectra = spectra

    @cached_property
    def inner(self) -> InnerOperators:
        """This operator and its preconditioner for the inner iterations, in units of their own."""
        unit = UNIT_OF_COMPLIANCE * self.self_coefficient
        place = self.shape, self.spacing, self.compliances
        shared = self.threads, self._row_spectra, INNER_PRECISION
        spectra = ScaledSpectra(self._spectra, 1.0 / unit, INNER_PRECISION)
        elastic = ElasticOperator(*place, self.terms, *shared, spectra)
        return InnerOperators(unit, elastic, Preconditioner(*place, self.terms.in_plane_coupling, unit, *shared))

    @cached_property
    def _convolution(self) -> PaddedConvolution:
        return PaddedConvolution(self.shape, self.dtype, self.threads)

    @cached_property
    def _spectra(self) -> dict[Influence, KernelSpectrum]:
        if self._given_spectra is not None:
            return self._given_spectra
        return InfluenceSpectra(self._convolution, self.spacing, self.compliances)

    @property
    def total_applications(self) -> int:
        """Applications so far, including those of the inner iterations."""
        return self.applications + (self.inner.elastic.applications if "inner" in self.__dict__ else 0)

    @cached_property
    def self_coefficient(self) -> float:
        """Displacement ux (mm) of a cell's centre under a unit shear qx (1 MPa) on the cell."""
        origin, (dx, dy) = np.zeros(1), self.spacing
        direct, along = (integral(origin, origin, dx, dy)[0, 0] for integral in (inverse_distance, along_x))
        return float(self.compliances.A * direct + self.compliances.B * along) / (2 * math.pi)

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` (nx, ny) from pressure (nx, ny)."""
        self.applications += 1
        self._convolve(((self._spectra["zz"],),), (pressure,), (uz,))

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement (2, nx, ny) from shear (2, nx, ny)."""
        self.applications += 1
        spectra = self._spectra
        if self.terms.in_plane_coupling:
            kernels = ((spectra["xx"], spectra["xy"]), (spectra["xy"], spectra["yy"]))
            self._convolve(kernels, (shear[0], shear[1]), (displacement[0], displacement[1]))
        else:
            self._one_direction("xx", shear[0], displacement[0])
            self._one_direction("yy", shear[1], displacement[1])

    def _one_direction(self, name: Influence, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the displacement along the shear, without a transform if the shear is 0."""
        if shear.any():
            self._convolve(((self._spectra[name],),), (shear,), (displacement,))
        else:
            displacement[:] = 0.0

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement (2, nx, ny) from pressure (nx, ny); `terms` must couple."""
        self.applications += 1
        kernels = ((self._spectra["xz"],), (self._spectra["yz"],))
        self._convolve(kernels, (pressure,), (displacement[0], displacement[1]), turn_field=True)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` (nx, ny) from shear (2, nx, ny); `terms` must couple."""
        self.applications += 1
        kernels = ((self._spectra["xz"], self._spectra["yz"]),)
        self._convolve(kernels, (shear[0], shear[1]), (uz,), turn_displacement=True)

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Compute normal and tangential displacement from pressure and shear, with every term that is kept."""
        if not self.terms.normal_tangential_coupling:
            self.normal(pressure, uz)
            self.tangential(shear, displacement)
            self.applications -= 1  # both together count once
            return
        self.applications += 1
        spectra = self._spectra
        kernels = (
            (spectra["zz"], spectra["xz"], spectra["yz"]),
            (spectra["xz"], spectra["xx"], spectra["xy"]),
            (spectra["yz"], spectra["xy"], spectra["yy"]),
        )
        fields = (pressure, shear[0], shear[1])
        self._convolve(kernels, fields, (uz, displacement[0], displacement[1]), True, True)

    @property
    def incremental_normal(self) -> IncrementalUpdate:
        """Update of uz (1, nx, ny) after a change of the pressure."""
        return self._update("normal", 1, 1)

    @property
    def incremental_tangential(self) -> IncrementalUpdate:
        """Update of the tangential displacement (2, nx, ny) after a change of the shear."""
        return self._update("tangential", 2, 2)

    @property
    def incremental_tangential_from_pressure(self) -> IncrementalUpdate:
        """Update of the tangential displacement (2, nx, ny) after a change of the pressure; `terms` must couple."""
        return self._update("tangential_from_pressure", 1, 2)

    @property
    def incremental_normal_from_shear(self) -> IncrementalUpdate:
        """Update of uz (1, nx, ny) after a change of the shear; `terms` must couple."""
        return self._update("normal_from_shear", 2, 1)

    def _update(self, method: str, tractions: int, displacements: int) -> IncrementalUpdate:
        single, double = getattr(self.inner.elastic, method), getattr(self, method)
        in_double = double if self.dtype is np.float64 else None
        return IncrementalUpdate(single, in_double, self.inner.unit, tractions, displacements)

    def _convolve(
        self,
        kernels: KernelMatrix,
        fields: Sequence[FloatArray],
        displacements: Sequence[FloatArray],
        turn_field: bool = False,
        turn_displacement: bool = False,
    ) -> None:
        self._convolution.apply(kernels, fields, displacements, self._row_spectra, turn_field, turn_displacement)


@dataclass(frozen=True)
class InnerOperators:
    """The operators of the inner iterations, on fields (c, nx, ny) in single precision.

    elastic: displacements over `unit` (mm per MPa), the unit of compliance; inverse: tractions times it.
    """

    unit: float
    elastic: ElasticOperator
    inverse: Preconditioner
    dtype: type[np.floating] = INNER_PRECISION

    @property
    def normal(self) -> Operators:
        """For pressures (1, nx, ny)."""
        return Operators(_on_planes(self.elastic.normal), self.inverse.normal)

    @property
    def tangential(self) -> Operators:
        """For shears (2, nx, ny)."""
        return Operators(self.elastic.tangential, self.inverse.tangential)


def _on_planes(apply: Apply) -> Apply:
    """Return `apply`, which takes planes (nx, ny), as a map of fields (1, nx, ny)."""
    return lambda field, image: apply(field[0], image[0])
