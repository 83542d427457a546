"""The elastic operator: displacements u2 - u1 of the surfaces of two half-spaces under pressure and shear.

Signs: pressure >= 0 is compressive; shear is that on body 2, and tangential displacements have its direction; uz opens
the gap. The block operator on (p, qx, qy) is symmetric and positive definite.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from fretsolve.elastic.convolution import KernelMatrix, KernelSpectrum, PaddedConvolution, RowSpectra
from fretsolve.elastic.influence import Influence, InfluenceSpectra, ScaledSpectra, along_x, inverse_distance
from fretsolve.elastic.preconditioner import Preconditioner
from fretsolve.elastic.thread_team import ONE_THREAD, ThreadTeam
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms
from fretsolve.system.arrays import FloatArray

INNER_PRECISION = np.float32
"""Precision of the inner iterations. Residuals are computed in double precision."""

UNIT_OF_COMPLIANCE = 2.0
"""Unit of the inner iterations, in self-coefficients of a cell. From one to three the iterations hardly differ."""


class ElasticOperator:
    """Applies the influence coefficients on a grid of ``shape`` cells of ``spacing`` (mm).

    Its methods compute displacements (mm) from tractions (MPa) and write them into their last argument. Pressure and uz
    are (nx, ny) or (1, nx, ny), shear and tangential displacement (2, nx, ny). `applications` counts the calls.
    row_spectra: working memory, which operators that take turns may share; spectra: of the influence coefficients, in
    the precision `dtype`, if they are known already.
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
    def unit(self) -> float:
        """Unit of compliance of the inner iterations (mm per MPa)."""
        return UNIT_OF_COMPLIANCE * self.self_coefficient

    @cached_property
    def inner(self) -> ElasticOperator:
        """The same operator for the inner iterations: displacements over `unit`, in single precision."""
        spectra = ScaledSpectra(self._spectra, 1.0 / self.unit, INNER_PRECISION)
        return ElasticOperator(
            self.shape,
            self.spacing,
            self.compliances,
            self.terms,
            self.threads,
            self._row_spectra,
            INNER_PRECISION,
            spectra,
        )

    @cached_property
    def preconditioner(self) -> Preconditioner:
        """Approximate inverse of `inner`, in single precision."""
        return Preconditioner(
            self.shape,
            self.spacing,
            self.compliances,
            self.terms.in_plane_coupling,
            self.unit,
            self.threads,
            self._row_spectra,
            INNER_PRECISION,
        )

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
        return self.applications + (self.inner.applications if "inner" in self.__dict__ else 0)

    @cached_property
    def self_coefficient(self) -> float:
        """Displacement ux (mm) of a cell's centre under a unit shear qx (1 MPa) on the cell."""
        origin, (dx, dy) = np.zeros(1), self.spacing
        direct, along = (integral(origin, origin, dx, dy)[0, 0] for integral in (inverse_distance, along_x))
        return float(self.compliances.A * direct + self.compliances.B * along) / (2 * math.pi)

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from pressure."""
        self.applications += 1
        self._convolve(((self._spectra["zz"],),), self._planes(pressure), self._planes(uz))

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from shear."""
        self.applications += 1
        spectra = self._spectra
        if self.terms.in_plane_coupling:
            kernels = ((spectra["xx"], spectra["xy"]), (spectra["xy"], spectra["yy"]))
            self._convolve(kernels, (*shear,), (*displacement,))
            return
        directions: tuple[Influence, Influence] = ("xx", "yy")
        for direction, along, moved in zip(directions, shear, displacement, strict=True):
            if along.any():  # else neither a transform nor influence coefficients are needed
                self._convolve(((spectra[direction],),), (along,), (moved,))
            else:
                moved[:] = 0.0

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from pressure; `terms` must couple."""
        self.applications += 1
        kernels = ((self._spectra["xz"],), (self._spectra["yz"],))
        self._convolve(kernels, self._planes(pressure), (*displacement,), turn_field=True)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from shear; `terms` must couple."""
        self.applications += 1
        kernels = ((self._spectra["xz"], self._spectra["yz"]),)
        self._convolve(kernels, (*shear,), self._planes(uz), turn_displacement=True)

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
        self._convolve(kernels, (pressure, *shear), (uz, *displacement), True, True)

    def _planes(self, field: FloatArray) -> tuple[FloatArray, ...]:
        """Return the components (nx, ny) of a field (nx, ny) or (c, nx, ny)."""
        return (*field.reshape(-1, *self.shape),)

    def _convolve(
        self,
        kernels: KernelMatrix,
        fields: tuple[FloatArray, ...],
        displacements: tuple[FloatArray, ...],
        turn_field: bool = False,
        turn_displacement: bool = False,
    ) -> None:
        self._convolution.apply(kernels, fields, displacements, self._row_spectra, turn_field, turn_displacement)
