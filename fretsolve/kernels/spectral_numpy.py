"""Products of spectra with kernels in NumPy.

Fields and results are complex (n, m); kernels are real and hold the non-negative wave numbers along the last axis,
(n, m//2 + 1): the negative ones are mirrored, with a change of sign where the kernel is odd.
"""

from __future__ import annotations

import numpy as np

from fretsolve.system.arrays import ComplexArray, FloatArray


def join_rows(upper: FloatArray, lower: FloatArray, lines: ComplexArray) -> None:
    """``lines = upper + i lower``, (r, m), filled up with zeros; upper: (r, ny), lower: as many rows or one less."""
    ny = upper.shape[1]
    lines[:] = 0.0
    lines.real[:, :ny] = upper
    lines.imag[: len(lower), :ny] = lower


def split_rows(lines: ComplexArray, upper: FloatArray, lower: FloatArray) -> None:
    """The real parts of `lines` (r, m) become `upper` (r, ny), the imaginary ones `lower`."""
    ny = upper.shape[1]
    upper[:] = lines.real[:, :ny]
    lower[:] = lines.imag[: len(lower), :ny]


def split_spectra(lines: ComplexArray, upper: ComplexArray, lower: ComplexArray) -> None:
    """Spectra (r, m//2 + 1) of two real rows from that of the one plus i times the other, (r, m)."""
    columns, count = upper.shape[1], len(lower)
    plain, mirrored = lines[:, 1:columns], lines[:, : lines.shape[1] - columns : -1]
    np.conjugate(mirrored, out=upper[:, 1:])
    np.subtract(plain[:count], upper[:count, 1:], out=lower[:, 1:])
    lower[:, 1:] *= -0.5j
    upper[:, 1:] += plain
    upper[:, 1:] *= 0.5
    upper[:, 0], lower[:, 0] = lines[:, 0].real, lines[:count, 0].imag


def join_spectra(upper: ComplexArray, lower: ComplexArray, lines: ComplexArray) -> None:
    """The inverse of `split_spectra`; what is not real of wave numbers that stand for both signs is left out."""
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
    """The columns of `spectrum` (nx, n) become `lines` (n, mx), filled up with zeros."""
    nx = len(spectrum)
    lines[:, :nx] = spectrum.T
    lines[:, nx:] = 0.0


def give_columns(lines: ComplexArray, spectrum: ComplexArray) -> None:
    """The first nx numbers of `lines` (n, mx) become the columns of `spectrum` (nx, n)."""
    spectrum[:] = lines[:, : len(spectrum)].T


def multiply(kernel: FloatArray, odd: bool, field: ComplexArray, result: ComplexArray) -> None:
    """``result = kernel field``; `result` may be the field."""
    half = kernel.shape[1]
    np.multiply(field[:, :half], kernel, out=result[:, :half])
    mirrored = kernel[:, field.shape[1] - half : 0 : -1]
    np.multiply(field[:, half:], mirrored, out=result[:, half:])
    if odd:
        np.negative(result[:, half:], out=result[:, half:])


def multiply_pair(
    kernels: tuple[FloatArray, FloatArray, FloatArray],
    odd: bool,
    fields: tuple[ComplexArray, ComplexArray],
    results: tuple[ComplexArray, ComplexArray],
    products: tuple[ComplexArray, ComplexArray],
) -> None:
    """Two results of two fields by the symmetric matrix of kernels (xx, yy, xy), `odd` that of xy.

    products: room for the size of a field, used up; `results` may be the fields.
    """
    direct_x, direct_y, mixed = kernels
    from_x, from_y = products
    multiply(mixed, odd, fields[0], from_x)
    multiply(mixed, odd, fields[1], from_y)
    for direct, field, result, other in zip((direct_x, direct_y), fields, results, (from_y, from_x), strict=True):
        multiply(direct, False, field, result)
        result += other


def multiply_coupled(
    direct: tuple[FloatArray, FloatArray, FloatArray],
    mixed: tuple[FloatArray, FloatArray, FloatArray],
    odd: tuple[bool, bool, bool],
    fields: tuple[ComplexArray, ComplexArray, ComplexArray],
) -> None:
    """In place, three results (z, x, y) of three fields by the symmetric matrix of kernels (zz, xx, yy; zx, zy, xy).

    odd: those of `mixed`.
    """
    results = [np.empty_like(field) for field in fields]
    for kernel, field, result in zip(direct, fields, results, strict=True):
        multiply(kernel, False, field, result)
    room = np.empty_like(fields[0])
    for kernel, is_odd, pair in zip(mixed, odd, ((0, 1), (0, 2), (1, 2)), strict=True):
        for source, target in (pair, pair[::-1]):
            multiply(kernel, is_odd, fields[source], room)
            results[target] += room
    for field, result in zip(fields, results, strict=True):
        field[...] = result
