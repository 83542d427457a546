"""Passes of the conjugate gradients over the fields, which `fretsolve.contact.kernels.cg_steps` puts together.

Fields are (k, nx, ny) with one or two components, planes (nx, ny), constraints c (m, k, nx, ny). The symbols T, S, W,
V, D, P (there Pi), c, the steps CG1 to CG6 and the equations (T6) to (T9) are in docs/theory.md. `normal` and
`stiffness` are used for two components only.

Loops are over the rows `first` to `stop`. Sums along a row are in the precision of the arrays, sums over rows in double
precision.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.elastic.kernels.compiling import compiled, inlined, larger, largest_of
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, Products

MIDDLE = 1.7
"""The f of (T7). Mode I.3 takes 4 % fewer applications on 64 x 64 points than with M = W F W + (1 - W^2) W, and 8 %
fewer on 256 x 256. No shipped case takes over 1 % more; with f = 1 cases with wear take up to 8 % more."""


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


@compiled
def constrain_loops(first, stop, constraints, motions, x, y, normal, zone, weight):
    _, components, _, ny = constraints.shape
    gram = np.zeros((3, 3))
    for m in range(len(motions)):
        constraint, a, b, c = constraints[m], motions[m, 0], motions[m, 1], motions[m, 2]
        for i in range(first, stop):
            for j in range(ny):
                inside = 1.0 if zone[i, j] else 0.0
                if components == 1:
                    constraint[0, i, j] = inside * (a + b * y[j] + c * x[i])
                else:
                    n_x, n_y = normal[0, i, j], normal[1, i, j]
                    c_x, c_y = inside * (a - c * y[j]), inside * (b + c * x[i])
                    along = c_x * n_x + c_y * n_y
                    constraint[0, i, j], constraint[1, i, j] = c_x - along * n_x, c_y - along * n_y
        for i in range(first, stop):
            _add_moments(constraint, i, weight[i], constraints[: m + 1], gram[m, : m + 1])
    return (
        (gram[0, 0], gram[1, 0], gram[2, 0]),
        (gram[1, 0], gram[1, 1], gram[2, 1]),
        (gram[2, 0], gram[2, 1], gram[2, 2]),
    )


def clear(solution: FloatArray, displacement: FloatArray, direction: FloatArray, image: FloatArray) -> None:
    """Compute ``solution = displacement = direction = image = 0`` (CG1)."""
    solution[:], displacement[:], direction[:], image[:] = 0.0, 0.0, 0.0, 0.0


@inlined
def clear_loops(first, stop, solution, displacement, direction, image):
    components, _, ny = image.shape
    for part in range(components):
        for i in range(first, stop):
            for j in range(ny):
                solution[part, i, j], displacement[part, i, j] = 0.0, 0.0
                direction[part, i, j], image[part, i, j] = 0.0, 0.0


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


@inlined
def precondition_loops(first, stop, image, residual, weight, normal, constraints):
    components, _, ny = image.shape
    number = image.dtype.type
    zero, one, middle, half = number(0.0), number(1.0), number(MIDDLE), number(MIDDLE / 2)
    unweighted = np.ones(ny, image.dtype)
    product, moments = 0.0, np.zeros(len(constraints))
    for i in range(first, stop):
        in_row = zero
        if components == 1:
            for j in range(ny):
                value = image[0, i, j] * weight[i, j]
                image[0, i, j] = value
                in_row += residual[0, i, j] * value
        else:
            for j in range(ny):
                w, n_x, n_y = weight[i, j], normal[0, i, j], normal[1, i, j]
                v = w / (w + half * (one - w))
                d = middle * w / (w + middle * (one - w)) * (one - v) * (one - v)
                r_x, r_y = residual[0, i, j], residual[1, i, j]
                x, y = image[0, i, j] * v + d * r_x, image[1, i, j] * v + d * r_y
                along = x * n_x + y * n_y
                x -= n_x * along
                y -= n_y * along
                image[0, i, j], image[1, i, j] = x, y
                in_row += r_x * x + r_y * y
        product += in_row
        _add_moments(image, i, unweighted, constraints, moments)
    return product, moments


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


@inlined
def turn_loops(first, stop, direction, image, weight, constraints, amplitudes, growth):
    components, _, ny = image.shape
    factor = image.dtype.type(growth)
    for part in range(components):
        for i in range(first, stop):
            for m in range(len(amplitudes)):
                amplitude = image.dtype.type(amplitudes[m])
                for j in range(ny):
                    image[part, i, j] -= amplitude * weight[i, j] * constraints[m, part, i, j]
            for j in range(ny):
                direction[part, i, j] = factor * direction[part, i, j] + image[part, i, j]


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


@inlined
def apply_loops(first, stop, moved, image, direction, stiffness, normal, zone, weight, constraints):
    components, _, ny = image.shape
    zero = image.dtype.type(0.0)
    product, moments = 0.0, np.zeros(len(constraints))
    for i in range(first, stop):
        in_row = zero
        if components == 1:
            for j in range(ny):
                value = moved[0, i, j] if zone[i, j] else zero
                image[0, i, j] = value
                in_row += direction[0, i, j] * value
        else:
            for j in range(ny):
                n_x, n_y, s = normal[0, i, j], normal[1, i, j], stiffness[i, j]
                d_x, d_y = direction[0, i, j], direction[1, i, j]
                x, y = moved[0, i, j] + s * d_x, moved[1, i, j] + s * d_y
                along = x * n_x + y * n_y
                inside = zone[i, j]
                x = x - n_x * along if inside else zero
                y = y - n_y * along if inside else zero
                image[0, i, j], image[1, i, j] = x, y
                in_row += d_x * x + d_y * y
        product += in_row
        _add_moments(image, i, weight[i], constraints, moments)
    return product, moments


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


@inlined
def advance_loops(first, stop, solution, residual, direction, image, weight, constraints, amplitudes, length):
    components, _, ny = image.shape
    number = image.dtype.type
    step, one, half = number(length), number(1.0), number(MIDDLE / 2)
    squares = np.zeros(ny, image.dtype)
    for i in range(first, stop):
        for part in range(components):
            for j in range(ny):
                solution[part, i, j] += step * direction[part, i, j]
                residual[part, i, j] -= step * image[part, i, j]
            for m in range(len(amplitudes)):
                amplitude = image.dtype.type(length * amplitudes[m])
                for j in range(ny):
                    residual[part, i, j] += amplitude * constraints[m, part, i, j]
            if components == 1:  # W is 0 or 1, and so is V
                for j in range(ny):
                    image[part, i, j] = weight[i, j] * residual[part, i, j]
            else:
                for j in range(ny):
                    w = weight[i, j]
                    image[part, i, j] = w / (w + half * (one - w)) * residual[part, i, j]
        for j in range(ny):
            squared = residual[0, i, j] * residual[0, i, j]
            if components == 2:
                squared += residual[1, i, j] * residual[1, i, j]
            squares[j] = larger(squared, squares[j])
    return math.sqrt(largest_of(squares))


def divide(field: FloatArray, size: float, result: FloatArray) -> float:
    """Compute ``result = field / size``, in its precision, and return the sum of its absolute values."""
    np.divide(field, size, out=result, casting="same_kind")
    return float(np.abs(result).sum(dtype=np.float64))


@inlined
def divide_loops(first, stop, field, size, result):
    components, _, ny = field.shape
    total = 0.0
    for part in range(components):
        for i in range(first, stop):
            in_row = 0.0
            for j in range(ny):
                value = field[part, i, j] / size
                result[part, i, j] = value
                in_row += abs(value)
            total += in_row
    return total


def add(field: FloatArray, change: FloatArray, factor: float) -> None:
    """Compute ``field += factor change``, in the precision of `field`."""
    field += np.multiply(change, factor, dtype=field.dtype)


@compiled
def add_loops(first, stop, field, change, factor):
    components, _, ny = field.shape
    for part in range(components):
        for i in range(first, stop):
            for j in range(ny):
                field[part, i, j] += factor * change[part, i, j]


def largest(field: FloatArray) -> float:
    """Return the largest absolute value, or NaN if there is one."""
    return float(np.maximum(field.max(), -field.min()))


@inlined
def largest_loops(first, stop, field):
    components, _, ny = field.shape
    found = np.zeros(ny, field.dtype)
    for part in range(components):
        for i in range(first, stop):
            for j in range(ny):
                found[j] = larger(abs(field[part, i, j]), found[j])
    return largest_of(found)


def _share(weight: FloatArray, field: FloatArray) -> FloatArray:
    """Return V for a field; with one component W is 0 or 1, and so is V."""
    return weight if len(field) == 1 else share(weight)


def _take_tangential(block: FloatArray, normal: FloatArray) -> None:
    along = block[0] * normal[0]
    along += block[1] * normal[1]
    for part, direction in zip(block, normal, strict=True):
        part -= along * direction


def _product(first: FloatArray, second: FloatArray) -> float:
    """Return the product of two fields; sums of a component in their precision, then in double precision."""
    return sum(float(np.vdot(a, b)) for a, b in zip(first, second, strict=True))


def _moments(field: FloatArray, constraints: FloatArray) -> DoubleArray:
    return np.array([_product(constraint, field) for constraint in constraints])


@inlined
def _add_moments(field, i, weight, constraints, moments):
    for m in range(len(moments)):
        moment = field.dtype.type(0.0)
        for part in range(len(field)):
            for j in range(len(weight)):
                moment += constraints[m, part, i, j] * weight[j] * field[part, i, j]
        moments[m] += moment


def share(weight: FloatArray) -> FloatArray:
    """Return V from W (T9)."""
    result: FloatArray = 1.0 - weight
    result *= 0.5 * MIDDLE
    result += weight
    np.divide(weight, result, out=result)
    return result


def diagonal(weight: FloatArray, share: FloatArray) -> FloatArray:
    """Return D from W and V. As a difference, f / (1 + f S) - f V^2, it would be negative by rounding near W = 1."""
    return MIDDLE * weight / (weight + MIDDLE * (1.0 - weight)) * (1.0 - share) ** 2
