"""Operations on spectra: two real rows in one complex one, transposing, products with kernels.

Fields and results are complex (n, m). Kernels are real and hold the non-negative wave numbers along the last axis,
(n, m//2 + 1); the negative ones are mirrored, with a change of sign if the kernel is odd.
"""

from __future__ import annotations

from itertools import permutations
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.kernels.compiling import compiled, exact, inlined
from fretsolve.system.arrays import ComplexArray, FloatArray

TILE = 8
"""Rows and columns transposed at a time: in double precision 8 complex numbers fill two cache lines. Loops of
this fixed length become vector instructions."""

T = TypeVar("T")
Matrix = tuple[tuple[T, ...], ...]


def join_rows(upper: FloatArray, lower: FloatArray, lines: ComplexArray) -> None:
    """Compute ``lines = upper + i lower``, (r, m), padded with zeros; upper: (r, ny), lower: as many or one less."""
    ny = upper.shape[1]
    lines[:] = 0.0
    lines.real[:, :ny] = upper
    lines.imag[: len(lower), :ny] = lower


@compiled
def join_rows_loops(upper, lower, lines):
    rows, ny = upper.shape
    for r in range(rows):
        if r < lower.shape[0]:
            for j in range(ny):
                lines[r, j] = complex(upper[r, j], lower[r, j])
        else:
            for j in range(ny):
                lines[r, j] = upper[r, j]
        for j in range(ny, lines.shape[1]):  # numba takes seconds to compile an assignment to a slice
            lines[r, j] = 0.0


def split_rows(lines: ComplexArray, upper: FloatArray, lower: FloatArray) -> None:
    """Copy the real parts of `lines` (r, m) to `upper` (r, ny) and the imaginary parts to `lower`."""
    ny = upper.shape[1]
    upper[:] = lines.real[:, :ny]
    lower[:] = lines.imag[: len(lower), :ny]


@compiled
def split_rows_loops(lines, upper, lower):
    rows, ny = upper.shape
    for r in range(rows):
        if r < lower.shape[0]:
            for j in range(ny):  # both in one pass take half the time
                upper[r, j], lower[r, j] = lines[r, j].real, lines[r, j].imag
        else:
            for j in range(ny):
                upper[r, j] = lines[r, j].real


def split_spectra(lines: ComplexArray, upper: ComplexArray, lower: ComplexArray) -> None:
    """Compute the spectra (r, m//2 + 1) of two real rows from the spectrum of upper + i lower, (r, m)."""
    columns, count = upper.shape[1], len(lower)
    plain, mirrored = lines[:, 1:columns], lines[:, : lines.shape[1] - columns : -1]
    np.conjugate(mirrored, out=upper[:, 1:])
    np.subtract(plain[:count], upper[:count, 1:], out=lower[:, 1:])
    lower[:, 1:] *= -0.5j
    upper[:, 1:] += plain
    upper[:, 1:] *= 0.5
    upper[:, 0], lower[:, 0] = lines[:, 0].real, lines[:count, 0].imag


@compiled
def split_spectra_loops(lines, upper, lower):
    rows, columns = upper.shape
    length = lines.shape[1]
    half = upper.real.dtype.type(0.5)
    mirrored = np.empty(columns, lines.dtype)  # the loops below then run forward, in vector instructions
    unused = np.empty(columns, lines.dtype)
    for r in range(rows):
        one, other = upper[r], lower[r] if r < lower.shape[0] else unused
        mirrored[0] = lines[r, 0]
        for k in range(1, columns):
            mirrored[k] = lines[r, length - k]
        for k in range(columns):
            a, b = lines[r, k], mirrored[k]
            one[k] = complex(half * (a.real + b.real), half * (a.imag - b.imag))
            other[k] = complex(half * (a.imag + b.imag), half * (b.real - a.real))


