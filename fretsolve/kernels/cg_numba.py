"""Passes of the conjugate gradients over the rows `first` to `stop`, compiled by numba, as those in `cg_numpy`.

`start`, `search`, `step` and `normalise` are whole steps, as in `fretsolve.kernels.on_grid.Steps`, in one call: on
small grids calls take longer than what they compute. Sums along a row are in the precision of the arrays, sums over
rows in double precision.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.kernels.numba_options import inlined, kernel, larger, largest_of
from fretsolve.kernels.preconditioning import MIDDLE


@inlined
def precondition(first, stop, image, residual, weight, normal, constraints):
    """Compute ``image = T (V image + D residual)`` (T7); return residual times image, and c' image."""
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


@inlined
def turn(first, stop, direction, image, weight, constraints, amplitudes, growth):
    """Compute ``direction = growth direction + image - W c amplitudes``; the image is overwritten (CG3)."""
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


@inlined
def apply(first, stop, moved, image, direction, stiffness, normal, zone, weight, constraints):
    """Compute ``image = T (moved + S direction)`` in the zone; return direction times it, and ``c' W image`` (CG4)."""
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


@inlined
def _add_moments(field, i, weight, constraints, moments):
    """Add the moments of row `i`; weight: (ny,)."""
    for m in range(len(moments)):
        moment = field.dtype.type(0.0)
        for part in range(len(field)):
            for j in range(len(weight)):
                moment += constraints[m, part, i, j] * weight[j] * field[part, i, j]
        moments[m] += moment


@inlined
def advance(first, stop, solution, residual, direction, image, weight, constraints, amplitudes, length):
    """Step along the direction (CG5), compute ``image = V residual``, and return the largest length of the residual."""
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


@inlined
def _multiply(matrix, vector):
    """Return a small matrix times a vector."""
    result = np.zeros(len(vector))
    for m in range(len(vector)):
        for n in range(len(vector)):
            result[m] += matrix[m, n] * vector[n]
    return result


@inlined
def clear(first, stop, solution, displacement, direction, image):
    """Compute ``solution = displacement = direction = image = 0`` (CG1)."""
    components, _, ny = image.shape
    for part in range(components):
        for i in range(first, stop):
            for j in range(ny):
                solution[part, i, j], displacement[part, i, j] = 0.0, 0.0
                direction[part, i, j], image[part, i, j] = 0.0, 0.0


@kernel
def constrain(first, stop, constraints, motions, x, y, normal, zone, weight):
    """Compute ``c = T N`` in the zone, 0 outside, and return ``c' W c``, 3 x 3 (T9)."""
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


@kernel
def start(
    solution, displacement, direction, residual, image, stiffness, normal, zone, weight, constraints, inverse_gram
):
    """Begin at 0: compute ``residual = P T residual`` in the zone (T9) and ``image = V residual`` (CG1)."""
    rows = len(weight)
    clear(0, rows, solution, displacement, direction, image)
    _, moments = apply(0, rows, residual, residual, direction, stiffness, normal, zone, weight, constraints)
    amplitudes = _multiply(inverse_gram, moments)
    for m in range(len(amplitudes)):
        amplitudes[m] = -amplitudes[m]
    return advance(0, rows, solution, residual, direction, image, weight, constraints, amplitudes, 1.0)


@kernel
def search(image, direction, residual, weight, normal, constraints, inverse_gram, rho_before):
    """Compute ``z = T (V image + D residual)`` (T7) and turn the direction to it (CG2, CG3); return rho."""
    rows = len(weight)
    rho, moments = precondition(0, rows, image, residual, weight, normal, constraints)
    if rho > 0.0:
        amplitudes = _multiply(inverse_gram, moments)
        turn(0, rows, direction, image, weight, constraints, amplitudes, rho / rho_before)
    return rho


@kernel
def step(
    solution,
    displacement,
    residual,
    direction,
    moved,
    image,
    stiffness,
    normal,
    zone,
    weight,
    constraints,
    inverse_gram,
    rho,
):
    """Compute ``w = T (moved + S direction)`` in the zone, and step along the direction (CG4, CG5)."""
    components, rows, columns = image.shape
    kappa, moments = apply(0, rows, moved, image, direction, stiffness, normal, zone, weight, constraints)
    if not kappa > 0.0:
        return kappa, math.inf
    amplitudes, length = _multiply(inverse_gram, moments), rho / kappa
    alpha = image.dtype.type(length)
    for part in range(components):
        for i in range(rows):
            for j in range(columns):
                displacement[part, i, j] += alpha * moved[part, i, j]
    return kappa, advance(0, rows, solution, residual, direction, image, weight, constraints, amplitudes, length)


@inlined
def largest(first, stop, field):
    """Return the largest absolute value, or NaN if there is one."""
    components, _, ny = field.shape
    found = np.zeros(ny, field.dtype)
    for part in range(components):
        for i in range(first, stop):
            for j in range(ny):
                found[j] = larger(abs(field[part, i, j]), found[j])
    return largest_of(found)


@inlined
def divide(first, stop, field, size, result):
    """Compute ``result = field / size``, and return the sum of its absolute values."""
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


@kernel
def normalise(field, result):
    """Compute ``result = field / size``; return the size, the field's largest absolute value, and the result's sum."""
    rows = field.shape[1]
    size, total = largest(0, rows, field), 0.0
    if size != 0.0:
        total = divide(0, rows, field, size, result)
    return size, total


@kernel
def add(first, stop, field, change, factor):
    """Compute ``field += factor change``."""
    components, _, ny = field.shape
    for part in range(components):
        for i in range(first, stop):
            for j in range(ny):
                field[part, i, j] += factor * change[part, i, j]
