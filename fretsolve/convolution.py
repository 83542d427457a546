"""Exact discrete convolution on a grid by real FFTs of a zero-padded copy (DC-FFT, Liu et al., Wear 243, 2000).

The padding is to at least 2n - 1 per side, so nothing wraps around. Rows of zeros are never transformed and
unwanted rows never transformed back: rows are padded and transformed along y into a spectrum of ``(nx, my//2 + 1)``;
then blocks of columns, small enough to stay in cache, are padded and transformed along x, multiplied with the
kernels' spectra and transformed back at once. The padded two-dimensional spectrum never exists as a whole.

Kernels are even or odd in x and in y; so their spectra are real (even-even, odd-odd) or imaginary (odd in one)
and mirrored. They are stored real, for the non-negative wave numbers only, each value twice in a row so that
it multiplies real and imaginary part of a complex number seen as two floats. An imaginary kernel links the
pressure to a shear; it is made real by turning the pressure's spectrum (and that of uz) by i: with
P = i p, i uz = Kzz P + Kzx qx and ux = Kzx P + Kxx qx, one symmetric real matrix per wave vector.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyfftw
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from fretsolve.wisdom import planner_effort

FloatArray = NDArray[np.floating]
ComplexArray = NDArray[np.complexfloating]

CACHE_BYTES = 400 * 1024
"""Size of the buffer of a block of columns or rows, so that three or four stay in a core's second-level cache."""


def padded_length(points: int) -> int:
    """Least fast even length of at least ``2 points - 1`` (1 for a single point)."""
    if points == 1:
        return 1
    length = next_fast_len(2 * points - 1, real=True)
    while length % 2:
        length = next_fast_len(length + 1, real=True)
    return int(length)


@dataclass(frozen=True)
class KernelSpectrum:
    """Spectrum of an influence function on the padded grid, scaled for unnormalised inverse transforms.

    values: ``(mx//2 + 1, 2 (my//2 + 1))`` real, each value twice; odd_x: the function is odd in x.
    """

    values: FloatArray
    odd_x: bool


KernelMatrix = tuple[tuple[KernelSpectrum, ...], ...]
"""Kernels from each field (column) to each displacement (row)."""


@dataclass(frozen=True)
class _ColumnBlock:
    """A padded block of columns, as complex numbers and as floats, with its transforms in place."""

    values: ComplexArray
    floats: FloatArray
    forward: pyfftw.FFTW
    backward: pyfftw.FFTW


