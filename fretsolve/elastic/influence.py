"""Influence coefficients: surface displacement at a cell's centre from unit traction on another cell.

Sources: Love (1929), Johnson, Contact Mechanics (1985), section 3; Boussinesq and Cerruti point solutions
integrated over a rectangle. Both bodies are summed; the displacement is u2 - u1, in the direction of the
traction on body 2. With A, B, C, E* of `fretsolve.model.materials`:

    uz from p   1/(pi E*) int 1/r
    ux from qx  1/(2 pi)  int (A/r + B x^2/r^3)        uy from qy with y^2
    ux from qy  B/(2 pi)  int x y/r^3                  = uy from qx
    ux from p   C/(4 pi)  int x/r^2                    uz from qx = -(ux from p); y alike

Every integral is even or odd in x and in y, so only the quadrant of offsets x, y >= 0 is ever computed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from fretsolve.system.arrays import DoubleArray

Function = Callable[[DoubleArray, DoubleArray], DoubleArray]

KernelFunction = Callable[[DoubleArray, DoubleArray, float, float], DoubleArray]

QUADRATURE = ((12.0, 0), (30.0, 4), (300.0, 3), (np.inf, 2))
"""(reach in cell sides, Gauss points per side; 0 for corner differences).

Corner differences lose (r/h)^2 of their digits; n Gauss points err by about 2.3e-5 (h/r)^8 for n = 4,
3.6e-4 (h/r)^6 for n = 3 and 5.6e-3 (h/r)^4 for n = 2 of the value: everywhere below 1e-12 on square cells.
"""


def inverse_distance(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Integral of 1/r over cells ``dx`` by ``dy`` at offsets ``x`` (nx,), ``y`` (ny,), both >= 0: (nx, ny)."""
    return _integrate(_inverse_distance_corner, lambda u, v: 1.0 / np.hypot(u, v), x, y, dx, dy)


def along_x(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Integral of x^2/r^3 over the cell; arguments as for `inverse_distance`."""
    return _integrate(_along_x_corner, lambda u, v: u * u / _cubed(u, v), x, y, dx, dy)


def along_y(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Integral of y^2/r^3 over the cell; arguments as for `inverse_distance`."""
    return np.ascontiguousarray(along_x(y, x, dy, dx).T)


def across(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Integral of x y/r^3 over the cell, odd in x and y; arguments as for `inverse_distance`."""
    return _integrate(lambda u, v: -np.hypot(u, v), lambda u, v: u * v / _cubed(u, v), x, y, dx, dy)


def radial_x(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Integral of x/r^2 over the cell, odd in x; arguments as for `inverse_distance`."""
    return _integrate(_radial_x_corner, lambda u, v: u / (u * u + v * v), x, y, dx, dy)


def radial_y(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Integral of y/r^2 over the cell, odd in y; arguments as for `inverse_distance`."""
    return np.ascontiguousarray(radial_x(y, x, dy, dx).T)


def _integrate(
    corner: Function, integrand: Function, x: DoubleArray, y: DoubleArray, dx: float, dy: float
) -> DoubleArray:
    """Corner differences of the antiderivative near the cell, Gauss quadrature of the integrand far away."""
    side = max(dx, dy)
    result = np.empty((x.size, y.size))
    inner = (0, 0)
    for reach, points in QUADRATURE:
        outer = (int(np.searchsorted(x, reach * side)), int(np.searchsorted(y, reach * side)))
        # The ring between two boxes of the quadrant, as two rectangles.
        for rows, columns in (
            (slice(inner[0], outer[0]), slice(0, outer[1])),
            (slice(0, inner[0]), slice(inner[1], outer[1])),
        ):
            if points:
                result[rows, columns] = _gauss(integrand, x[rows], y[columns], dx, dy, points)
            else:
                result[rows, columns] = _corner_differences(corner, x[rows], y[columns], dx, dy)
        inner = outer
    return result


def _corner_differences(corner: Function, x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """F at the four corners of each cell, of alternating sign (exact, but for cancellation far away)."""
    if x.size == 0 or y.size == 0:
        return np.empty((x.size, y.size))
    corners_x = np.append(x - dx / 2, x[-1] + dx / 2)[:, None]
    corners_y = np.append(y - dy / 2, y[-1] + dy / 2)[None, :]
    antiderivative = corner(corners_x, corners_y)
    return np.diff(np.diff(antiderivative, axis=0), axis=1)


def _gauss(integrand: Function, x: DoubleArray, y: DoubleArray, dx: float, dy: float, points: int) -> DoubleArray:
    """Tensor Gauss-Legendre quadrature over each cell."""
    if x.size == 0 or y.size == 0:
        return np.empty((x.size, y.size))
    nodes, weights = _gauss_legendre(points)
    total = np.zeros((x.size, y.size))
    for node_x, weight_x in zip(nodes, weights, strict=True):
        for node_y, weight_y in zip(nodes, weights, strict=True):
            weight = 0.25 * weight_x * weight_y * dx * dy
            total += weight * integrand(x[:, None] + 0.5 * dx * node_x, y[None, :] + 0.5 * dy * node_y)
    return total


@lru_cache
def _gauss_legendre(points: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return tuple(nodes), tuple(weights)


def _cubed(u: DoubleArray, v: DoubleArray) -> DoubleArray:
    squared = u * u + v * v
    return squared * np.sqrt(squared)


def _log_sum(v: DoubleArray, u: DoubleArray, r: DoubleArray) -> DoubleArray:
    """ln(v + r) with r = hypot(u, v), without cancellation where v < 0."""
    positive = r + np.abs(v)
    return np.where(v >= 0.0, np.log(positive), 2.0 * np.log(np.abs(u)) - np.log(positive))


def _inverse_distance_corner(u: DoubleArray, v: DoubleArray) -> DoubleArray:
    r = np.hypot(u, v)
    return u * _log_sum(v, u, r) + v * _log_sum(u, v, r)


def _along_x_corner(u: DoubleArray, v: DoubleArray) -> DoubleArray:
    return v * _log_sum(u, v, np.hypot(u, v))


def _radial_x_corner(u: DoubleArray, v: DoubleArray) -> DoubleArray:
    return v * np.log(np.hypot(u, v)) + u * np.arctan(v / u)
