"""Exact discrete convolution on a grid by real FFTs of a zero-padded copy (DC-FFT, Liu et al., Wear 243, 2000).

The padding is to at least 2n - 1 per side, so nothing wraps around. Rows of zeros are never transformed and
unwanted rows never transformed back: rows are padded and transformed along y into a spectrum of ``(nx, my//2 + 1)``,
two at a time as the real and the imaginary part of one, which FFTW does in single precision in half the time;
then blocks of columns, small enough to stay in cache, are turned into padded lines and transformed along x,
multiplied with the kernels' spectra and transformed back at once. The padded two-dimensional spectrum never exists as
a whole.

Kernels are even or odd in x and in y; so their spectra are real (even-even, odd-odd) or imaginary (odd in one)
and mirrored. They are computed by cosine and sine transforms of the quadrant of non-negative offsets and stored real,
for the non-negative wave numbers only. An imaginary kernel links the pressure to a shear; it is made real by turning
the pressure's spectrum (and that of uz) by i: with P = i p, i uz = Kzz P + Kzx qx and ux = Kzx P + Kxx qx, one
symmetric real matrix per wave vector.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.fftw import pyfftw
from fretsolve.elastic.fftw_wisdom import plan, planner_effort
from fretsolve.elastic.thread_team import ALONE, Team
from fretsolve.kernels import spectral
from fretsolve.system.arrays import ComplexArray, FloatArray

CACHE_BYTES = 400 * 1024
"""Size of the buffer of a block of columns or rows, so that three or four stay in a core's second-level cache."""


ALIGNMENT = 64
"""Bytes, of a cache line and of the longest vector instructions."""


TIME_BY_TWOS = (2.5, 2.0, 1.4, 1.2, 1.0)
"""About how long FFTW takes per point of a transform whose length holds 2 that many times, relative to lengths with
16, which vector instructions suit best (`benchmarks/transform_lengths.py`)."""


def padded_length(points: int) -> int:
    """Even length of at least ``2 points - 1`` that is transformed fast (1 for a single point)."""
    return 1 if points == 1 else fast_length(2 * points - 1, even=True)


def fast_length(least: int, even: bool = False) -> int:
    """Length of at least `least` on which square fields are transformed fastest; a product of 2, 3 and 5."""
    best, least_time = 0, math.inf
    length = smooth_length(least)
    while length * length < least_time:
        twos = min((length & -length).bit_length(), len(TIME_BY_TWOS)) - 1
        time = TIME_BY_TWOS[twos] * length * length
        if time < least_time and (twos or not even):
            best, least_time = length, time
        length = smooth_length(length + 1)
    return best


