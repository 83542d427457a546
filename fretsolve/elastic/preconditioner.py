"""The inverse of the half-space's symbol on a periodic grid: a preconditioner of the contact's linear equations.

In an unbounded half-space a traction of wave vector k meets the compliance A/k where it is normal, A/k where it is a
shear along k and (A + B)/k where it is a shear across k. The inverse acts over a few cells only (its kernel falls as
1/r^3), so the window needs no zero-padding and single precision is enough: an application costs a small part of the
elastic operator's. The elastic operator's own padded spectra will not do: they ripple about the symbol, down to
negative values where dx and dy differ.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from fretsolve.elastic.convolution import KernelSpectrum, PaddedConvolution, RowSpace, fast_length
from fretsolve.elastic.thread_team import ALONE, Team
from fretsolve.model.materials import Compliances
from fretsolve.system.arrays import FloatArray

APART = 2
"""Cells of zeros at least between one period and the next."""


class SymbolInverse:
    """Tractions (MPa) from displacements (mm), times `factor`, in the precision `dtype`.

    cross: the shears along x and y are linked (ux from qy and uy from qx are kept); space: room shared with others.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        cross: bool,
        factor: float,
        dtype: type[np.floating],
        team: Team = ALONE,
        space: RowSpace | None = None,
    ):
        self.shape, self._spacing, self._material, self._cross = shape, spacing, compliances, cross
        self._size = (fast_length(shape[0] + APART), fast_length(shape[1] + APART))
        self._factor, self._dtype, self._team = factor, dtype, team
        self._space = space or RowSpace()

    @cached_property
    def _convolution(self) -> PaddedConvolution:
        return PaddedConvolution(self.shape, self._dtype, self._team, self._size)

    @property
    def transforms(self) -> float:
        """Pairs of transforms made so far, in parts of one padded to twice the size."""
        return self._convolution.transforms * self._size[0] * self._size[1] / (4 * self.shape[0] * self.shape[1])

    def normal(self, displacement: FloatArray, traction: FloatArray) -> None:
        """``traction`` (1, nx, ny) from displacement (1, nx, ny)."""
        self._alone(self._normal, displacement[0], traction[0])

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """``traction`` (2, nx, ny) from displacement (2, nx, ny)."""
        along_x, along_y, mixed = self._tangential
        if self._cross:
            kernels = ((along_x, mixed), (mixed, along_y))
            self._convolution.apply(kernels, (*displacement,), (*traction,), self._space)
        else:
            self._alone(along_x, displacement[0], traction[0])
            self._alone(along_y, displacement[1], traction[1])

    def _alone(self, inverse: KernelSpectrum, displacement: FloatArray, traction: FloatArray) -> None:
        """One component by itself; nothing to do where it is 0, as where no load is."""
        if displacement.any():
            self._convolution.apply(((inverse,),), (displacement,), (traction,), self._space)
        else:
            traction[:] = 0.0

    @cached_property
    def _normal(self) -> KernelSpectrum:
        return self._stored(1.0 / self._symbol())

    @cached_property
    def _tangential(self) -> tuple[KernelSpectrum, KernelSpectrum, KernelSpectrum]:
        """Spectra from ux to qx, from uy to qy, and from each to the other."""
        share = self._material.B / self._material.A
        kx, ky = self._wave_numbers()
        length = np.hypot(kx, ky)
        length[0, 0] = 1.0
        along_x, along_y = kx / length, ky / length
        inverse = 1.0 / self._symbol()
        if not self._cross:
            ux_to_qx, uy_to_qy = inverse / (1.0 + share * along_y**2), inverse / (1.0 + share * along_x**2)
            return self._stored(ux_to_qx), self._stored(uy_to_qy), self._stored(np.zeros((1, 1)))
        inverse /= 1.0 + share
        ux_to_qx, uy_to_qy = inverse * (1.0 + share * along_x**2), inverse * (1.0 + share * along_y**2)
        inverse *= share * along_x * along_y
        # The highest wave number of an even period stands for both signs, where this odd function is 0.
        (mx, my) = self._size
        if mx % 2 == 0:
            inverse[:, -1] = 0.0
        if my % 2 == 0:
            inverse[-1] = 0.0
        return self._stored(ux_to_qx), self._stored(uy_to_qy), self._stored(inverse, odd_x=True)

    def _stored(self, spectrum: FloatArray, odd_x: bool = False) -> KernelSpectrum:
        """With the factor, and the one that FFTW leaves out of inverse transforms."""
        return KernelSpectrum(spectrum, odd_x).scaled(self._factor / (self._size[0] * self._size[1]), self._dtype)

    def _wave_numbers(self) -> tuple[FloatArray, FloatArray]:
        """The angular wave numbers that are not negative, along x ``(1, mx//2 + 1)`` and y ``(my//2 + 1, 1)``."""
        (mx, my), (dx, dy) = self._size, self._spacing
        return 2.0 * math.pi * np.fft.rfftfreq(mx, dx)[None, :], 2.0 * math.pi * np.fft.rfftfreq(my, dy)[:, None]

    def _symbol(self) -> FloatArray:
        """A/k times the spectrum of a cell, with the nearest aliases.

        A wave longer than the grid counts as one of its length: k = 0 has no value of its own.
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
