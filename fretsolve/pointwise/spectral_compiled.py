"""Products of spectra with kernels compiled by numba; see `fretsolve.pointwise.spectral_plain`."""

from __future__ import annotations

from typing import Any

from fretsolve.pointwise.compiling import kernel as compiled_kernel


@compiled_kernel
def multiply(kernel: Any, odd: bool, field: Any, result: Any) -> None:
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
