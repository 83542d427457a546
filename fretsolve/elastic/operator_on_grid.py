"""Choose the elastic operator of a grid, scale it for orthotropic friction, and compute it for line contacts.

A line contact is a row of strips that are infinitely long along y (plane strain). Signs and methods are as in
`ElasticOperator`, on fields (nx, 1). p and qx act as in the plane problem; qy is antiplane shear, which moves the
surfaces along y alone. Displacements have a free constant per direction, which the grid's `log_length` sets.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.influence import Influence, KernelSpectrum
from fretsolve.elastic.mirrored_operator import MirroredOperator, plane
from fretsolve.elastic.operator import ElasticOperator, Preconditioner
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.grid import Grid, HalfGrid, LineGrid
from fretsolve.problem.model.materials import Compliances, Orthotropy
from fretsolve.problem.model.required_terms import Terms
from fretsolve.system.arrays import DoubleArray, FloatArray


def strip_influence(name: Influence, grid: LineGrid, compliances: Compliances) -> DoubleArray:
    """Return an influence (mm/MPa) of a strip at the offsets 0..nx-1 in cells, ``(nx, 1)`` (L1 of docs/theory.md).

    `xy` and `yz` are 0, since antiplane shear moves the surfaces along y alone.
    """
    if name in ("xy", "yz"):
        return np.zeros((grid.nx, 1))
    if name == "xz":
        jump = np.full((grid.nx, 1), 0.25 * compliances.C * grid.dx)
        jump[0] = 0.0
        return jump
    factors = {"zz": compliances.A, "xx": compliances.A, "yy": compliances.A + compliances.B}
    values = (-factors[name] / math.pi) * log_integral(grid.nx, grid.dx, grid.log_length)[:, None]
    values[0] += compliances.of_layer(name)
    return values


def log_integral(count: int, side: float, length: float) -> DoubleArray:
    """Return the integrals of ln(|x|/length) over cells of `side` (mm) at the offsets 0..count-1 cells, (count,)."""
    offset = np.arange(1, count, dtype=np.float64)
    half = 0.5 / offset
    # (t + h/2) ln(t + h/2) - (t - h/2) ln(t - h/2) without the cancellation far away
    spread = (offset + 0.5) * np.log1p(half) - (offset - 0.5) * np.log1p(-half)
    farther = np.log(offset * (side / length)) + spread - 1.0
    return side * np.concatenate([[math.log(0.5 * side / length) - 1.0], farther])


class StripSpectra(dict[Influence, KernelSpectrum]):
    """Spectra of the strip's influence coefficients (mm/MPa), each computed when it is first asked for."""

    def __init__(self, convolution: PaddedConvolution, grid: LineGrid, compliances: Compliances):
        super().__init__()
        self._convolution, self._grid, self._compliances = convolution, grid, compliances

    def __missing__(self, name: Influence) -> KernelSpectrum:
        values = strip_influence(name, self._grid, self._compliances)
        self[name] = self._convolution.kernel_spectrum(values, odd_x=name == "xz", odd_y=False)
        return self[name]


class LinePreconditioner(Preconditioner):
    """Computes tractions (MPa) from displacements (mm) of a line contact, times `factor`, in the precision `dtype`.

    A traction of wave number k meets the compliance A/k, or (A + B)/k if it is antiplane, as in the half-space, and
    besides the compliance of a layer.
    """

    def __init__(
        self,
        grid: LineGrid,
        compliances: Compliances,
        terms: Terms,
        factor: float,
        team: ThreadTeam | None = None,
        dtype: type[np.floating] = np.float64,
    ):
        self._convolution = PaddedConvolution(grid.shape, dtype, team, periodic=True)
        (points, _), side = self._convolution.padded, grid.dx
        self._in_plane = False
        wave_number = 2.0 * math.pi * np.fft.rfftfreq(points, side)[None, :]
        symbol = np.zeros_like(wave_number)
        for shifted in (wave_number, wave_number - 2.0 * math.pi / side):  # the nearest aliases
            length = np.maximum(np.abs(shifted), math.pi / (grid.nx * side))
            symbol += np.sinc(shifted * side / (2.0 * math.pi)) / length
        inverse = factor / (points * symbol)  # FFTW leaves the factor 1/points out of inverse transforms
        factors: dict[Influence, float] = {"zz": compliances.A}
        if terms.tangential:
            factors |= {"xx": compliances.A, "yy": compliances.A + compliances.B}
        self._spectra = {
            name: KernelSpectrum(
                (inverse / (half_space + compliances.of_layer(name) / symbol)).astype(dtype), odd_x=False
            )
            for name, half_space in factors.items()
        }


class LineOperator(ElasticOperator):
    """Applies the influence coefficients of strips. Arguments as for `ElasticOperator`."""

    _preconditioner = LinePreconditioner

    def __init__(
        self,
        grid: LineGrid,
        compliances: Compliances,
        terms: Terms,
        team: ThreadTeam | None = None,
        dtype: type[np.floating] = np.float64,
        spectra: dict[Influence, KernelSpectrum] | None = None,
    ):
        super().__init__(grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype, spectra)
        self._arguments = grid, compliances, terms
        self._grid = grid
        if spectra is None:
            self._spectra = StripSpectra(self._convolution, grid, compliances)

    @cached_property
    def self_coefficient(self) -> float:
        """Displacement ux (mm) of about a cell's centre relative to its surroundings under qx of 1 MPa on the cell."""
        return 2.0 * self.compliances.A * self._grid.dx / math.pi + self.compliances.layer_shear

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement from pressure, which has none along y; `terms` must couple."""
        self.applications += 1
        self._convolution.apply(((self._spectra["xz"],),), (plane(pressure),), displacement[:1], turned=(True, False))
        displacement[1] = 0.0

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from shear along x; `terms` must couple."""
        self.applications += 1
        self._convolution.apply(((self._spectra["xz"],),), shear[:1], (plane(uz),), turned=(False, True))

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Compute normal and tangential displacement from pressure and shear, with every term that is kept."""
        if not self.terms.normal_tangential_coupling:
            super().all(pressure, shear, uz, displacement)
            return
        self.applications += 1
        spectra = self._spectra
        kernels = (spectra["zz"], spectra["xz"]), (spectra["xz"], spectra["xx"])
        self._convolution.apply(kernels, (pressure, shear[0]), (uz, displacement[0]), turned=(True, True))
        if shear[1].any():
            self._convolution.apply(((spectra["yy"],),), (shear[1],), (displacement[1],))
        else:
            displacement[1] = 0.0


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
        return LineOperator(grid, compliances, terms, team, dtype)
    if orthotropy is not None:
        return OrthotropicOperator(orthotropy, grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype)
    if isinstance(grid, HalfGrid):
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