def smooth_length(least: int) -> int:
    """The smallest product of 2, 3 and 5 that is at least `least`."""
    best: int = 1 << (least - 1).bit_length()
    fives = 1
    while fives < best:
        odd = fives
        while odd < best:
            best = min(best, odd << (-(-least // odd) - 1).bit_length())
            odd *= 3
        fives *= 5
    return best


@dataclass(frozen=True)
class KernelSpectrum:
    """Spectrum of an influence function on the padded grid, scaled for unnormalised inverse transforms.

    values: ``(my//2 + 1, mx//2 + 1)``, real, x along the lines; odd_x: the function is odd in x.
    """

    values: FloatArray
    odd_x: bool

    def scaled(self, factor: float, dtype: type[np.floating]) -> KernelSpectrum:
        """The same times `factor`, in another precision."""
        return KernelSpectrum((self.values * factor).astype(dtype), self.odd_x)


KernelMatrix = tuple[tuple[KernelSpectrum, ...], ...]
"""Kernels from each field (column) to each displacement (row)."""


@dataclass(frozen=True)
class _Block:
    """A block of padded lines with their transforms in place."""

    values: ComplexArray
    forward: pyfftw.FFTW
    backward: pyfftw.FFTW


def _parts(lines: int, bytes_per_line: int) -> list[slice]:
    """Lines in blocks about equal and near `CACHE_BYTES`."""
    share = -(-lines // max(1, round(lines * bytes_per_line / CACHE_BYTES)))
    return [slice(start, min(start + share, lines)) for start in range(0, lines, share)]


def _longest(parts: Sequence[slice]) -> int:
    longest: int = parts[0].stop - parts[0].start
    return longest


class RowSpace:
    """Room for row spectra, lent to convolutions that never work at the same time."""

    def __init__(self) -> None:
        self._bytes: NDArray[np.uint8] = np.empty(0, np.uint8)

    def arrays(self, count: int, shape: tuple[int, int], dtype: np.dtype[Any]) -> list[ComplexArray]:
        """`count` arrays that stay good until the next call; their contents are whatever was there."""
        size = shape[0] * shape[1] * dtype.itemsize
        stride = size + -size % ALIGNMENT
        if self._bytes.size < count * stride:
            self._bytes = pyfftw.empty_aligned(count * stride, np.uint8, n=ALIGNMENT)
        parts = (self._bytes[index * stride : index * stride + size] for index in range(count))
        return [part.view(dtype).reshape(shape) for part in parts]

    def release(self) -> None:
        """Give the memory back until it is needed again."""
        self._bytes = np.empty(0, np.uint8)


class PaddedConvolution:
    """Plans and buffers for convolutions on an ``(nx, ny)`` grid.

    padded: periods other than those in which nothing wraps around. One forward and one inverse transform of a field
    are counted together as one in `transforms` (half each).
    """

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: type[np.floating] = np.float64,
        team: Team = ALONE,
        padded: tuple[int, int] | None = None,
    ):
        self.shape = shape
        self.padded = padded or (padded_length(shape[0]), padded_length(shape[1]))
        self.columns = self.padded[1] // 2 + 1
        self.transforms = 0.0
        self._float = np.dtype(dtype)
        self._complex = np.dtype(np.complex64 if self._float == np.float32 else np.complex128)
        self._team = team
        mx, my = self.padded
        size = self._complex.itemsize
        self._pairs = (shape[0] + 1) // 2
        self._row_parts = _parts(self._pairs, size * my)
        self._column_parts = _parts(self.columns, size * mx)
        self._row_blocks = [self._planned(_longest(self._row_parts), my) for _ in self._members(self._row_parts)]
        self._column_blocks: list[list[_Block]] = [[] for _ in self._members(self._column_parts)]

    def _members(self, parts: Sequence[slice]) -> range:
        """The threads among which `parts` can be shared out, each with blocks of its own."""
        return range(min(self._team.count, len(parts)))

    def _planned(self, lines: int, length: int) -> _Block:
        values = pyfftw.zeros_aligned((lines, length), self._complex)
        options: dict[str, Any] = {"axes": (1,), "flags": (planner_effort(self.padded), "FFTW_DESTROY_INPUT")}
        forward = plan(values, values, **options)
        return _Block(values, forward, plan(values, values, direction="FFTW_BACKWARD", **options))

    @cached_property
    def _products(self) -> list[tuple[ComplexArray, ComplexArray]]:
        """Room for products of a block where fields interact, for each thread."""
        shape = _longest(self._column_parts), self.padded[0]
        return [(np.zeros(shape, self._complex), np.zeros(shape, self._complex)) for _ in self._column_blocks]

    def _provide_column_blocks(self, count: int) -> None:
        """`count` padded blocks of columns with their plans for each thread, made at the first need."""
        for blocks in self._column_blocks:
            while len(blocks) < count:
                blocks.append(self._planned(_longest(self._column_parts), self.padded[0]))
        if count > 1:
            _ = self._products  # made here, not by several threads at once

    def apply(
        self,
        kernels: KernelMatrix,
        fields: Sequence[FloatArray],
        displacements: Sequence[FloatArray],
        space: RowSpace,
        turned_field: int | None = None,
        turned_displacement: int | None = None,
    ) -> None:
        """``displacements = kernels @ fields``, m from n fields (nx, ny); see `multiply_columns`."""
        rows = self.row_spectra(max(len(fields), len(displacements)), space)
        inputs, outputs = rows[: len(fields)], rows[: len(displacements)]
        for field, spectrum in zip(fields, inputs, strict=True):
            self.transform_rows(field, spectrum)
        self.multiply_columns(kernels, inputs, outputs, turned_field, turned_displacement)
        for displacement, spectrum in zip(displacements, outputs, strict=True):
            self.restore_rows(spectrum, displacement)

    def row_spectra(self, count: int, space: RowSpace) -> list[ComplexArray]:
        """Arrays for the row spectra of `count` fields, not cleared."""
        return space.arrays(count, (self.shape[0], self.columns), self._complex)

    def transform_rows(self, field: FloatArray, spectrum: ComplexArray) -> None:
        """Transform ``field`` (nx, ny) along y into ``spectrum`` (nx, my//2 + 1)."""

        def transform(member: int, part: slice) -> None:
            block, (upper, lower) = self._row_blocks[member], self._row_pairs(part)
            lines = block.values[: part.stop - part.start]
            spectral.join_rows(field[upper], field[lower], lines)
            block.forward.execute()
            spectral.split_spectra(lines, spectrum[upper], spectrum[lower])

        self._team.share(transform, self._row_parts)
        self.transforms += 0.5

    def restore_rows(self, spectrum: ComplexArray, field: FloatArray) -> None:
        """Transform ``spectrum`` back along y into ``field`` (nx, ny)."""

        def restore(member: int, part: slice) -> None:
            block, (upper, lower) = self._row_blocks[member], self._row_pairs(part)
            lines = block.values[: part.stop - part.start]
            spectral.join_spectra(spectrum[upper], spectrum[lower], lines)
            block.backward.execute()
            spectral.split_rows(lines, field[upper], field[lower])

        self._team.share(restore, self._row_parts)
        self.transforms += 0.5

    def _row_pairs(self, part: slice) -> tuple[slice, slice]:
        """The rows of the grid that are the real and the imaginary parts of a block's lines."""
        return part, slice(self._pairs + part.start, min(self._pairs + part.stop, self.shape[0]))

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
        self._provide_column_blocks(max(len(fields), len(displacements)))

        def multiply(member: int, columns: slice) -> None:
            blocks = self._column_blocks[member]
            lines = [block.values[: columns.stop - columns.start] for block in blocks]
            for index, spectrum in enumerate(fields):
                spectral.take_columns(spectrum[:, columns], lines[index])
                if index == turned_field:
                    lines[index] *= 1j
                blocks[index].forward.execute()
            self._multiply(kernels, lines[: len(fields)], lines[: len(displacements)], columns, member)
            for index, spectrum in enumerate(displacements):
                blocks[index].backward.execute()
                if index == turned_displacement:
                    lines[index] *= -1j
                spectral.give_columns(lines[index], spectrum[:, columns])

        self._team.share(multiply, self._column_parts)

    def _multiply(
        self,
        kernels: KernelMatrix,
        fields: Sequence[ComplexArray],
        results: Sequence[ComplexArray],
        columns: slice,
        member: int,
    ) -> None:
        """``results = kernels @ fields`` for a block of columns, the results in the fields' arrays; symmetric where
        there are as many of them."""
        if len(fields) == len(results) == 1:
            spectral.multiply(kernels[0][0].values[columns], kernels[0][0].odd_x, fields[0], results[0])
            return
        one, other = self._products[member]
        room = one[: len(fields[0])], other[: len(fields[0])]
        values = [[kernel.values[columns] for kernel in row] for row in kernels]
        if len(fields) == len(results) == 2:
            (along_x, mixed), (_, along_y) = values
            pair = (fields[0], fields[1])
            spectral.multiply_pair((along_x, along_y, mixed), kernels[0][1].odd_x, pair, pair, room)
        elif len(fields) == len(results) == 3:
            (zz, zx, zy), (_, xx, xy), (_, _, yy) = values
            odd = (kernels[0][1].odd_x, kernels[0][2].odd_x, kernels[1][2].odd_x)
            spectral.multiply_coupled((zz, xx, yy), (zx, zy, xy), odd, (fields[0], fields[1], fields[2]))
        else:
            self._multiply_one_by_one(kernels, values, fields, results, room[0])

    @staticmethod
    def _multiply_one_by_one(
        kernels: KernelMatrix,
        values: list[list[FloatArray]],
        fields: Sequence[ComplexArray],
        results: Sequence[ComplexArray],
        room: ComplexArray,
    ) -> None:
        """The same for one field or one result; the first result, which overwrites the first field, comes last."""
        for index in reversed(range(len(results))):
            result = results[index]
            spectral.multiply(values[index][0], kernels[index][0].odd_x, fields[0], result)
            for kernel, value, field in zip(kernels[index][1:], values[index][1:], fields[1:], strict=True):
                spectral.multiply(value, kernel.odd_x, field, room)
                result += room

    def kernel_spectrum(self, quadrant: FloatArray, odd_x: bool, odd_y: bool) -> KernelSpectrum:
        """Spectrum of the influence function given at offsets 0..nx-1, 0..ny-1 in cells, ``(nx, ny)``."""
        mx, my = self.padded
        values = np.zeros((my // 2 + 1, mx // 2 + 1))
        values[: self.shape[1], : self.shape[0]] = quadrant.T
        values /= mx * my
        for axis, odd in enumerate((odd_y, odd_x)):
            _transform_half(values, odd, axis)
        if odd_x or odd_y:
            np.negative(values, out=values)  # -i of one sine transform, (-i)^2 of two
        return KernelSpectrum(values.astype(self._float, copy=False), odd_x)


def _transform_half(values: FloatArray, odd: bool, axis: int) -> None:
    """In place, the transform along `axis` of the even or odd function given at offsets 0..m/2 of its period m.

    Of an odd one the sine part alone, with the sign of a sine transform.
    """
    lines = values.T if axis == 0 else values
    inner, direction = (lines[:, 1:-1], "FFTW_RODFT00") if odd else (lines, "FFTW_REDFT00")
    if inner.shape[1] > 1 or (odd and inner.size):
        plan(inner, inner, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE",)).execute()
    if odd:
        lines[:, 0] = 0.0
        lines[:, -1] = 0.0
