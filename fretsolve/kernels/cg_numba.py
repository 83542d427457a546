"""Kernels of the conjugate gradients, compiled by numba. Each does what its namesake in `cg_numpy` does.

Sums along a row are in the precision of the arrays, sums over rows in double precision.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.kernels.numba_options import kernel, larger, largest_of


@kernel
def finish_search(image, residual, weight, normal, constraints, moments):
    components, nx, ny = image.shape
    zero = image.dtype.type(0.0)
    one = image.dtype.type(1.0)
    unweighted = np.ones(ny, image.dtype)
    product = 0.0
    moments[:] = 0.0
    for i in range(nx):
        in_row = zero
        if components == 1:
            for j in range(ny):
                value = image[0, i, j] * weight[i, j]
                image[0, i, j] = value
                in_row += residual[0, i, j] * value
        else:
            for j in range(ny):
                w, n_x, n_y = weight[i, j], normal[0, i, j], normal[1, i, j]
                diagonal = (one - w * w) * w
                r_x, r_y = residual[0, i, j], residual[1, i, j]
                x, y = image[0, i, j] * w + diagonal * r_x, image[1, i, j] * w + diagonal * r_y
                along = x * n_x + y * n_y
                x -= n_x * along
                y -= n_y * along
                image[0, i, j], image[1, i, j] = x, y
                in_row += r_x * x + r_y * y
        product += in_row
        _add_moments(image, i, unweighted, constraints, moments)
    return product


@kernel
def turn(direction, image, weight, constraints, amplitudes, growth):
    components, nx, ny = image.shape
    factor = image.dtype.type(growth)
    for part in range(components):
        for i in range(nx):
            for m in range(len(amplitudes)):
                amplitude = image.dtype.type(amplitudes[m])
                for j in range(ny):
                    image[part, i, j] -= amplitude * weight[i, j] * constraints[m, part, i, j]
            for j in range(ny):
                direction[part, i, j] = factor * direction[part, i, j] + image[part, i, j]


@kernel
def finish_image(image, direction, stiffness, normal, zone, weight, constraints, moments):
    components, nx, ny = image.shape
    zero = image.dtype.type(0.0)
    product = 0.0
    moments[:] = 0.0
    for i in range(nx):
        in_row = zero
        if components == 1:
            for j in range(ny):
                value = image[0, i, j] if zone[i, j] else zero
                image[0, i, j] = value
                in_row += direction[0, i, j] * value
        else:
            for j in range(ny):
                n_x, n_y, s = normal[0, i, j], normal[1, i, j], stiffness[i, j]
                d_x, d_y = direction[0, i, j], direction[1, i, j]
                x, y = image[0, i, j] + s * d_x, image[1, i, j] + s * d_y
                along = x * n_x + y * n_y
                inside = zone[i, j]
                x = x - n_x * along if inside else zero
                y = y - n_y * along if inside else zero
                image[0, i, j], image[1, i, j] = x, y
                in_row += d_x * x + d_y * y
        product += in_row
        _add_moments(image, i, weight[i], constraints, moments)
    return product


@kernel
def _add_moments(field, i, weight, constraints, moments):
    """Add the moments of row `i`; weight: (ny,)."""
    for m in range(len(moments)):
        moment = field.dtype.type(0.0)
        for part in range(len(field)):
            for j in range(len(weight)):
                moment += constraints[m, part, i, j] * weight[j] * field[part, i, j]
        moments[m] += moment


@kernel
def advance(solution, residual, direction, image, constraints, amplitudes, length):
    components, nx, ny = image.shape
    step = image.dtype.type(length)
    squares = np.zeros(ny, image.dtype)
    for i in range(nx):
        for part in range(components):
            for j in range(ny):
                solution[part, i, j] += step * direction[part, i, j]
                residual[part, i, j] -= step * image[part, i, j]
            for m in range(len(amplitudes)):
                amplitude = image.dtype.type(length * amplitudes[m])
                for j in range(ny):
                    residual[part, i, j] += amplitude * constraints[m, part, i, j]
        for j in range(ny):
            squared = residual[0, i, j] * residual[0, i, j]
            if components == 2:
                squared += residual[1, i, j] * residual[1, i, j]
            squares[j] = larger(squared, squares[j])
    return math.sqrt(largest_of(squares))


@kernel
def weigh_moments(field, weight, constraints, moments):
    components, nx, ny = field.shape
    moments[:] = 0.0
    for m in range(len(moments)):
        for part in range(components):
            for i in range(nx):
                in_row = field.dtype.type(0.0)
                for j in range(ny):
                    in_row += constraints[m, part, i, j] * weight[i, j] * field[part, i, j]
                moments[m] += in_row


@kernel
def largest(field):
    components, nx, ny = field.shape
    found = np.zeros(ny, field.dtype)
    for part in range(components):
        for i in range(nx):
            for j in range(ny):
                found[j] = larger(abs(field[part, i, j]), found[j])
    return largest_of(found)


@kernel
def add(field, change, factor):
    components, nx, ny = field.shape
    for part in range(components):
        for i in range(nx):
            for j in range(ny):
                field[part, i, j] += factor * change[part, i, j]