def join_spectra(upper: ComplexArray, lower: ComplexArray, lines: ComplexArray) -> None:
    """Invert `split_spectra`. Imaginary parts at wave numbers that stand for both signs are left out."""
    length, columns, count = lines.shape[1], upper.shape[1], len(lower)
    both = lines[:count]
    lines[count:, :columns] = upper[count:]
    np.multiply(lower, 1j, out=both[:, :columns])
    both[:, :columns] += upper[:count]
    mirrored = slice(length - columns, 0, -1)
    lines[count:, columns:] = upper[count:, mirrored]
    np.multiply(lower[:, mirrored], -1j, out=both[:, columns:])
    both[:, columns:] += upper[:count, mirrored]
    np.conjugate(lines[:, columns:], out=lines[:, columns:])
    for single in {0, length // 2} if length % 2 == 0 else {0}:
        lines.real[:, single] = upper[:, single].real
        lines.imag[count:, single] = 0.0
        both.imag[:, single] = lower[:, single].real


@compiled
def join_spectra_loops(upper, lower, lines):
    rows, columns = upper.shape
    length = lines.shape[1]
    nothing, mirrored = np.zeros(columns, lines.dtype), np.empty(columns, lines.dtype)
    for r in range(rows):
        one, other = upper[r], lower[r] if r < lower.shape[0] else nothing
        for k in range(columns):
            a, b = one[k], other[k]
            lines[r, k] = complex(a.real - b.imag, a.imag + b.real)
            mirrored[k] = complex(a.real + b.imag, b.real - a.imag)
        for k in range(columns, length):
            lines[r, k] = mirrored[length - k]
        # These wave numbers stand for both signs.
        lines[r, 0] = complex(one[0].real, other[0].real)
        if length % 2 == 0:
            lines[r, length // 2] = complex(one[length // 2].real, other[length // 2].real)


def take_columns(spectrum: ComplexArray, lines: ComplexArray) -> None:
    """Copy the columns of `spectrum` (nx, n) to `lines` (n, mx), padded with zeros."""
    nx = len(spectrum)
    lines[:, :nx] = spectrum.T
    lines[:, nx:] = 0.0


@compiled
def take_columns_loops(spectrum, lines):
    rows, columns = spectrum.shape
    _transpose(spectrum, lines, columns, rows)
    for r in range(len(lines)):
        for j in range(rows, lines.shape[1]):
            lines[r, j] = 0.0


def give_columns(lines: ComplexArray, spectrum: ComplexArray) -> None:
    """Copy the first nx numbers of `lines` (n, mx) to the columns of `spectrum` (nx, n)."""
    spectrum[:] = lines[:, : len(spectrum)].T


@compiled
def give_columns_loops(lines, spectrum):
    rows, columns = spectrum.shape
    _transpose(lines, spectrum, rows, columns)


def multiply(kernel: FloatArray, odd: bool, field: ComplexArray, result: ComplexArray) -> None:
    """Compute ``result = kernel field``; `result` may be the field."""
    half = kernel.shape[1]
    np.multiply(field[:, :half], kernel, out=result[:, :half])
    mirrored = kernel[:, field.shape[1] - half : 0 : -1]
    np.multiply(field[:, half:], mirrored, out=result[:, half:])
    if odd:
        np.negative(result[:, half:], out=result[:, half:])


@compiled
def multiply_loops(kernel, odd, field, result):
    lines, length = field.shape
    half = kernel.shape[1]
    one = kernel.dtype.type(1.0)
    sign = -one if odd else one
    for n in range(lines):
        for i in range(half):
            result[n, i] = field[n, i] * kernel[n, i]
        for i in range(half, length):
            result[n, i] = field[n, i] * (sign * kernel[n, length - i])


def multiply_symmetric(kernels: Matrix[FloatArray], odd: Matrix[bool], fields: tuple[ComplexArray, ...]) -> None:
    """Multiply two or three fields, in place, by a symmetric matrix of kernels; `odd` is even on the diagonal."""
    products = []
    for row, column in permutations(range(len(fields)), 2):
        products.append((row, np.empty_like(fields[row])))
        multiply(kernels[row][column], odd[row][column], fields[column], products[-1][1])
    for row, field in enumerate(fields):
        multiply(kernels[row][row], False, field, field)
    for row, product in products:
        field = fields[row]
        field += product


def multiply_symmetric_loops(kernels, odd, fields):
    if len(fields) == 2:
        multiply_pair_loops(kernels[0] + kernels[1], odd[0][1], fields)
    else:
        multiply_triple_loops(kernels[0] + kernels[1] + kernels[2], (odd[0][1], odd[0][2], odd[1][2]), fields)


def combine(
    factors: NDArray[np.inexact],
    spectra: NDArray[np.inexact],
    results: NDArray[np.inexact],
    product: NDArray[np.inexact],
) -> None:
    """Compute ``results = factors spectra``, (m, k) of (m, n, k) and (n, k); product: (m, k), overwritten."""
    np.multiply(factors[:, 0], spectra[0], out=results)
    for column in range(1, len(spectra)):
        np.multiply(factors[:, column], spectra[column], out=product)
        np.add(results, product, out=results)


@exact
def combine_loops(factors, spectra, results, product):
    rows, columns, count = factors.shape
    for row in range(rows):
        if columns == 1:
            for k in range(count):
                results[row, k] = factors[row, 0, k] * spectra[0, k]
        elif columns == 2:
            for k in range(count):
                results[row, k] = factors[row, 0, k] * spectra[0, k] + factors[row, 1, k] * spectra[1, k]
        else:
            for k in range(count):
                sums = factors[row, 0, k] * spectra[0, k] + factors[row, 1, k] * spectra[1, k]
                results[row, k] = sums + factors[row, 2, k] * spectra[2, k]


@inlined
def _transpose(source, target, rows, columns):
    """Copy the transpose of `source` to the first `rows` and `columns` of `target`, by tiles."""
    whole_rows, whole_columns = rows // TILE * TILE, columns // TILE * TILE
    for first in range(0, whole_rows, TILE):
        for start in range(0, whole_columns, TILE):
            for i in range(TILE):
                for j in range(TILE):
                    target[first + i, start + j] = source[start + j, first + i]
    for i in range(whole_rows, rows):
        for j in range(whole_columns):
            target[i, j] = source[j, i]
    for j in range(whole_columns, columns):
        for i in range(rows):
            target[i, j] = source[j, i]


@compiled
def multiply_pair_loops(kernels, odd, fields):
    """Multiply two fields by a symmetric 2 x 2 matrix of kernels, (4, n, half)."""
    direct_x, mixed, _, direct_y = kernels
    field_x, field_y = fields
    lines, length = field_x.shape
    half = mixed.shape[1]
    one = mixed.dtype.type(1.0)
    sign = -one if odd else one
    for n in range(lines):
        for i in range(half):
            x, y, across = field_x[n, i], field_y[n, i], mixed[n, i]
            field_x[n, i] = x * direct_x[n, i] + y * across
            field_y[n, i] = x * across + y * direct_y[n, i]
        for i in range(half, length):
            x, y, across = field_x[n, i], field_y[n, i], sign * mixed[n, length - i]
            field_x[n, i] = x * direct_x[n, length - i] + y * across
            field_y[n, i] = x * across + y * direct_y[n, length - i]


@compiled
def multiply_triple_loops(kernels, odd, fields):
    """Multiply three fields by a symmetric 3 x 3 matrix of kernels, (9, n, half)."""
    direct_z, mixed_zx, mixed_zy, _, direct_x, mixed_xy, _, _, direct_y = kernels
    field_z, field_x, field_y = fields
    lines, length = field_z.shape
    half = direct_z.shape[1]
    one = direct_z.dtype.type(1.0)
    for n in range(lines):
        for i in range(length):
            mirrored = i if i < half else length - i
            sign_zx = -one if odd[0] and i >= half else one
            sign_zy = -one if odd[1] and i >= half else one
            sign_xy = -one if odd[2] and i >= half else one
            z, x, y = field_z[n, i], field_x[n, i], field_y[n, i]
            zx, zy = sign_zx * mixed_zx[n, mirrored], sign_zy * mixed_zy[n, mirrored]
            xy = sign_xy * mixed_xy[n, mirrored]
            field_z[n, i] = z * direct_z[n, mirrored] + x * zx + y * zy
            field_x[n, i] = z * zx + x * direct_x[n, mirrored] + y * xy
            field_y[n, i] = z * zy + x * xy + y * direct_y[n, mirrored]
