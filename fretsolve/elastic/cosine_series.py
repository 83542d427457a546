"""Cosine and sine series along y of fields that are even or odd about y = 0.

The cells lie at y = (j + 1/2) dy, j >= 0. An even field of the period 2 N dy has the coefficients

    F_s = 2 sum f_j cos(pi s (2 j + 1)/2N),   f_j = F_0 + 2 sum_(0 < s < N) F_s cos(..),   up to a factor,

and an odd one the same with sines, where s runs from 1 to N, and G_N counts once, like F_0. Coefficient s of a field is
F_s or G_s, but coefficient 0 of an odd one is G_N. They belong to the Fourier series F_s and -i G_s of the whole field.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fretsolve.elastic.fftw import CacheBlock, even_parts
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import Fields, FloatArray

MOST_PRODUCTS = 2**18
"""Products of numbers up to which a transform is one of matrices, about 80 x 80 cells. Larger ones would be shared out
among threads of BLAS's own."""

TANGENTIAL = False, True
"""Which of the components x and y of a tangential field are odd."""


class MatrixTransform:
    """Transforms of fields with `columns` cells along y into `count` coefficients, as products with matrices.

    On small grids these cost two calls.
    """

    def __init__(self, columns: int, count: int, dtype: np.dtype[Any]):
        angles = np.pi / (2 * count) * np.outer(np.arange(count), 2 * np.arange(columns) + 1)
        both = np.array([np.cos(angles), np.sin(angles)])
        both[1, 0] = (-1.0) ** np.arange(columns)
        weights = np.where(np.arange(count) == 0, 1.0, 2.0)[:, None]
        self._forward, self._backward = (2.0 * both).astype(dtype), (weights * both).astype(dtype)

    def forward(self, fields: Fields, odd: Sequence[bool], coefficients: Fields) -> None:
        """Write the coefficients of fields (nx, columns) into as many of the `coefficients`, (count, nx)."""
        if isinstance(fields, np.ndarray) and isinstance(coefficients, np.ndarray) and odd == TANGENTIAL:  # in one call
            np.matmul(self._forward, fields.transpose(0, 2, 1), out=coefficients, casting="same_kind")
            return
        for field, is_odd, found in zip(fields, odd, coefficients, strict=False):
            np.matmul(self._forward[int(is_odd)], field.T, out=found, casting="same_kind")

    def backward(self, coefficients: Fields, odd: Sequence[bool], fields: Fields) -> None:
        """Write the fields (nx, columns) with the `coefficients`, (count, nx)."""
        if isinstance(fields, np.ndarray) and isinstance(coefficients, np.ndarray) and odd == TANGENTIAL:
            np.matmul(coefficients.transpose(0, 2, 1), self._backward, out=fields, casting="same_kind")
            return
        for values, is_odd, field in zip(coefficients, odd, fields, strict=False):
            np.matmul(values.T, self._backward[int(is_odd)], out=field, casting="same_kind")


class FastTransform:
    """The same by complex transforms of the length `count` (Makhoul, IEEE Trans. ASSP 28, 1980), for large grids.

    A cosine series is the Fourier series of the even cells followed by the odd ones in reverse, turned by a phase. Two
    rows are transformed at a time, as the real and the imaginary part of one. FFTW's own cosine transforms do not use
    vector instructions, and take six times as long.
    """

    def __init__(self, shape: tuple[int, int], count: int, dtype: np.dtype[Any], team: ThreadTeam):
        complex_type = np.result_type(dtype, np.complex64)
        self._team, self._kernels, pairs = team, team.kernels.cosine_coefficients, (shape[0] + 1) // 2
        self._phases = np.exp(-0.5j * np.pi / count * np.arange(count)).astype(complex_type)
        parts = even_parts(pairs, count * complex_type.itemsize)
        self._halves = [(part, slice(pairs + part.start, pairs + part.stop)) for part in parts]
        # p, qx and qy at most
        members = team.members(range(3 * len(parts)))
        self._blocks = [CacheBlock((parts[0].stop, count), complex_type) for _ in members]

    def forward(self, fields: Fields, odd: Sequence[bool], coefficients: Fields) -> None:
        """Write the coefficients of fields (nx, columns) into as many of the `coefficients`, (count, nx)."""

        def transform(member: int, rows: tuple[FloatArray, bool, FloatArray, slice, slice]) -> None:
            """Transform some rows and, as their imaginary parts, as many of the lower half."""
            field, is_odd, found, upper, lower = rows
            block, count = self._blocks[member], upper.stop - upper.start
            self._kernels.fold_rows(field[upper], field[lower], is_odd, block.source[:count])
            block.forward()
            self._kernels.to_coefficients(block.target[:count], self._phases, is_odd, found[:, upper], found[:, lower])

        # handed out for all fields at once, which spares two of the five hand-outs of a convolution of the shear
        fields_of = list(zip(fields, odd, coefficients, strict=False))
        self._team.share(transform, [(*one, *rows) for one in fields_of for rows in self._halves])

    def backward(self, coefficients: Fields, odd: Sequence[bool], fields: Fields) -> None:
        """Write the fields (nx, columns) with the `coefficients`, (count, nx)."""

        def transform(member: int, rows: tuple[FloatArray, bool, FloatArray, slice, slice]) -> None:
            values, is_odd, field, upper, lower = rows
            block, count = self._blocks[member], upper.stop - upper.start
            self._kernels.from_coefficients(
                values[:, upper], values[:, lower], self._phases, is_odd, block.target[:count]
            )
            block.backward()
            self._kernels.unfold_rows(block.source[:count], is_odd, field[upper], field[lower])

        fields_of = list(zip(coefficients, odd, fields, strict=False))
        self._team.share(transform, [(*one, *rows) for one in fields_of for rows in self._halves])
