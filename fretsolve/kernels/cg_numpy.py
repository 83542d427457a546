"""Kernels of the conjugate gradients in NumPy. They work on blocks of rows that stay in cache.

Fields are (k, nx, ny) with one or two components, planes (nx, ny), constraints c (m, k, nx, ny); inverse_gram is
(c' W c)^-1, (m, m). The symbols T, S, W, P (there Pi), c, the steps CG1 to CG6 and the equations (T6) to (T9) are in
docs/theory.md. `normal` and `stiffness` are used for two components only. A whole step is one call: on small grids
calls take longer than what they compute.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

BLOCK_BYTES = 100 * 1024
"""Size of a block of one plane."""


def constrain(
    constraints: FloatArray,
    motions: DoubleArray,
    x: FloatArray,
    y: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
    gram: FloatArray,
) -> None:
    """Compute ``c = T N`` in the zone, 0 outside, and ``gram = c' W c``, (m, m) (T9).

    motions: amplitudes (a, b, c) of each of the rigid motions N, (m, 3): with one component a + b y + c x, with two
    (a - c y, b + c x). Each is divided by its largest value.
    """
    for m, (constraint, (a, b, c)) in enumerate(zip(constraints, motions.tolist(), strict=True)):
        if len(constraint) == 1:
            np.add(a + b * y, (c * x)[:, None], out=constraint[0], casting="same_kind")
        else:
            constraint[0], constraint[1] = a - c * y, (b + c * x)[:, None]
        constraint /= largest(constraint) or 1.0
        if len(constraint) == 2:
            _take_tangential(constraint, normal)
        constraint *= zone
        gram[m, : m + 1] = gram[: m + 1, m] = _moments(constraint * weight, constraints[: m + 1])


def start(
    solution: FloatArray,
    direction: FloatArray,
    residual: FloatArray,
    image: FloatArray,
    stiffness: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
    constraints: FloatArray,
    inverse_gram: FloatArray,
) -> float:
    """Compute ``solution = direction = 0``, ``residual = P T residual`` in the zone (T9), ``image = W residual`` (CG1).

    Return the largest length of the residual in a cell.
    """
    solution[:], direction[:], image[:] = 0.0, 0.0, 0.0
    _, moments = _apply(residual, direction, stiffness, normal, zone, weight, constraints)
    return _advance(solution, residual, direction, image, weight, constraints, -(inverse_gram @ moments), 1.0)


def search(
    image: FloatArray,
    direction: FloatArray,
    residual: FloatArray,
    weight: FloatArray,
    normal: FloatArray,
    constraints: FloatArray,
    inverse_gram: FloatArray,
    rho_before: float,
) -> float:
    """Compute ``z = T (W image + (1 - W^2) W residual)`` (T7) and ``direction = P' z + (rho / rho_before) direction``.

    Return rho, the product of z with `residual` (CG2, CG3). If that is not positive, the direction stays. The image is
    overwritten.
    """
    rho, moments = 0.0, np.zeros(len(constraints))
    for rows in _blocks(weight):
        block, w = image[:, rows], weight[rows]
        block *= w
        if len(image) == 2:
            block += (1.0 - w * w) * w * residual[:, rows]
            _take_tangential(block, normal[:, rows])
        rho += _product(residual[:, rows], block)
        moments += _moments(block, constraints[:, :, rows])
    if rho > 0.0:
        _turn(direction, image, weight, constraints, inverse_gram @ moments, rho / rho_before)
    return rho


def step(
    solution: FloatArray,
    residual: FloatArray,
    direction: FloatArray,
    image: FloatArray,
    stiffness: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
    constraints: FloatArray,
    inverse_gram: FloatArray,
    rho: float,
) -> tuple[float, float]:
    """Compute ``w = T (image + S direction)`` in the zone, 0 outside, and step along the direction (CG4, CG5).

    ``solution += alpha direction`` and ``residual -= alpha P w`` (T9), with ``alpha = rho / kappa`` and kappa the
    product of direction and w; then ``image = W residual``. Return kappa and the largest length of the residual in a
    cell. If kappa is not positive, solution and residual stay.
    """
    kappa, moments = _apply(image, direction, stiffness, normal, zone, weight, constraints)
    if not kappa > 0.0:
        return kappa, math.inf
    amplitudes = inverse_gram @ moments
    return kappa, _advance(solution, residual, direction, image, weight, constraints, amplitudes, rho / kappa)


def normalise(field: FloatArray, result: FloatArray) -> float:
    """Compute ``result = field / size``, in its precision, and return the size, the field's largest absolute value.

    If that is 0, the result is not written.
    """
    size = largest(field)
    if size:
        np.divide(field, size, out=result, casting="same_kind")
    return size


def _apply(
    image: FloatArray,
    direction: FloatArray,
    stiffness: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
    constraints: FloatArray,
) -> tuple[float, DoubleArray]:
    """Compute ``image = T (image + S direction)`` in the zone, 0 outside.

    Return its product with `direction` and ``c' W image``.
    """
    product, moments = 0.0, np.zeros(len(constraints))
    for rows in _blocks(weight):
        block = image[:, rows]
        if len(image) == 2:
            block += stiffness[rows] * direction[:, rows]
            _take_tangential(block, normal[:, rows])
        np.copyto(block, 0.0, where=~zone[rows])
        product += _product(direction[:, rows], block)
        if len(constraints):
            moments += _moments(weight[rows] * block, constraints[:, :, rows])
    return product, moments


def _turn(
    direction: FloatArray,
    image: FloatArray,
    weight: FloatArray,
    constraints: FloatArray,
    amplitudes: FloatArray,
    growth: float,
) -> None:
    """Compute ``direction = growth direction + image - W c amplitudes``; the image is overwritten."""
    for rows in _blocks(weight):
        block = image[:, rows]
        for constraint, amplitude in zip(constraints, amplitudes, strict=True):
            block -= float(amplitude) * weight[rows] * constraint[:, rows]
        direction[:, rows] *= growth
        direction[:, rows] += block


def _advance(
    solution: FloatArray,
    residual: FloatArray,
    direction: FloatArray,
    image: FloatArray,
    weight: FloatArray,
    constraints: FloatArray,
    amplitudes: FloatArray,
    length: float,
) -> float:
    """Compute ``solution += length direction``, ``residual -= length (image - c amplitudes)``, ``image = W residual``.

    Return the largest length of the residual in a cell.
    """
    longest = 0.0
    for rows in _blocks(weight):
        solution[:, rows] += length * direction[:, rows]
        block = residual[:, rows]
        block -= length * image[:, rows]
        for constraint, amplitude in zip(constraints, amplitudes, strict=True):
            block += float(length * amplitude) * constraint[:, rows]
        np.multiply(block, weight[rows], out=image[:, rows])
        longest = float(np.maximum(longest, np.einsum("kij,kij->ij", block, block).max()))  # keeps a NaN
    return math.sqrt(longest)


def add(field: FloatArray, change: FloatArray, factor: float) -> None:
    """Compute ``field += factor change``, in the precision of `field`."""
    for rows in _blocks(field[0]):
        field[:, rows] += np.multiply(change[:, rows], factor, dtype=field.dtype)


def largest(field: FloatArray) -> float:
    """Return the largest absolute value, or NaN if there is one."""
    return float(np.maximum(field.max(), -field.min()))


def _blocks(plane: NDArray[np.generic]) -> Iterator[slice]:
    """Yield slices of rows that fit into the cache together."""
    rows = max(1, BLOCK_BYTES // max(1, plane.shape[1] * plane.itemsize))
    for start in range(0, plane.shape[0], rows):
        yield slice(start, start + rows)


def _take_tangential(block: FloatArray, normal: FloatArray) -> None:
    """Take the part along `normal` away from a block."""
    along = block[0] * normal[0]
    along += block[1] * normal[1]
    for part, direction in zip(block, normal, strict=True):
        part -= along * direction


def _product(first: FloatArray, second: FloatArray) -> float:
    """Return the product of two fields; sums of a component in their precision, then in double precision."""
    return sum(float(np.vdot(a, b)) for a, b in zip(first, second, strict=True))


def _moments(field: FloatArray, constraints: FloatArray) -> list[float]:
    """Return the product of the field with each of the constraints."""
    return [_product(constraint, field) for constraint in constraints]
