"""Preconditioner of the contact's linear equations: the inverse of the half-space's symbol on a periodic grid.

In an unbounded half-space a traction of wave vector k meets the compliance A/k if it is normal, A/k if it is a shear
along k and (A + B)/k if it is a shear across k (T8 of docs/theory.md). The inverse of this symbol acts over a few cells
only: its kernel falls like 1/r^3. So the contact needs no zero-padding, single precision is enough, and an application
costs a small part of one of the elastic operator. The spectra of the elastic operator would not do: they ripple about
the symbol, down to negative values if dx and dy differ.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from fretsolve.elastic.convolution import KernelSpectrum, PaddedConvolution, RowSpectra
from fretsolve.elastic.thread_team import ONE_THREAD, ThreadTeam
from fretsolve.elastic.transform_length import fast_length
from fretsolve.model.materials import Compliances
from fretsolve.system.arrays import FloatArray

APART = 2
"""Least number of cells of zeros between one period and the next."""


class Preconditioner:
    """Computes tractions (MPa) from displacements (mm), times `factor`, in the precision `dtype`.

    in_plane_coupling: qx depends on uy as well, and qy on ux; row_spectra: memory for row spectra, shared with others.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        in_plane_coupling: bool,
        factor: float,
        threads: ThreadTeam = ONE_THREAD,
        row_spectra: RowSpectra | None = None,
        dtype: type[np.floating] = np.float64,
    ):
        self.shape, self._spacing, self._material, self._in_plane = shape, spacing, compliances, in_plane_coupling
        self._size = (fast_length(shape[0] + APART), fast_length(shape[1] + APART))
        self._factor, self._dtype, self._threads = factor, dtype, threads
        self._row_spectra = row_spectra or RowSpectra()

    @cached_property
    def _convolution(self) -> PaddedConvolution:
        return PaddedConvolution(self.shape, self._dtype, self._threads, self._size)

    def normal(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (1, nx, ny) from displacement (1, nx, ny)."""
        self._separately((self._normal,), displacement, traction)

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (2, nx, ny) from displacement (2, nx, ny)."""
        along_x, along_y, mixed = self._tangential
        if self._in_plane:
            kernels = ((along_x, mixed), (mixed, along_y))
            self._convolution.apply(kernels, (*displacement,), (*traction,), self._row_spectra)
        else:
            self._separately((along_x, along_y), displacement, traction)

    def _separately(self, kernels: tuple[KernelSpectrum, ...], fields: FloatArray, tractions: FloatArray) -> None:
        """Compute each component by itself, without a transform where the field is 0."""
        for kernel, field, traction in zip(kernels, fields, tractions, strict=True):
            if field.any():
                self._convolution.apply(((kernel,),), (field,), (traction,), self._row_spectra)
            else:
                traction[:] = 0.0

    @cached_property
    def _normal(self) -> KernelSpectrum:
        return self._scaled(1.0 / self._symbol())

    @cached_property
    def _tangential(self) -> tuple[KernelSpectrum, KernelSpectrum, KernelSpectrum]:
        """Spectra from ux to qx, from uy to qy, and from each to the other (the inverse of the 2 x 2 symbol)."""
        share = self._material.B / self._material.A
        kx, ky = self._wave_numbers()
        length = np.hypot(kx, ky)
        length[0, 0] = 1.0
        along_x, along_y = kx / length, ky / length
        inverse = 1.0 / self._symbol()
        if not self._in_plane:
            ux_to_qx, uy_to_qy = inverse / (1.0 + share * along_y**2), inverse / (1.0 + share * along_x**2)
            return self._scaled(ux_to_qx), self._scaled(uy_to_qy), self._scaled(np.zeros((1, 1)))
        inverse /= 1.0 + share
        ux_to_qx, uy_to_qy = inverse * (1.0 + share * along_x**2), inverse * (1.0 + share * along_y**2)
        inverse *= share * along_x * along_y
        # The highest wave number of an even period stands for both signs; the odd function is 0 there.
        (mx, my) = self._size
        if mx % 2 == 0:
            inverse[:, -1] = 0.0
        if my % 2 == 0:
            inverse[-1] = 0.0
        return self._scaled(ux_to_qx), self._scaled(uy_to_qy), self._scaled(inverse, odd_x=True)

    def _scaled(self, spectrum: FloatArray, odd_x: bool = False) -> KernelSpectrum:
        """Multiply by the factor, and by the one that FFTW leaves out of inverse transforms."""
        return KernelSpectrum(spectrum, odd_x).scaled(self._factor / (self._size[0] * self._size[1]), self._dtype)

    def _wave_numbers(self) -> tuple[FloatArray, FloatArray]:
        """Return the non-negative angular wave numbers along x ``(1, mx//2 + 1)`` and y ``(my//2 + 1, 1)``."""
        (mx, my), (dx, dy) = self._size, self._spacing
        return 2.0 * math.pi * np.fft.rfftfreq(mx, dx)[None, :], 2.0 * math.pi * np.fft.rfftfreq(my, dy)[:, None]

    def _symbol(self) -> FloatArray:
        """Return A/k times the spectrum of a cell, summed over the nearest aliases.

        A wave longer than the grid counts as one of its length, because A/k is infinite at k = 0.
        """
        kx, ky = self._wave_numbers()
        dx, dy = self._spacing
        shortest = math.pi / max(self.shape[0] * dx, self.shape[1] * dy)
        total = np.zeros((ky.size, kx.size))
        for shifted_x in (kx, kx - 2 * math.pi / dx):
            for shifted_y in (ky, ky - 2 * math.pi / dy):
                length = np.hypot(shifted_x, shifted_y)
                np.maximum(length, shortest, out=length)
                total += np.sinc(shifted_x * dx / (2 * math.pi)) * np.sinc(shifted_y * dy / (2 * math.pi)) / length
        return self._material.A * total
