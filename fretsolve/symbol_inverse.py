"""The inverse of the half-space's symbol on a periodic grid: a preconditioner of the contact's linear equations.

In an unbounded half-space a traction of wave vector k meets the compliance A/k where it is normal, A/k where it is a
shear along k and (A + B)/k where it is a shear across k. The inverse acts over a few cells only (its kernel falls as
1/r^3), so the window needs no zero-padding and single precision is enough: an application costs a small part of the
elastic operator's. The elastic operator's own padded spectra will not do: they ripple about the symbol, down to
negative values where dx and dy differ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from fretsolve.convolution import CACHE_BYTES
from fretsolve.fftw import pyfftw
from fretsolve.materials import Compliances
from fretsolve.pointwise import spectral
from fretsolve.wisdom import plan, planner_effort

FloatArray = NDArray[np.floating]
ComplexArray = NDArray[np.complexfloating]

APART = 2
"""Cells of zeros at least between one period and the next."""


class SymbolInverse:
    """Tractions (MPa) from displacements (mm), times `factor`, in the precision `dtype`.

    cross: the shears along x and y are linked (ux from qy and uy from qx are kept).
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        cross: bool,
        factor: float,
        dtype: type[np.floating],
        threads: int = 1,
    ):
        self.shape, self._spacing, self._material, self._cross = shape, spacing, compliances, cross
        self._size = (_period(shape[0]), _period(shape[1]))
        self._factor, self._dtype, self._threads = factor, dtype, threads
        self.transforms = 0.0
        self._parts: list[_Transform] = []

    def normal(self, displacement: FloatArray, traction: FloatArray) -> None:
        """``traction`` (1, nx, ny) from displacement (1, nx, ny)."""
        self._alone(0, self._normal, displacement[0], traction[0])

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """``traction`` (2, nx, ny) from displacement (2, nx, ny)."""
        along_x, along_y, mixed = self._tangential
        if not self._cross:
            self._alone(0, along_x, displacement[0], traction[0])
            self._alone(1, along_y, displacement[1], traction[1])
            return
        x, y = (self._transformed(part, displacement[part]) for part in (0, 1))
        rows = self._products[0].shape[0]
        for start in range(0, self._size[0], rows):
            block = slice(start, start + rows)
            fields = x[block], y[block]
            room = self._products[0][: len(fields[0])], self._products[1][: len(fields[0])]
            spectral.multiply_pair((along_x[block], along_y[block], mixed[block]), False, fields, fields, room)
        for part in (0, 1):
            self._restore(part, traction[part])

    def _alone(self, part: int, inverse: FloatArray, displacement: FloatArray, traction: FloatArray) -> None:
        """One component by itself; nothing to do where it is 0, as where no load is."""
        if displacement.any():
            spectrum = self._transformed(part, displacement)
            np.multiply(spectrum, inverse, out=spectrum)
            self._restore(part, traction)
        else:
            traction[:] = 0.0

    def _transformed(self, part: int, field: FloatArray) -> ComplexArray:
        """Spectrum of the padded field, in the arrays of component `part`."""
        nx, ny = self.shape
        while len(self._parts) <= part:
            self._parts.append(_Transform.planned(self._size, self._dtype, self._threads))
        transform = self._parts[part]
        transform.field[:nx, :ny] = field
        transform.field[nx:] = 0.0
        transform.field[:nx, ny:] = 0.0
        transform.forward.execute()
        self.transforms += self._size[0] * self._size[1] / (4 * nx * ny)
        return transform.spectrum

    def _restore(self, part: int, traction: FloatArray) -> None:
        self._parts[part].backward.execute()
        traction[:] = self._parts[part].field[: self.shape[0], : self.shape[1]]

    @cached_property
    def _products(self) -> tuple[ComplexArray, ComplexArray]:
        """Room for products of a block of rows that stays in cache."""
        columns, item = self._size[1] // 2 + 1, 2 * np.dtype(self._dtype).itemsize
        rows = min(self._size[0], max(1, CACHE_BYTES // (4 * columns * item)))
        spectrum = self._parts[0].spectrum
        return np.empty((rows, columns), spectrum.dtype), np.empty((rows, columns), spectrum.dtype)

    @cached_property
    def _normal(self) -> FloatArray:
        return self._stored(1.0 / self._symbol())

    @cached_property
    def _tangential(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Spectra from ux to qx, from uy to qy, and from each to the other."""
        share = self._material.B / self._material.A
        kx, ky = self._wave_numbers()
        length = np.hypot(kx, ky)
        length[0, 0] = 1.0
        along_x, along_y = kx / length, ky / length
        inverse = 1.0 / self._symbol()
        if not self._cross:
            ux_to_qx, uy_to_qy = inverse / (1.0 + share * along_y**2), inverse / (1.0 + share * along_x**2)
            return self._stored(ux_to_qx), self._stored(uy_to_qy), np.zeros((1, 1))
        inverse /= 1.0 + share
        ux_to_qx, uy_to_qy = inverse * (1.0 + share * along_x**2), inverse * (1.0 + share * along_y**2)
        inverse *= share * along_x * along_y
        # The highest wave number of an even period stands for both signs, where this odd function is 0.
        (mx, my) = self._size
        if mx % 2 == 0:
            inverse[mx // 2] = 0.0
        if my % 2 == 0:
            inverse[:, -1] = 0.0
        return self._stored(ux_to_qx), self._stored(uy_to_qy), self._stored(inverse)

    def _stored(self, spectrum: FloatArray) -> FloatArray:
        """With the factor, and the one that FFTW leaves out of inverse transforms."""
        return (spectrum * (self._factor / (self._size[0] * self._size[1]))).astype(self._dtype)

    def _wave_numbers(self) -> tuple[FloatArray, FloatArray]:
        """Angular wave numbers along x ``(mx, 1)`` and y ``(1, my//2 + 1)``."""
        (mx, my), (dx, dy) = self._size, self._spacing
        return 2.0 * math.pi * np.fft.fftfreq(mx, dx)[:, None], 2.0 * math.pi * np.fft.rfftfreq(my, dy)[None, :]

    def _symbol(self) -> FloatArray:
        """A/k times the spectrum of a cell, with the nearest aliases.

        A wave longer than the grid counts as one of its length: k = 0 has no value of its own.
        """
        kx, ky = self._wave_numbers()
        kx = np.abs(kx)
        dx, dy = self._spacing
        shortest = math.pi / max(self.shape[0] * dx, self.shape[1] * dy)
        total = np.zeros((kx.size, ky.size))
        for shifted_x in (kx, kx - 2 * math.pi / dx):
            for shifted_y in (ky, ky - 2 * math.pi / dy):
                length = np.hypot(shifted_x, shifted_y)
                np.maximum(length, shortest, out=length)
                total += np.sinc(shifted_x * dx / (2 * math.pi)) * np.sinc(shifted_y * dy / (2 * math.pi)) / length
        return self._material.A * total


@dataclass(frozen=True)
class _Transform:
    """A padded field, its spectrum, and the plans between them."""

    field: FloatArray
    spectrum: ComplexArray
    forward: pyfftw.FFTW
    backward: pyfftw.FFTW

    @classmethod
    def planned(cls, size: tuple[int, int], dtype: type[np.floating], threads: int) -> _Transform:
        """With plans made."""
        field = pyfftw.zeros_aligned(size, dtype)
        complex_type = np.complex64 if field.dtype == np.float32 else np.complex128
        spectrum = pyfftw.zeros_aligned((size[0], size[1] // 2 + 1), complex_type)
        options = {"axes": (0, 1), "threads": threads}
        effort = planner_effort(size)
        return cls(
            field,
            spectrum,
            plan(field, spectrum, flags=(effort, "FFTW_DESTROY_INPUT"), **options),
            plan(spectrum, field, direction="FFTW_BACKWARD", flags=(effort, "FFTW_DESTROY_INPUT"), **options),
        )


def _period(points: int) -> int:
    """Least fast length with `APART` cells more."""
    return int(next_fast_len(points + APART, real=True))
