"""The elastic operator: displacements u2 - u1 of the surfaces of two half-spaces under pressure and shear.

Signs: pressure >= 0 is compressive; shear is that on body 2, and tangential displacements have its direction; uz opens
the gap. The block operator on (p, qx, qy) is symmetric and positive definite.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.influence import (
    InfluenceSpectra,
    ScaledSpectra,
    along_x,
    influence_coefficients,
    inverse_distance,
)
from fretsolve.elastic.kernel_spectrum import Influence, KernelSpectrum
from fretsolve.elastic.preconditioner import Preconditioner
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.kernels import GridKernels
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms
from fretsolve.system.arrays import DoubleArray, FloatArray

INNER_PRECISION = np.float32
"""Precision of the inner iterations. Residuals are computed in double precision."""

UNIT_OF_COMPLIANCE = 2.0
"""Unit of the inner iterations, in self-coefficients of a cell. From one to three the iterations hardly differ."""


class ElasticOperator:
    """Applies the influence coefficients on a grid of ``shape`` cells of ``spacing`` (mm).

    Its methods compute displacements (mm) from tractions (MPa) and write them into their last argument. Pressure and uz
    are (nx, ny) or (1, nx, ny), shear and tangential displacement (2, nx, ny). `applications` counts the calls.
    team: threads, kernels and working memory, which operators that take turns may share; spectra: of the influence
    coefficients, in the precision `dtype`, if they are known already; whole: operator on a small grid of the same
    spacing that has this one as a part, whose coefficients are used.
    """

    is_plain: ClassVar[bool] = True
    """Whether it applies its influence coefficients as they are."""

    _preconditioner: ClassVar[Callable[..., Preconditioner]] = Preconditioner

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        terms: Terms,
        team: ThreadTeam | None = None,
        dtype: type[np.floating] = np.float64,
        spectra: dict[Influence, KernelSpectrum] | None = None,
        whole: ElasticOperator | None = None,
    ):
        self.terms, self.dtype, self.applications = terms, dtype, 0
        self._problem = shape, spacing, compliances, terms
        self._arguments: tuple[Any, ...] = self._problem  # that this class and its preconditioner take first
        self._team = team or ThreadTeam()
        self._convolution = self._convolution_on(shape, dtype)
        of_whole: InfluenceSpectra | None = None if whole is None else whole.influence
        self.influence: InfluenceSpectra = InfluenceSpectra(self._convolution, spacing, compliances, of_whole)
        self._spectra = self.influence if spectra is None else spectra

    def _convolution_on(self, shape: tuple[int, int], dtype: type[np.floating]) -> Any:
        """Return the convolution of this operator's fields."""
        return PaddedConvolution(shape, dtype, self._team)

    @property
    def compliances(self) -> Compliances:
        """The compliances of the bodies."""
        return self._problem[2]

    @cached_property
    def kernels(self) -> GridKernels:
        """The kernels that solvers with this operator use."""
        return self._team.kernels.on(self._problem[0], self._team.share)

    @cached_property
    def unit(self) -> float:
        """Unit of compliance of the inner iterations (mm per MPa)."""
        return UNIT_OF_COMPLIANCE * self.self_coefficient

    @cached_property
    def inner(self) -> Self:
        """The same operator for the inner iterations: displacements over `unit`, in single precision."""
        spectra = ScaledSpectra(self._spectra, 1.0 / self.unit, INNER_PRECISION)
        of_this_kind: Callable[..., Self] = type(self)
        return of_this_kind(*self._arguments, self._team, INNER_PRECISION, spectra)

    @cached_property
    def preconditioner(self) -> Preconditioner:
        """Approximate inverse of `inner`, in single precision."""
        return self._preconditioner(*self._arguments, self.unit, self._team, INNER_PRECISION)

    @property
    def total_applications(self) -> int:
        """Applications so far, including those of the inner iterations."""
        return self.applications + (self.inner.applications if "inner" in self.__dict__ else 0)

    @cached_property
    def self_coefficient(self) -> float:
        """Displacement ux (mm) of a cell's centre under a unit shear qx (1 MPa) on the cell."""
        _, (dx, dy), compliances, _ = self._problem
        direct, along = (integral(np.zeros(1), np.zeros(1), dx, dy)[0, 0] for integral in (inverse_distance, along_x))
        return float(compliances.A * direct + compliances.B * along) / (2 * math.pi)

    def coefficients(self, name: Influence, shape: tuple[int, int]) -> DoubleArray:
        """Return an influence (mm/MPa) at the offsets between cells of a grid of such a `shape`, from 0 on."""
        _, spacing, compliances, _ = self._problem
        return influence_coefficients(name, shape, spacing, compliances)

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from pressure."""
        self.applications += 1
        self._convolution.apply(((self._spectra["zz"],),), self._planes(pressure), self._planes(uz))

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from shear."""
        self.applications += 1
        self._convolution.apply_in_plane(self._spectra, self.terms.in_plane_coupling, shear, displacement)

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from pressure; `terms` must couple."""
        self.applications += 1
        kernels = ((self._spectra["xz"],), (self._spectra["yz"],))
        self._convolution.apply(kernels, self._planes(pressure), displacement, turned=(True, False))

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from shear; `terms` must couple."""
        self.applications += 1
        kernels = ((self._spectra["xz"], self._spectra["yz"]),)
        self._convolution.apply(kernels, shear, self._planes(uz), turned=(False, True))

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Compute normal and tangential displacement from pressure and shear, with every term that is kept."""
        if not self.terms.normal_tangential_coupling:
            self.normal(pressure, uz)
            self.tangential(shear, displacement)
            self.applications -= 1  # both together count once
            return
        self.applications += 1
        self._all_coupled(pressure, shear, uz, displacement)

    def _all_coupled(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Do the same with all terms."""
        spectra = self._spectra
        kernels = (
            (spectra["zz"], spectra["xz"], spectra["yz"]),
            (spectra["xz"], spectra["xx"], spectra["xy"]),
            (spectra["yz"], spectra["xy"], spectra["yy"]),
        )
        self._convolution.apply(kernels, (pressure, *shear), (uz, *displacement), turned=(True, True))

    def _planes(self, field: FloatArray) -> FloatArray:
        """Return a field (nx, ny) or (c, nx, ny) as (c, nx, ny)."""
        return field if field.ndim == 3 else field[None]
