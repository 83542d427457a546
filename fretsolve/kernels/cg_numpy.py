"""Passes of the conjugate gradients over some rows, in NumPy. `fretsolve.kernels.on_grid.Steps` puts them together.

Fields are (k, nx, ny) with one or two components, planes (nx, ny), constraints c (m, k, nx, ny). The symbols T, S, W,
V, D, P (there Pi), c, the steps CG1 to CG6 and the equations (T6) to (T9) are in docs/theory.md. `normal` and
`stiffness` are used for two components only.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.kernels.preconditioning import diagonal, share
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, Products


def constrain(
    constraints: FloatArray,
    motions: DoubleArray,
    x: FloatArray,
    y: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
) -> Products:
    """Compute ``c = T N`` in the zone, 0 outside, and return ``c' W c``, 3 x 3, with 0 beyond m x m (T9).

    motions: amplitudes (a, b, c) of each of the rigid motions N, (m, 3): with one component a + b y + c x, with two
    (a - c y, b + c x).
    """
    gram = np.zeros((3, 3))
    for m, (constraint, (a, b, c)) in enumerate(zip(constraints, motions.tolist(), strict=True)):
        if len(constraint) == 1:
            np.add(a + b * y, (c * x)[:, None], out=constraint[0], casting="same_kind")
        else:
            constraint[0], constraint[1] = a - c * y, (b + c * x)[:, None]
            _take_tangential(constraint, normal)
        constraint *= zone
        gram[m, : m + 1] = gram[: m + 1, m] = _moments(constraint * weight, constraints[: m + 1])
    (aa, ab, ac), (_, bb, bc), (_, _, cc) = gram.tolist()
    return (aa, ab, ac), (ab, bb, bc), (ac, bc, cc)


def clear(solution: FloatArray, displacement: FloatArray, direction: FloatArray, image: FloatArray) -> None:
    """Compute ``solution = displacement = direction = image = 0`` (CG1)."""
    solution[:], displacement[:], direction[:], image[:] = 0.0, 0.0, 0.0, 0.0


def precondition(
    image: FloatArray, residual: FloatArray, weight: FloatArray, normal: FloatArray, constraints: FloatArray
) -> tuple[float, DoubleArray]:
    """Compute ``z = T (V image + D residual)`` (T7) in place of the image (CG2).

    Return its product with `residual` and ``c' z``.
    """
    factor = _share(weight, image)
    image *= factor
    if len(image) == 2:
        image += diagonal(weight, factor) * residual
        _take_tangential(image, normal)
    return _product(residual, image), _moments(image, constraints)


def turn(
    direction: FloatArray,
    image: FloatArray,
    weight: FloatArray,
    constraints: FloatArray,
    amplitudes: FloatArray,
    growth: float,
) -> None:
    """Compute ``direction = growth direction + image - W c amplitudes`` (CG3); the image is overwritten."""
    for constraint, amplitude in zip(constraints, amplitudes.tolist(), strict=True):
        image -= amplitude * weight * constraint
    direction *= growth
    direction += image


def apply(
    moved: FloatArray,
    image: FloatArray,
    direction: FloatArray,
    stiffness: FloatArray,
    normal: FloatArray,
    zone: BoolArray,
    weight: FloatArray,
    constraints: FloatArray,
) -> tuple[float, DoubleArray]:
    """Compute ``image = w = T (moved + S direction)`` in the zone, 0 outside (CG4).

    moved: B times the direction, which may be the array of the image.
    Return its product with `direction` and ``c' W w``.
    """
    if image is not moved:
        np.copyto(image, moved)
    if len(image) == 2:
        image += stiffness * direction
        _take_tangential(image, normal)
    np.copyto(image, 0.0, where=~zone)
    moments = _moments(weight * image, constraints) if len(constraints) else np.zeros(0)
    return _product(direction, image), moments


def advance(
    solution: FloatArray,
    residual: FloatArray,
    direction: FloatArray,
    image: FloatArray,
    weight: FloatArray,
    constraints: FloatArray,
    amplitudes: FloatArray,
    length: float,
) -> float:
    """Compute ``solution += length direction``, ``residual -= length (image - c amplitudes)``, ``image = V residual``.

    Return the largest length of the residual in a cell (CG5).
    """
    solution += length * direction
    residual -= length * image
    for constraint, amplitude in zip(constraints, amplitudes.tolist(), strict=True):
        residual += length * amplitude * constraint
    np.multiply(residual, _share(weight, image), out=image)
    return math.sqrt(np.einsum("kij,kij->ij", residual, residual).max())


def divide(field: FloatArray, size: float, result: FloatArray) -> float:
    """Compute ``result = field / size``, in its precision, and return the sum of its absolute values."""
    np.divide(field, size, out=result, casting="same_kind")
    return float(np.abs(result).sum(dtype=np.float64))


def add(field: FloatArray, change: FloatArray, factor: float) -> None:
    """Compute ``field += factor change``, in the precision of `field`."""
    field += np.multiply(change, factor, dtype=field.dtype)


def largest(field: FloatArray) -> float:
    """Return the largest absolute value, or NaN if there is one."""
    return float(np.maximum(field.max(), -field.min()))


def _share(weight: FloatArray, field: FloatArray) -> FloatArray:
    """Return V for a field; with one component W is 0 or 1, and so is V."""
    return weight if len(field) == 1 else share(weight)


def _take_tangential(block: FloatArray, normal: FloatArray) -> None:
    """Take the part along `normal` away from a block."""
    along = block[0] * normal[0]
    along += block[1] * normal[1]
    for part, direction in zip(block, normal, strict=True):
        part -= along * direction


def _product(first: FloatArray, second: FloatArray) -> float:
    """Return the product of two fields; sums of a component in their precision, then in double precision."""
    return sum(float(np.vdot(a, b)) for a, b in zip(first, second, strict=True))


def _moments(field: FloatArray, constraints: FloatArray) -> DoubleArray:
    """Return the product of the field with each of the constraints."""
    return np.array([_product(constraint, field) for constraint in constraints])
