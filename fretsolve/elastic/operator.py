"""The elastic operator: displacements u2 - u1 of the surfaces of two half-spaces under pressure and shear.

Signs: pressure >= 0 is compressive; shear acts on body 2, and tangential displacements have its direction; uz opens
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
    Influence,
    InfluenceSpectra,
    KernelSpectrum,
    ScaledSpectra,
    along_x,
    inverse_distance,
)
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms
from fretsolve.system.arrays import FloatArray

INNER_PRECISION = np.float32
"""Precision of the inner iterations. Residuals are computed in double precision."""


class Preconditioner:
    """Computes tractions (MPa) from displacements (mm), times `factor`, in the precision `dtype`.

    It inverts the symbol of the half-space on a periodic grid. In an unbounded half-space a traction of wave vector k
    meets the compliance A/k if it is normal, A/k if it is a shear along k and (A + B)/k if it is a shear across k (T8
    of docs/theory.md); the compliance of a layer adds to each. The inverse of this symbol acts over a few cells only:
    its kernel falls like 1/r^3. So the contact needs no zero-padding, since no contact reaches the edges of its grid,
    single precision is enough, and an application costs a small part of one of the elastic operator. The spectra of the
    elastic operator would not do: they ripple about the symbol, down to negative values if dx and dy differ.
    """

    _convolution_type: ClassVar[Callable[..., Any]] = PaddedConvolution

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        terms: Terms,
        factor: float,
        team: ThreadTeam | None = None,
        dtype: type[np.floating] = np.float64,
    ):
        self._convolution = self._convolution_type(shape, dtype, team or ThreadTeam(), periodic=True)
        self._in_plane = terms.in_plane_coupling
        size = mx, my = self._convolution.padded
        # FFTW leaves the factor 1/(mx my) out of inverse transforms.
        self._spectra: dict[Influence, KernelSpectrum] = {
            name: KernelSpectrum(values, odd_x=name == "xy").scaled(factor / (mx * my), dtype)
            for name, values in _inverse_symbol(self._convolution.shape, size, spacing, compliances, terms).items()
        }

    def normal(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (1, nx, ny) from displacement (1, nx, ny)."""
        self._convolution.normal(self._spectra, displacement, traction)

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (2, nx, ny) from displacement (2, nx, ny)."""
        self._convolution.tangential(self._spectra, self._in_plane, displacement, traction)


class ElasticOperator:
    """Applies the influence coefficients on a grid of ``shape`` cells of ``spacing`` (mm).

    Its methods compute displacements (mm) from tractions (MPa) and write them into their last argument. Pressure and uz
    are (nx, ny) or (1, nx, ny), shear and tangential displacement (2, nx, ny). `applications` counts the calls.
    team: threads, kernels and working memory, which operators that take turns may share; spectra: of the influence
    coefficients, in the precision `dtype`, if they are known already; whole: operator on a small grid of the same
    spacing that has this one as a part, whose coefficients are used.
    """

    _convolution_type: ClassVar[Callable[..., Any]] = PaddedConvolution
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
        self.shape, self.team = shape, team or ThreadTeam()
        self._convolution = self._convolution_type(shape, dtype, self.team)
        of_whole: InfluenceSpectra | None = None if whole is None else whole.influence
        self.influence: InfluenceSpectra = InfluenceSpectra(self._convolution, spacing, compliances, of_whole)
        self._spectra = self.influence if spectra is None else spectra

    @property
    def compliances(self) -> Compliances:
        """The compliances of the bodies."""
        return self._problem[2]

    @cached_property
    def unit(self) -> float:
        """Unit of compliance of the inner iterations (mm per MPa)."""
        # from one to three times the iterations hardly differ
        return 2.0 * self.self_coefficient

    @cached_property
    def inner(self) -> Self:
        """The same operator for the inner iterations: displacements over `unit`, in single precision."""
        spectra = ScaledSpectra(self._spectra, 1.0 / self.unit, INNER_PRECISION)
        of_this_kind: Callable[..., Self] = type(self)
        return of_this_kind(*self._arguments, self.team, INNER_PRECISION, spectra)

    @cached_property
    def preconditioner(self) -> Preconditioner:
        """Approximate inverse of `inner`, in single precision."""
        return self._preconditioner(*self._arguments, self.unit, self.team, INNER_PRECISION)

    @property
    def total_applications(self) -> int:
        """Applications so far, including applications of the inner iterations."""
        return self.applications + (self.inner.applications if "inner" in self.__dict__ else 0)

    @cached_property
    def self_coefficient(self) -> float:
        """Displacement ux (mm) of a cell's centre under a unit shear qx (1 MPa) on the cell."""
        _, (dx, dy), compliances, _ = self._problem
        direct, along = (integral(np.zeros(1), np.zeros(1), dx, dy)[0, 0] for integral in (inverse_distance, along_x))
        return float(compliances.A * direct + compliances.B * along) / (2 * math.pi) + compliances.layer_shear

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from pressure."""
        self.applications += 1
        self._convolution.normal(self._spectra, pressure, uz)

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from shear."""
        self.applications += 1
        self._convolution.tangential(self._spectra, self.terms.in_plane_coupling, shear, displacement)

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from pressure; `terms` must couple."""
        self.applications += 1
        self._convolution.tangential_from_pressure(self._spectra, pressure, displacement)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from shear; `terms` must couple."""
        self.applications += 1
        self._convolution.normal_from_shear(self._spectra, shear, uz)

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Compute normal and tangential displacement from pressure and shear, with every term that is kept."""
        if not self.terms.normal_tangential_coupling:
            self.normal(pressure, uz)
            self.tangential(shear, displacement)
            self.applications -= 1  # both together count once
            return
        self.applications += 1
        self._convolution.coupled(self._spectra, pressure, shear, uz, displacement)


def _inverse_symbol(
    shape: tuple[int, int], size: tuple[int, int], spacing: tuple[float, float], compliances: Compliances, terms: Terms
) -> dict[Influence, FloatArray]:
    """Return the inverse of the symbol, (my//2 + 1, mx//2 + 1), of each component that `terms` keep.

    zz: from uz to p; xx: from ux to qx; yy: from uy to qy; xy: from each of the two to the other.
    """
    kx, ky = (2.0 * math.pi * np.fft.rfftfreq(count, side) for count, side in zip(size, spacing, strict=True))
    kx, ky = kx[None, :], ky[:, None]
    shortest = math.pi / max(count * side for count, side in zip(shape, spacing, strict=True))
    symbol = _mean_symbol(kx, ky, spacing, shortest)
    normal = 1.0 / (compliances.A * symbol + compliances.layer_normal)
    if not terms.tangential:
        return {"zz": normal}
    # the inverse of the symmetric 2 x 2 symbol of shear
    inverse = 1.0 / (compliances.A * symbol + compliances.layer_shear)
    share = compliances.B / (compliances.A + compliances.layer_shear / symbol)
    length = np.hypot(kx, ky)
    length[0, 0] = 1.0
    along_x, along_y = kx / length, ky / length
    if not terms.in_plane_coupling:
        return {"zz": normal, "xx": inverse / (1.0 + share * along_y**2), "yy": inverse / (1.0 + share * along_x**2)}
    in_plane = inverse / (1.0 + share)
    ux_to_qx, uy_to_qy = in_plane * (1.0 + share * along_x**2), in_plane * (1.0 + share * along_y**2)
    in_plane *= share * along_x * along_y
    # The highest wave number of an even period stands for both signs; the odd function is 0 there.
    if size[0] % 2 == 0:
        in_plane[:, -1] = 0.0
    if size[1] % 2 == 0:
        in_plane[-1] = 0.0
    return {"zz": normal, "xx": ux_to_qx, "yy": uy_to_qy, "xy": in_plane}


def _mean_symbol(kx: FloatArray, ky: FloatArray, spacing: tuple[float, float], shortest: float) -> FloatArray:
    """Return 1/k times the spectrum of a cell, summed over the nearest aliases, at wave numbers (1, n) and (m, 1).

    A wave longer than the grid counts as one of its length, the wave number `shortest`, because 1/k is infinite at 0.
    """
    dx, dy = spacing
    total = np.zeros((ky.size, kx.size))
    for shifted_x in (kx, kx - 2 * math.pi / dx):
        for shifted_y in (ky, ky - 2 * math.pi / dy):
            length = np.hypot(shifted_x, shifted_y)
            np.maximum(length, shortest, out=length)
            total += np.sinc(shifted_x * dx / (2 * math.pi)) * np.sinc(shifted_y * dy / (2 * math.pi)) / length
    return total
