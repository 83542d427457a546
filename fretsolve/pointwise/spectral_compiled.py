"""Products of spectra with kernels compiled by numba; see `fretsolve.pointwise.spectral_plain`."""

from __future__ import annotations

from typing import Any

from fretsolve.pointwise.compiling import kernel as compiled_kernel


@compiled_kernel
def multiply(kernel: Any, odd: bool, field: Any, result: Any) -> None:
    """As `fretsolve.pointwise.spectral_plain.multiply`."""
    rows, columns = field.shape
    half = kernel.shape[0]
    one = kernel.dtype.type(1.0)
    for i in range(rows):
        mirrored = i if i < half else rows - i
        sign = -one if odd and i >= half else one
        for j in range(columns):
            result[i, j] = field[i, j] * (sign * kernel[mirrored, j])


@compiled_kernel
def multiply_pair(kernels: Any, odd: bool, fields: Any, results: Any, products: Any) -> None:
    """As `fretsolve.pointwise.spectral_plain.multiply_pair`."""
    direct_x, direct_y, mixed = kernels
    field_x, field_y = fields
    result_x, result_y = results
    rows, columns = field_x.shape
    half = mixed.shape[0]
    one = mixed.dtype.type(1.0)
    for i in range(rows):
        mirrored = i if i < half else rows - i
        sign = -one if odd and i >= half else one
        for j in range(columns):
            x, y = field_x[i, j], field_y[i, j]
            across = sign * mixed[mirrored, j]
            result_x[i, j] = x * direct_x[mirrored, j] + y * across
            result_y[i, j] = x * across + y * direct_y[mirrored, j]


@compiled_kernel
def multiply_coupled(direct: Any, mixed: Any, odd: Any, fields: Any) -> None:
    """As `fretsolve.pointwise.spectral_plain.multiply_coupled`."""
    direct_z, direct_x, direct_y = direct
    mixed_zx, mixed_zy, mixed_xy = mixed
    field_z, field_x, field_y = fields
    rows, columns = field_z.shape
    half = direct_z.shape[0]
    one = direct_z.dtype.type(1.0)
    for i in range(rows):
        mirrored = i if i < half else rows - i
        sign_zx = -one if odd[0] and i >= half else one
        sign_zy = -one if odd[1] and i >= half else one
        sign_xy = -one if odd[2] and i >= half else one
        for j in range(columns):
            z, x, y = field_z[i, j], field_x[i, j], field_y[i, j]
            zx, zy = sign_zx * mixed_zx[mirrored, j], sign_zy * mixed_zy[mirrored, j]
            xy = sign_xy * mixed_xy[mirrored, j]
            field_z[i, j] = z * direct_z[mirrored, j] + x * zx + y * zy
            field_x[i, j] = z * zx + x * direct_x[mirrored, j] + y * xy
            field_y[i, j] = z * zy + x * xy + y * direct_y[mirrored, j]
