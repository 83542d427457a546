"""The elastic operator: displacements u2 - u1 of the two half-spaces' surfaces under pressure and shear.

Sign convention: pressure >= 0 compressive, shear as it acts on body 2, displacement in the direction of the
shear on body 2; uz opens the gap. The block operator on (p, qx, qy) is symmetric and positive definite.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.elastic import influence
from fretsolve.elastic.convolution import KernelMatrix, PaddedConvolution, RowSpace
from fretsolve.elastic.incremental_update import Follower
from fretsolve.elastic.influence_spectra import Influence, InfluenceSpectra, ScaledSpectra, Spectra
from fretsolve.elastic.interface import Apply, Operators
from fretsolve.elastic.preconditioner import SymbolInverse
from fretsolve.elastic.thread_team import ALONE, Team
from fretsolve.model.materials import Compliances
from fretsolve.model.terms import Terms
from fretsolve.system.arrays import FloatArray

INNER_PRECISION = np.float32
"""Of the inner iterations; residuals are computed in double precision."""

UNIT_OF_COMPLIANCE = 2.0
"""Unit of the inner iterations in self-coefficients of a cell; from one to three the iterations hardly differ."""


class ElasticOperator:
    """Applies the influence coefficients on a grid of ``shape`` cells of ``spacing`` (mm).

    Displacements in mm from tractions in MPa, written into the array given as the last argument. `applications`
    counts the calls of its methods; `transforms` the forward-and-inverse pairs of transforms of one field.
    space: room for row spectra, which operators that take turns may share; spectra: of the influence coefficients, in
    the precision `dtype`, where they are not to be computed.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        terms: Terms,
        team: Team = ALONE,
        space: RowSpace | None = None,
        dtype: type[np.floating] = np.float64,
        spectra: Spectra | None = None,
    ):
        self.shape, self.spacing, self.compliances, self.terms = shape, spacing, compliances, terms
        self.team, self.dtype = team, dtype
        self.applications = 0
        self._space = space or RowSpace()
        self._given_spectra = spectra

    @cached_property
    def inner(self) -> InnerOperators:
        """This operator and an approximate inverse for inner iterations, in units of their own."""
        unit = UNIT_OF_COMPLIANCE * self.self_coefficient
        elastic = ElasticOperator(
            self.shape,
            self.spacing,
            self.compliances,
            self.terms,
            self.team,
            self._space,
            INNER_PRECISION,
            ScaledSpectra(self._spectra, 1.0 / unit, INNER_PRECISION),
        )
        inverse = SymbolInverse(
            self.shape,
            self.spacing,
            self.compliances,
            self.terms.in_plane_coupling,
            unit,
            INNER_PRECISION,
            self.team,
            self._space,
        )
        return InnerOperators(unit, INNER_PRECISION, elastic, inverse)

    @cached_property
    def _convolution(self) -> PaddedConvolution:
        return PaddedConvolution(self.shape, self.dtype, self.team)

    @cached_property
    def _spectra(self) -> Spectra:
        return self._given_spectra or InfluenceSpectra(self._convolution, self.spacing, self.compliances)

    @property
    def total_applications(self) -> int:
        """Applications so far, with those of the inner iterations."""
        return self.applications + (self.inner.elastic.applications if "inner" in self.__dict__ else 0)

    @property
    def transforms(self) -> float:
        """Pairs of transforms made so far, without those of the inner iterations."""
        return self._convolution.transforms

    @cached_property
    def self_coefficient(self) -> float:
        """Tangential displacement (mm) of a cell's centre under a unit shear (MPa) on the cell, along x."""
        origin, (dx, dy) = np.zeros(1), self.spacing
        inverse_distance = influence.inverse_distance(origin, origin, dx, dy)[0, 0]
        along = influence.along_x(origin, origin, dx, dy)[0, 0]
        return float(self.compliances.A * inverse_distance + self.compliances.B * along) / (2 * math.pi)

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """``uz`` (nx, ny) from pressure (nx, ny)."""
        self._convolve(((self._spectra["zz"],),), (pressure,), (uz,))

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Tangential displacement (2, nx, ny) from shear (2, nx, ny)."""
        spectra = self._spectra
        if self.terms.in_plane_coupling:
            kernels = ((spectra["xx"], spectra["xy"]), (spectra["xy"], spectra["yy"]))
            self._convolve(kernels, (shear[0], shear[1]), (displacement[0], displacement[1]))
        else:
            self._along_its_own("xx", shear[0], displacement[0])
            self._along_its_own("yy", shear[1], displacement[1])
            self.applications += 1

    def _along_its_own(self, name: Influence, shear: FloatArray, displacement: FloatArray) -> None:
        """Displacement in the direction of the shear; nothing to do where there is none, as where no load is."""
        if shear.any():
            self._convolve(((self._spectra[name],),), (shear,), (displacement,))
            self.applications -= 1
        else:
            displacement[:] = 0.0

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Tangential displacement (2, nx, ny) from pressure (nx, ny); `terms` must couple."""
        kernels = ((self._spectra["xz"],), (self._spectra["yz"],))
        self._convolve(kernels, (pressure,), (displacement[0], displacement[1]), turned_field=0)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """``uz`` (nx, ny) from shear (2, nx, ny); `terms` must couple."""
        kernels = ((self._spectra["xz"], self._spectra["yz"]),)
        self._convolve(kernels, (shear[0], shear[1]), (uz,), turned_displacement=0)

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Normal and tangential displacement from pressure and shear, with every term that is kept."""
        if not self.terms.normal_tangential_coupling:
            self.normal(pressure, uz)
            self.tangential(shear, displacement)
            self.applications -= 1
            return
        spectra = self._spectra
        kernels = (
            (spectra["zz"], spectra["xz"], spectra["yz"]),
            (spectra["xz"], spectra["xx"], spectra["xy"]),
            (spectra["yz"], spectra["xy"], spectra["yy"]),
        )
        fields = (pressure, shear[0], shear[1])
        self._convolve(kernels, fields, (uz, displacement[0], displacement[1]), 0, 0)

    @property
    def following_normal(self) -> Follower:
        """Adds to uz (1, nx, ny) what a change of the pressure does."""
        return self._follower(_on_planes(self.inner.elastic.normal), _on_planes(self.normal), 1, 1)

    @property
    def following_tangential(self) -> Follower:
        """Adds to the tangential displacement (2, nx, ny) what a change of the shear does."""
        return self._follower(self.inner.elastic.tangential, self.tangential, 2, 2)

    @property
    def following_tangential_from_pressure(self) -> Follower:
        """Adds to the tangential displacement (2, nx, ny) what a change of the pressure does; `terms` must couple."""
        single, double = self.inner.elastic.tangential_from_pressure, self.tangential_from_pressure
        return self._follower(lambda p, moved: single(p[0], moved), lambda p, moved: double(p[0], moved), 1, 2)

    @property
    def following_normal_from_shear(self) -> Follower:
        """Adds to uz (1, nx, ny) what a change of the shear does; `terms` must couple."""
        single, double = self.inner.elastic.normal_from_shear, self.normal_from_shear
        return self._follower(lambda shear, uz: single(shear, uz[0]), lambda shear, uz: double(shear, uz[0]), 2, 1)

    def _follower(self, single: Apply, double: Apply, given: int, found: int) -> Follower:
        return Follower(single, double if self.dtype is np.float64 else None, self.inner.unit, given, found)

    def _convolve(
        self,
        kernels: KernelMatrix,
        fields: Sequence[FloatArray],
        displacements: Sequence[FloatArray],
        turned_field: int | None = None,
        turned_displacement: int | None = None,
    ) -> None:
        self._convolution.apply(kernels, fields, displacements, self._space, turned_field, turned_displacement)
        self.applications += 1


@dataclass(frozen=True)
class InnerOperators:
    """What the inner iterations apply, to fields of `dtype` (c, nx, ny).

    unit: mm per MPa, the unit of compliance; elastic: displacements over it; inverse: tractions times it.
    """

    unit: float
    dtype: type[np.floating]
    elastic: ElasticOperator
    inverse: SymbolInverse

    @property
    def normal(self) -> Operators:
        """For pressures (1, nx, ny)."""
        return Operators(_on_planes(self.elastic.normal), self.inverse.normal)

    @property
    def tangential(self) -> Operators:
        """For shears (2, nx, ny)."""
        return Operators(self.elastic.tangential, self.inverse.tangential)


def _on_planes(apply: Apply) -> Apply:
    """`apply` of planes (nx, ny) on fields (1, nx, ny)."""
    return lambda field, image: apply(field[0], image[0])
