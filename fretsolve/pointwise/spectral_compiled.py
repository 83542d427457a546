"""Products of spectra with kernels compiled by numba; see `fretsolve.pointwise.spectral_plain`."""

from __future__ import annotations

from typing import Any

from fretsolve.pointwise.compiling import kernel as compiled_kernel

TILE = 8
"""Lines and columns that change places at a time: in double precision 8 complex numbers are two lines of cache."""


@compiled_kernel
def take_columns(spectrum: Any, lines: Any) -> None:
    rows, columns = spectrum.shape
    whole_rows, whole_columns = rows // TILE * TILE, columns // TILE * TILE
    for first in range(0, whole_columns, TILE):
        for start in range(0, whole_rows, TILE):
            for j in range(TILE):
                for i in range(TILE):
                    lines[first + j, start + i] = spectrum[start + i, first + j]
    for j in range(whole_columns, columns):
        for i in range(whole_rows):
            lines[j, i] = spectrum[i, j]
    for i in range(whole_rows, rows):
        for j in range(columns):
            lines[j, i] = spectrum[i, j]
    lines[:, rows:] = 0.0


@compiled_kernel
def give_columns(lines: Any, spectrum: Any) -> None:
    rows, columns = spectrum.shape
    whole_rows, whole_columns = rows // TILE * TILE, columns // TILE * TILE
    for start in range(0, whole_rows, TILE):
        for first in range(0, whole_columns, TILE):
            for i in range(TILE):
                for j in range(TILE):
                    spectrum[start + i, first + j] = lines[first + j, start + i]
    for i in range(whole_rows, rows):
        for j in range(whole_columns):
            spectrum[i, j] = lines[j, i]
    for j in range(whole_columns, columns):
        for i in range(rows):
            spectrum[i, j] = lines[j, i]


@compiled_kernel
def multiply(kernel: Any, odd: bool, field: Any, result: Any) -> None:
    lines, length = field.shape
    half = kernel.shape[1]
    one = kernel.dtype.type(1.0)
    sign = -one if odd else one
    for n in range(lines):
        for i in range(half):
            result[n, i] = field[n, i] * kernel[n, i]
        for i in range(half, length):
            result[n, i] = field[n, i] * (sign * kernel[n, length - i])


@compiled_kernel
def multiply_pair(kernels: Any, odd: bool, fields: Any, results: Any, products: Any) -> None:
    direct_x, direct_y, mixed = kernels
    field_x, field_y = fields
    result_x, result_y = results
    lines, length = field_x.shape
    half = mixed.shape[1]
    one = mixed.dtype.type(1.0)
    sign = -one if odd else one
    for n in range(lines):
        for i in range(half):
            x, y, across = field_x[n, i], field_y[n, i], mixed[n, i]
            result_x[n, i] = x * direct_x[n, i] + y * across
            result_y[n, i] = x * across + y * direct_y[n, i]
        for i in range(half, length):
            x, y, across = field_x[n, i], field_y[n, i], sign * mixed[n, length - i]
            result_x[n, i] = x * direct_x[n, length - i] + y * across
            result_y[n, i] = x * across + y * direct_y[n, length - i]


@compiled_kernel
def multiply_coupled(direct: Any, mixed: Any, odd: Any, fields: Any) -> None:
    direct_z, direct_x, direct_y = direct
    mixed_zx, mixed_zy, mixed_xy = mixed
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