def _even_share(lines: int, bytes_per_line: int) -> int:
    """Lines per block, of blocks about equal and near `CACHE_BYTES`."""
    blocks = max(1, round(lines * bytes_per_line / CACHE_BYTES))
    return -(-lines // blocks)


class PaddedConvolution:
    """Plans and buffers for convolutions on an ``(nx, ny)`` grid.

    One forward and one inverse transform of a field are counted together as one in `transforms` (half each).
    """

    def __init__(self, shape: tuple[int, int], dtype: type[np.floating] = np.float64, threads: int = 1):
        self.shape = shape
        nx, ny = shape
        self.padded = (padded_length(nx), padded_length(ny))
        self.columns = self.padded[1] // 2 + 1
        self.transforms = 0.0
        self._float = np.dtype(dtype)
        self._complex = np.dtype(np.complex64 if self._float == np.float32 else np.complex128)
        self._plan(threads)

    def _plan(self, threads: int) -> None:
        mx, my = self.padded
        size = self._complex.itemsize
        self._block_rows = _even_share(self.shape[0], size * self.columns)
        self._block_columns = _even_share(self.columns, size * mx)
        effort = planner_effort(self.padded)
        options = {"threads": threads, "flags": (effort, "FFTW_DESTROY_INPUT")}
        self._row_real = pyfftw.zeros_aligned((self._block_rows, my), self._float)
        self._row_complex = pyfftw.zeros_aligned((self._block_rows, self.columns), self._complex)
        self._rows_forward = pyfftw.FFTW(
            self._row_real, self._row_complex, axes=(1,), threads=threads, flags=(effort,)
        )
        self._back_complex = pyfftw.zeros_aligned((self._block_rows, self.columns), self._complex)
        self._back_real = pyfftw.zeros_aligned((self._block_rows, my), self._float)
        self._rows_backward = pyfftw.FFTW(
            self._back_complex, self._back_real, axes=(1,), direction="FFTW_BACKWARD", **options
        )
        self._row_real[:] = 0.0  # measuring a plan overwrites its arrays
        self._blocks: list[_ColumnBlock] = []
        self._product = np.zeros((mx, 2 * self._block_columns), self._float)
        self._options = options

    def _column_blocks(self, count: int) -> list[_ColumnBlock]:
        """`count` padded blocks of columns with their plans, made at the first need."""
        while len(self._blocks) < count:
            array = pyfftw.zeros_aligned((self.padded[0], self._block_columns), self._complex)
            self._blocks.append(
                _ColumnBlock(
                    array,
                    array.view(self._float),
                    pyfftw.FFTW(array, array, axes=(0,), **self._options),
                    pyfftw.FFTW(array, array, axes=(0,), direction="FFTW_BACKWARD", **self._options),
                )
            )
        return self._blocks[:count]

    def spectrum_array(self) -> ComplexArray:
        """An array for the row spectrum of one field."""
        array: ComplexArray = pyfftw.zeros_aligned((self.shape[0], self.columns), self._complex)
        return array

    def transform_rows(self, field: FloatArray, spectrum: ComplexArray) -> None:
        """Transform ``field`` (nx, ny) along y into ``spectrum`` (nx, my//2 + 1)."""
        nx, ny = self.shape
        for start in range(0, nx, self._block_rows):
            stop = min(start + self._block_rows, nx)
            self._row_real[: stop - start, :ny] = field[start:stop]
            self._rows_forward.execute()
            spectrum[start:stop] = self._row_complex[: stop - start]
        self.transforms += 0.5

    def restore_rows(self, spectrum: ComplexArray, field: FloatArray, accumulate: bool = False) -> None:
        """Transform ``spectrum`` back along y into ``field`` (nx, ny), or add to it."""
        nx, ny = self.shape
        for start in range(0, nx, self._block_rows):
            stop = min(start + self._block_rows, nx)
            self._back_complex[: stop - start] = spectrum[start:stop]
            self._rows_backward.execute()
            if accumulate:
                field[start:stop] += self._back_real[: stop - start, :ny]
            else:
                field[start:stop] = self._back_real[: stop - start, :ny]
        self.transforms += 0.5

    def multiply_columns(
        self,
        kernels: KernelMatrix,
        fields: Sequence[ComplexArray],
        displacements: Sequence[ComplexArray],
        turned_field: int | None = None,
        turned_displacement: int | None = None,
    ) -> None:
        """Row spectra of the displacements ``kernels @ fields`` from the row spectra of the fields.

        kernels: m x n; fields: n arrays ``(nx, my//2 + 1)``; displacements: m such arrays to be overwritten,
        which may be the same ones; turned_*: index of a spectrum that counts times i (top of this file).
        """
        blocks = self._column_blocks(1 if len(fields) == len(displacements) == 1 else len(fields) + len(displacements))
        inputs, outputs = blocks[: len(fields)], blocks[-len(displacements) :]
        nx = self.shape[0]
        for start in range(0, self.columns, self._block_columns):
            stop = min(start + self._block_columns, self.columns)
            width = stop - start
            for index, (spectrum, block) in enumerate(zip(fields, inputs, strict=True)):
                block.values[:nx, :width] = spectrum[:, start:stop]
                block.values[nx:] = 0.0
                if index == turned_field:
                    block.values[:nx, :width] *= 1j
                block.forward.execute()
            self._multiply(kernels, inputs, outputs, slice(2 * start, 2 * stop))
            for index, (spectrum, block) in enumerate(zip(displacements, outputs, strict=True)):
                block.backward.execute()
                if index == turned_displacement:
                    block.values[:nx, :width] *= -1j
                spectrum[:, start:stop] = block.values[:nx, :width]

    def _multiply(
        self,
        kernels: KernelMatrix,
        inputs: Sequence[_ColumnBlock],
        outputs: Sequence[_ColumnBlock],
        columns: slice,
    ) -> None:
        """``outputs = kernels @ inputs`` for the wave numbers in `columns` (in floats, two per column)."""
        width = columns.stop - columns.start
        for row, output in zip(kernels, outputs, strict=True):
            for index, (kernel, field) in enumerate(zip(row, inputs, strict=True)):
                product = self._product if index else output.floats
                self._multiply_mirrored(kernel, field.floats, product, columns)
                if index:
                    output.floats[:, :width] += product[:, :width]

    def _multiply_mirrored(
        self, kernel: KernelSpectrum, field: FloatArray, product: FloatArray, columns: slice
    ) -> None:
        """Non-negative wave numbers along x as stored, negative ones mirrored."""
        width = columns.stop - columns.start
        values = kernel.values[:, columns]
        half = values.shape[0]
        np.multiply(field[:half, :width], values, out=product[:half, :width])
        mirrored = values[self.padded[0] - half : 0 : -1]
        np.multiply(field[half:, :width], mirrored, out=product[half:, :width])
        if kernel.odd_x:
            np.negative(product[half:, :width], out=product[half:, :width])

    def kernel_spectrum(self, quadrant: FloatArray, odd_x: bool, odd_y: bool) -> KernelSpectrum:
        """Spectrum of the influence function given at offsets 0..nx-1, 0..ny-1 in cells, ``(nx, ny)``."""
        mx, my = self.padded
        nx, ny = self.shape
        padded = np.zeros((mx, my))
        padded[:nx, :ny] = quadrant
        if nx > 1:
            padded[mx - nx + 1 :, :ny] = (-1 if odd_x else 1) * quadrant[:0:-1]
        if ny > 1:
            padded[:, my - ny + 1 :] = (-1 if odd_y else 1) * padded[:, ny - 1 : 0 : -1]
        half_x = mx // 2 + 1
        complete = pyfftw.interfaces.numpy_fft.rfft2(padded, planner_effort="FFTW_ESTIMATE")[:half_x]
        values = complete.imag if odd_x != odd_y else complete.real
        doubled = np.repeat(values / (mx * my), 2, axis=1).astype(self._float)
        return KernelSpectrum(doubled, odd_x)

    def wave_numbers(self, spacing: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Angular wave numbers along x ``(mx//2 + 1, 1)`` and y ``(1, 2 (my//2 + 1))``, as in `KernelSpectrum`."""
        mx, my = self.padded
        kx = 2.0 * np.pi / (mx * spacing[0]) * np.arange(mx // 2 + 1, dtype=np.float64)[:, None]
        ky = 2.0 * np.pi / (my * spacing[1]) * np.repeat(np.arange(self.columns, dtype=np.float64), 2)[None, :]
        return kx, ky

    def spectrum_from_symbol(self, symbol: FloatArray, odd_x: bool) -> KernelSpectrum:
        """A kernel given by its spectrum at `wave_numbers`."""
        return KernelSpectrum((symbol / (self.padded[0] * self.padded[1])).astype(self._float), odd_x)
