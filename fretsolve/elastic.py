"""The elastic operator: displacements u2 - u1 of the two half-spaces' surfaces under pressure and shear.

Sign convention: pressure >= 0 compressive, shear as it acts on body 2, displacement in the direction of the
shear on body 2; uz opens the gap. The block operator on (p, qx, qy) is symmetric and positive definite.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fretsolve import influence
from fretsolve.convolution import KernelMatrix, KernelSpectrum, PaddedConvolution
from fretsolve.materials import Compliances
from fretsolve.terms import Terms

FloatArray = NDArray[np.floating]


class ElasticOperator:
    """Applies the influence coefficients on a grid of ``shape`` cells of ``spacing`` (mm).

    Displacements in mm from tractions in MPa, written into the array given as the last argument. `applications`
    counts the calls of its methods; `transforms` the forward-and-inverse pairs of transforms of one field.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        terms: Terms,
        dtype: type[np.floating] = np.float64,
        threads: int = 1,
    ):
        self.shape = shape
        self.spacing = spacing
        self.compliances = compliances
        self.terms = terms
        self.applications = 0
        self._convolution = PaddedConvolution(shape, dtype, threads)
        self._spectra: list[NDArray[np.complexfloating]] = []

    @property
    def transforms(self) -> float:
        """Pairs of transforms made so far."""
        return self._convolution.transforms

    @property
    def tangential_self_coefficient(self) -> float:
        """Tangential displacement (mm) of a cell's centre under a unit shear (MPa) on the cell, along x."""
        inverse_distance = self._quadrant(influence.inverse_distance, (1, 1))[0, 0]
        along = self._quadrant(influence.along_x, (1, 1))[0, 0]
        return float(self.compliances.A * inverse_distance + self.compliances.B * along) / (2 * math.pi)

    # Spectra of the influence coefficients, each computed when a solve first needs it.

    @cached_property
    def _normal(self) -> KernelSpectrum:
        return self._spectrum(self.compliances.A / (2 * math.pi) * self._quadrant(influence.inverse_distance))

    @cached_property
    def _normal_inverse(self) -> KernelSpectrum:
        return self._convolution.spectrum_from_symbol(1.0 / self._symbol(), odd_x=False)

    def _symbol(self) -> NDArray[np.float64]:
        """Spectrum of uz from p on an unbounded grid: A/k times that of a cell, with the nearest aliases.

        The padded kernel's own spectrum ripples about it, down to negative values where dx and dy differ.
        """
        kx, ky = self._convolution.wave_numbers(self.spacing)
        dx, dy = self.spacing
        total = np.zeros((kx.size, ky.size))
        for shifted_x in (kx, kx - 2 * math.pi / dx):
            for shifted_y in (ky, ky - 2 * math.pi / dy):
                length = np.hypot(shifted_x, shifted_y)
                # A wave longer than the grid counts as one of its length: k = 0 has no value of its own.
                np.maximum(length, math.pi / max(self.shape[0] * dx, self.shape[1] * dy), out=length)
                total += np.sinc(shifted_x * dx / (2 * math.pi)) * np.sinc(shifted_y * dy / (2 * math.pi)) / length
        return self.compliances.A * total

    @cached_property
    def _xx(self) -> KernelSpectrum:
        return self._spectrum(self._direct(influence.along_x))

    @cached_property
    def _yy(self) -> KernelSpectrum:
        return self._spectrum(self._direct(influence.along_y))

    @cached_property
    def _xy(self) -> KernelSpectrum:
        scale = self.compliances.B / (2 * math.pi)
        return self._spectrum(scale * self._quadrant(influence.across), odd_x=True, odd_y=True)

    @cached_property
    def _xz(self) -> KernelSpectrum:
        scale = self.compliances.C / (4 * math.pi)
        return self._spectrum(scale * self._quadrant(influence.radial_x), odd_x=True)

    @cached_property
    def _yz(self) -> KernelSpectrum:
        scale = self.compliances.C / (4 * math.pi)
        return self._spectrum(scale * self._quadrant(influence.radial_y), odd_y=True)

    def _direct(self, along: influence.KernelFunction) -> NDArray[np.float64]:
        """ux from qx or uy from qy."""
        quadrant = self.compliances.A * self._quadrant(influence.inverse_distance)
        quadrant += self.compliances.B * self._quadrant(along)
        quadrant /= 2 * math.pi
        return quadrant

    @cached_property
    def _inverse_tangential(self) -> tuple[KernelSpectrum, KernelSpectrum, KernelSpectrum]:
        """Spectra of the tangential operator's inverse: 1/r times a matrix in the direction of the wave vector k.

        In an unbounded half-space shear along k meets A, shear across k meets A + B (in units of the spectrum of
        1/(2 pi r)).
        """
        a, b = self.compliances.A, self.compliances.B
        kx, ky = self._convolution.wave_numbers(self.spacing)
        length = np.hypot(kx, ky)
        length[0, :2] = 1.0
        along_x, along_y = kx / length, ky / length
        inverse = 1.0 / self._symbol()
        make = self._convolution.spectrum_from_symbol
        if not self.terms.cross:
            inverse_xx, inverse_yy = inverse / (1.0 + b / a * along_y**2), inverse / (1.0 + b / a * along_x**2)
            return make(inverse_xx, False), make(inverse_yy, False), make(np.zeros((1, 1)), True)
        inverse *= a / (a + b)
        inverse_xx, inverse_yy = inverse * (1.0 + b / a * along_x**2), inverse * (1.0 + b / a * along_y**2)
        inverse *= b / a * along_x * along_y
        return make(inverse_xx, False), make(inverse_yy, False), make(inverse, True)

    def _quadrant(
        self, function: influence.KernelFunction, shape: tuple[int, int] | None = None
    ) -> NDArray[np.float64]:
        (nx, ny), (dx, dy) = shape or self.shape, self.spacing
        x, y = np.arange(nx, dtype=np.float64) * dx, np.arange(ny, dtype=np.float64) * dy
        return function(x, y, dx, dy)

    def _spectrum(
        self, quadrant: NDArray[np.float64], odd_x: bool = False, odd_y: bool = False
    ) -> KernelSpectrum:
        return self._convolution.kernel_spectrum(quadrant, odd_x, odd_y)

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """``uz`` (nx, ny) from pressure (nx, ny)."""
        self._convolve(((self._normal,),), (pressure,), (uz,))

    def normal_inverse(self, uz: FloatArray, pressure: FloatArray) -> None:
        """Pressure from ``uz`` by the inverse of the kernel's spectrum: a preconditioner, not the inverse.

        Counted in `transforms`, but not as an application.
        """
        self._convolve(((self._normal_inverse,),), (uz,), (pressure,))
        self.applications -= 1

    def tangential(self, shear: FloatArray, displacement: FloatArray) -> None:
        """Tangential displacement (2, nx, ny) from shear (2, nx, ny)."""
        if self.terms.cross:
            kernels = ((self._xx, self._xy), (self._xy, self._yy))
            self._convolve(kernels, (shear[0], shear[1]), (displacement[0], displacement[1]))
        else:
            self._convolve(((self._xx,),), (shear[0],), (displacement[0],))
            self._convolve(((self._yy,),), (shear[1],), (displacement[1],))
            self.applications -= 1

    def tangential_inverse(self, displacement: FloatArray, shear: FloatArray) -> None:
        """Shear (2, nx, ny) from displacement by the inverse of the spectrum: a preconditioner, not the inverse.

        Counted in `transforms`, but not as an application.
        """
        fields, results = (displacement[0], displacement[1]), (shear[0], shear[1])
        xx, yy, xy = self._inverse_tangential
        if self.terms.cross:
            kernels = ((xx, xy), (xy, yy))
            self._convolve(kernels, fields, results)
            self.applications -= 1
        else:
            self._convolve(((xx,),), fields[:1], results[:1])
            self._convolve(((yy,),), fields[1:], results[1:])
            self.applications -= 2

    def tangential_from_pressure(self, pressure: FloatArray, displacement: FloatArray) -> None:
        """Tangential displacement (2, nx, ny) from pressure (nx, ny); `terms` must couple."""
        kernels = ((self._xz,), (self._yz,))
        self._convolve(kernels, (pressure,), (displacement[0], displacement[1]), turned_field=0)

    def normal_from_shear(self, shear: FloatArray, uz: FloatArray) -> None:
        """``uz`` (nx, ny) from shear (2, nx, ny); `terms` must couple."""
        self._convolve(((self._xz, self._yz),), (shear[0], shear[1]), (uz,), turned_displacement=0)

    def all(self, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray) -> None:
        """Normal and tangential displacement from pressure and shear, with every term that is kept."""
        if not self.terms.coupled:
            self.normal(pressure, uz)
            self.tangential(shear, displacement)
            self.applications -= 1
            return
        kernels = (
            (self._normal, self._xz, self._yz),
            (self._xz, self._xx, self._xy),
            (self._yz, self._xy, self._yy),
        )
        fields = (pressure, shear[0], shear[1])
        self._convolve(kernels, fields, (uz, displacement[0], displacement[1]), 0, 0)

    def _convolve(
        self,
        kernels: KernelMatrix,
        fields: Sequence[FloatArray],
        displacements: Sequence[FloatArray],
        turned_field: int | None = None,
        turned_displacement: int | None = None,
    ) -> None:
        convolution = self._convolution
        while len(self._spectra) < max(len(fields), len(displacements)):
            self._spectra.append(convolution.spectrum_array())
        inputs, outputs = self._spectra[: len(fields)], self._spectra[: len(displacements)]
        for field, spectrum in zip(fields, inputs, strict=True):
            convolution.transform_rows(field, spectrum)
        convolution.multiply_columns(kernels, inputs, outputs, turned_field, turned_displacement)
        for displacement, spectrum in zip(displacements, outputs, strict=True):
            convolution.restore_rows(spectrum, displacement)
        self.applications += 1
