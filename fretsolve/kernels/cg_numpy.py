"""Kernels of the conjugate gradients in NumPy. They work on blocks of rows that stay in cache.

Fields are (k, nx, ny) with one or two components, planes (nx, ny), constraints c (m, k, nx, ny), their amplitudes m and
moments (m,). The symbols T, S, W, c, m, the steps CG1 to CG6 and the equations (T6) to (T9) are in docs/theory.md.
`normal` and `stiffness` are used for two components only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fretsolve.system.arrays import BoolArray, FloatArray

BLOCK_BYTES = 100 * 1024
"""Size of a block of one plane."""


def finish_search(
    image: FloatArray,
    residual: FloatArray,
    weight: FloatArray,
    normal: FloatArray,
    constraints: FloatArray,
    moments: FloatArray,
) -> float:
    """Compute ``image = T (W image + (1 - W^2) W residual)`` (T7) and ``moments = c' image`` (CG2).

    Return the product of the image with `residual`.
    """
    product = 0.0
    moments[:] = 0.0
    for rows in _blocks(weight):
        block, w = image[:, rows], weight[rows]
        block *= w
        if len(image) == 2:
            diagonal = (1.0 - w * w) * w
            for part, of_residual in zip(block, residual[:, rows], strict=True):
                part += diagonal * of_residual
            _take_tangential(block, normal[:, rows])
        product += _product(residual[:, rows], block)
        moments += [_product(constraint[:, rows], block) for constraint in constraints]
    return product


def turn(
    direction: FloatArray,
    image: FloatArray,
    weight: FloatArray,
    constraints: FloatArray,
    amplitudes: FloatArray,
    growth: float,
) -> None:
    """Compute ``image -= W c m`` (T9) and ``direction = growth direction + image`` (CG3)."""
    for rows in _blocks(weight):
        block = image[:, rows]
        for constraint, amplitude in zip(constraints, amplitudes, strict=True):
            block -= float(amplitude) * weight[rows] * constraint[:, rows]
        direction[:, rows] *= growth
        direction[:, rows] += block


def finish_image(
    image: FloatArray,
    direction: FloatArray,
    stiffness: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
    constraints: FloatArray,
    moments: FloatArray,
) -> float:
    """Compute ``image = T (image + S direction)`` in the zone, 0 outside, and ``moments = c' W image`` (CG4).

    Return the product of the image with `direction`. If that is 0, the image is T image.
    """
    product = 0.0
    moments[:] = 0.0
    for rows in _blocks(weight):
        block = image[:, rows]
        if len(image) == 2:
            block += stiffness[rows] * direction[:, rows]
            _take_tangential(block, normal[:, rows])
        np.copyto(block, 0.0, where=~zone[rows])
        product += _product(direction[:, rows], block)
        weighted = weight[rows] * block
        moments += [_product(constraint[:, rows], weighted) for constraint in constraints]
    return product


def advance(
    solution: FloatArray,
    residual: FloatArray,
    direction: FloatArray,
    image: FloatArray,
    constraints: FloatArray,
    amplitudes: FloatArray,
    length: float,
) -> float:
    """Compute ``solution += length direction`` and ``residual -= length (image - c m)`` (CG5).

    Return the largest length of the residual in a cell.
    """
    largest = 0.0
    for rows in _blocks(solution[0]):
        solution[:, rows] += length * direction[:, rows]
        block = residual[:, rows]
        block -= length * image[:, rows]
        for constraint, amplitude in zip(constraints, amplitudes, strict=True):
            block += float(length * amplitude) * constraint[:, rows]
        largest = float(np.maximum(largest, np.einsum("kij,kij->ij", block, block).max()))  # keeps a NaN
    return math.sqrt(largest)


def weigh_moments(field: FloatArray, weight: FloatArray, constraints: FloatArray, moments: FloatArray) -> None:
    """Compute ``moments = c' W field`` (T9)."""
    moments[:] = 0.0
    for rows in _blocks(weight):
        weighted = weight[rows] * field[:, rows]
        moments += [_product(constraint[:, rows], weighted) for constraint in constraints]


def add(field: FloatArray, change: FloatArray, factor: float) -> None:
    """Compute ``field += factor change``, in the precision of `field`."""
    for rows in _blocks(field[0]):
        field[:, rows] += np.multiply(change[:, rows], factor, dtype=field.dtype)


def largest(field: FloatArray) -> float:
    """Return the largest absolute value, or NaN if there is one."""
    return float(np.maximum(field.max(), -field.min()))


def _blocks(plane: NDArray[np.generic]) -> Iterator[slice]:
    rows = max(1, BLOCK_BYTES // max(1, plane.shape[1] * plane.itemsize))
    for start in range(0, plane.shape[0], rows):
        yield slice(start, start + rows)


def _take_tangential(block: FloatArray, normal: FloatArray) -> None:
    along = block[0] * normal[0]
    along += block[1] * normal[1]
    for part, direction in zip(block, normal, strict=True):
        part -= along * direction


def _product(first: FloatArray, second: FloatArray) -> float:
    return sum(float(np.vdot(a, b)) for a, b in zip(first, second, strict=True))
