"""The form of a measured map: the polynomial that fits it best, with its tilts and curvatures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.system.arrays import DoubleArray

Powers = tuple[int, int]

FORMS: dict[str, tuple[tuple[Powers, ...], ...]] = {
    "offset": (((0, 0),),),
    "plane": (((0, 0),), ((1, 0),), ((0, 1),)),
    "sphere": (((0, 0),), ((1, 0),), ((0, 1),), ((2, 0), (0, 2))),
    "quadratic": (((0, 0),), ((1, 0),), ((0, 1),), ((2, 0),), ((1, 1),), ((0, 2),)),
}
"""Terms of each form. A term is a sum of x^p y^q/p!q!, each given by (p, q), so that its factor is a derivative."""


@dataclass(frozen=True)
class Form:
    """A polynomial about the middle of a map.

    heights: (mx, my) in mm at the points of the map; offset: mm, in the middle; tilts: slopes in the middle along x and
    y, of a profile along x; curvatures: 1/mm, the one of a sphere or the principal ones of a quadratic, else none;
    determined: whether no other such form fits the known points as well.
    """

    heights: DoubleArray
    offset: float
    tilts: tuple[float, ...]
    curvatures: tuple[float, ...]
    determined: bool


def fitted(height_map: HeightMap, name: str) -> Form:
    """Return the form `name` (of FORMS) that fits the known points of a map best, by least squares.

    A profile has no terms of y. The unknowns are few, so the normal equations hold; their sums over the map are
    products with the powers of x and of y, which are scaled to [-1, 1] for the sake of rounding.
    """
    values, is_profile = height_map.values, height_map.values.shape[1] == 1
    known = np.isfinite(values)
    middle = float(np.mean(values[known]))
    halves = [0.5 * span or 1.0 for span in height_map.span]
    terms = [_polynomial([(p, q) for p, q in term if not (is_profile and q)], *halves) for term in FORMS[name]]
    terms = [term for term in terms if term.any()]
    x, y = (np.vander(np.linspace(-1.0, 1.0, n), 5, increasing=True) if n > 1 else np.eye(1, 5) for n in values.shape)
    moments = x.T @ known @ y
    products = x[:, :3].T @ np.where(known, values - middle, 0.0) @ y[:, :3]

    matrix = np.array([[_sum_of_product(one, other, moments) for other in terms] for one in terms])
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    matrix *= np.outer(scale, scale)
    right_side = scale * [np.sum(term * products) for term in terms]
    factors = scale * np.linalg.lstsq(matrix, right_side, rcond=None)[0]
    coefficients = np.tensordot(factors, terms, axes=1)
    heights = middle + x[:, :3] @ coefficients @ y[:, :3].T
    offset, slopes, second = middle + factors[0], factors[1 : 2 if is_profile else 3], factors[2 if is_profile else 3 :]
    if second.size == 3:
        second = np.linalg.eigvalsh([second[:2], second[1:]])[::-1]
    determined = np.linalg.matrix_rank(matrix) == len(terms)
    return Form(heights, float(offset), tuple(slopes.tolist()), tuple(second.tolist()), bool(determined))


def _polynomial(powers: list[Powers], half_x: float, half_y: float) -> DoubleArray:
    """Return the factors (3, 3) of x^p y^q for x and y in half sides of the map."""
    factors = np.zeros((3, 3))
    for p, q in powers:
        factors[p, q] = half_x**p / max(p, 1) * half_y**q / max(q, 1)  # p! is p here
    return factors


def _sum_of_product(one: DoubleArray, other: DoubleArray, moments: DoubleArray) -> float:
    """Return the sum over the map of the product of two polynomials; moments: sums of x^p y^q (5, 5)."""
    sums = [moments[p : p + 3, q : q + 3] * one[p, q] for p in range(3) for q in range(3)]
    return float(np.sum(np.sum(sums, axis=0) * other))
