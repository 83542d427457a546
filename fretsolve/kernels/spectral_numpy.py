"""Operations on spectra in NumPy: two real rows in one complex one, transposing, products with kernels.

Fields and results are complex (n, m). Kernels are real and hold the non-negative wave numbers along the last axis,
(n, m//2 + 1); the negative ones are mirrored, with a change of sign if the kernel is odd.
"""

from __future__ import annotations

from itertools import permutations
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fretsolve.system.arrays import ComplexArray, FloatArray

T = TypeVar("T")
Matrix = tuple[tuple[T, ...], ...]


def join_rows(upper: FloatArray, lower: FloatArray, lines: ComplexArray) -> None:
    """Compute ``lines = upper + i lower``, (r, m), padded with zeros; upper: (r, ny), lower: as many or one less."""
    ny = upper.shape[1]
    lines[:] = 0.0
    lines.real[:, :ny] = upper
    lines.imag[: len(lower), :ny] = lower


def split_rows(lines: ComplexArray, upper: FloatArray, lower: FloatArray) -> None:
    """Copy the real parts of `lines` (r, m) to `upper` (r, ny) and the imaginary parts to `lower`."""
    ny = upper.shape[1]
    upper[:] = lines.real[:, :ny]
    lower[:] = lines.imag[: len(lower), :ny]


def split_spectra(lines: ComplexArray, upper: ComplexArray, lower: ComplexArray) -> None:
    """Compute the spectra (r, m//2 + 1) of two real rows from that of the upper one plus i times the lower, (r, m)."""
    columns, count = upper.shape[1], len(lower)
    plain, mirrored = lines[:, 1:columns], lines[:, : lines.shape[1] - columns : -1]
    np.conjugate(mirrored, out=upper[:, 1:])
    np.subtract(plain[:count], upper[:count, 1:], out=lower[:, 1:])
    lower[:, 1:] *= -0.5j
    upper[:, 1:] += plain
    upper[:, 1:] *= 0.5
    upper[:, 0], lower[:, 0] = lines[:, 0].real, lines[:count, 0].imag


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


def take_columns(spectrum: ComplexArray, lines: ComplexArray) -> None:
    """Copy the columns of `spectrum` (nx, n) to `lines` (n, mx), padded with zeros."""
    nx = len(spectrum)
    lines[:, :nx] = spectrum.T
    lines[:, nx:] = 0.0


def give_columns(lines: ComplexArray, spectrum: ComplexArray) -> None:
    """Copy the first nx numbers of `lines` (n, mx) to the columns of `spectrum` (nx, n)."""
    spectrum[:] = lines[:, : len(spectrum)].T


def multiply(kernel: FloatArray, odd: bool, field: ComplexArray, result: ComplexArray) -> None:
    """Compute ``result = kernel field``; `result` may be the field."""
    half = kernel.shape[1]
    np.multiply(field[:, :half], kernel, out=result[:, :half])
    mirrored = kernel[:, field.shape[1] - half : 0 : -1]
    np.multiply(field[:, half:], mirrored, out=result[:, half:])
    if odd:
        np.negative(result[:, half:], out=result[:, half:])


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
