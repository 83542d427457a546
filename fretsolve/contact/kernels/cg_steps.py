"""Steps of the conjugate gradients, made of the passes in `fretsolve.contact.kernels.cg`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fretsolve.contact.kernels.cg import (
    advance_loops,
    apply_loops,
    clear_loops,
    divide_loops,
    largest_loops,
    precondition_loops,
    turn_loops,
)
from fretsolve.elastic.kernels.compiling import compiled, inlined
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray


class Steps:
    """Steps of the conjugate gradients on one grid, each made of `passes`; arguments as in `cg`.

    inverse_gram: (c' W c)^-1, (m, m).
    """

    def __init__(self, passes: Any):
        self._passes = passes
        self.constrain, self.add, self.largest = passes.constrain, passes.add, passes.largest

    def start(
        self,
        solution: FloatArray,
        displacement: FloatArray,
        direction: FloatArray,
        residual: FloatArray,
        image: FloatArray,
        stiffness: FloatArray,
        normal: FloatArray,
        zone: BoolArray,
        weight: FloatArray,
        constraints: FloatArray,
        inverse_gram: DoubleArray,
    ) -> float:
        """Begin at 0: set three fields to it, compute ``residual = P T residual`` (T9) and ``image = V residual``.

        Return the largest length of the residual in a cell (CG1).
        """
        self._passes.clear(solution, displacement, direction, image)
        _, moments = self._passes.apply(residual, residual, direction, stiffness, normal, zone, weight, constraints)
        amplitudes = -(inverse_gram @ moments)
        found: float = self._passes.advance(solution, residual, direction, image, weight, constraints, amplitudes, 1.0)
        return found

    def search(
        self,
        image: FloatArray,
        direction: FloatArray,
        residual: FloatArray,
        weight: FloatArray,
        normal: FloatArray,
        constraints: FloatArray,
        inverse_gram: DoubleArray,
        rho_before: float,
    ) -> float:
        """Compute z (T7) from the image and ``direction = P' z + (rho / rho_before) direction``.

        Return rho, the product of z with `residual` (CG2, CG3). If that is not positive, the direction stays. The image
        is overwritten.
        """
        rho, moments = self._passes.precondition(image, residual, weight, normal, constraints)
        if rho > 0.0:
            self._passes.turn(direction, image, weight, constraints, inverse_gram @ moments, rho / rho_before)
        return float(rho)

    def step(
        self,
        solution: FloatArray,
        displacement: FloatArray,
        residual: FloatArray,
        direction: FloatArray,
        moved: FloatArray,
        image: FloatArray,
        stiffness: FloatArray,
        normal: FloatArray,
        zone: BoolArray,
        weight: FloatArray,
        constraints: FloatArray,
        inverse_gram: DoubleArray,
        rho: float,
    ) -> tuple[float, float]:
        """Compute ``w = T (moved + S direction)`` in the zone, and step along the direction (CG4, CG5).

        moved: B times the direction. ``solution += alpha direction``, ``displacement += alpha moved`` and
        ``residual -= alpha P w`` (T9), with ``alpha = rho / kappa`` and kappa the product of direction and w; then
        ``image = V residual``. Return kappa and the largest length of the residual in a cell. If kappa is not positive,
        solution, displacement and residual stay.
        """
        kappa, moments = self._passes.apply(moved, image, direction, stiffness, normal, zone, weight, constraints)
        if not kappa > 0.0:
            return kappa, math.inf
        amplitudes, length = inverse_gram @ moments, rho / kappa
        self._passes.add(displacement, moved, length)
        return kappa, self._passes.advance(
            solution, residual, direction, image, weight, constraints, amplitudes, length
        )

    def normalise(self, field: FloatArray, result: FloatArray) -> tuple[float, float]:
        """Compute ``result = field / size``, in its precision, with the field's largest absolute value for the size.

        Return the size and the sum of the result's absolute values. If the size is 0, the result is not written.
        """
        size: float = self._passes.largest(field)
        return size, float(self._passes.divide(field, size, result)) if size else 0.0


@compiled
def start_loops(
    solution, displacement, direction, residual, image, stiffness, normal, zone, weight, constraints, inverse_gram
):
    rows = len(weight)
    clear_loops(0, rows, solution, displacement, direction, image)
    _, moments = apply_loops(0, rows, residual, residual, direction, stiffness, normal, zone, weight, constraints)
    amplitudes = _multiply(inverse_gram, moments)
    for m in range(len(amplitudes)):
        amplitudes[m] = -amplitudes[m]
    return advance_loops(0, rows, solution, residual, direction, image, weight, constraints, amplitudes, 1.0)


@compiled
def search_loops(image, direction, residual, weight, normal, constraints, inverse_gram, rho_before):
    rows = len(weight)
    rho, moments = precondition_loops(0, rows, image, residual, weight, normal, constraints)
    if rho > 0.0:
        amplitudes = _multiply(inverse_gram, moments)
        turn_loops(0, rows, direction, image, weight, constraints, amplitudes, rho / rho_before)
    return rho


@compiled
def step_loops(
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
    components, rows, columns = image.shape
    kappa, moments = apply_loops(0, rows, moved, image, direction, stiffness, normal, zone, weight, constraints)
    if not kappa > 0.0:
        return kappa, math.inf
    amplitudes, length = _multiply(inverse_gram, moments), rho / kappa
    alpha = image.dtype.type(length)
    for part in range(components):
        for i in range(rows):
            for j in range(columns):
                displacement[part, i, j] += alpha * moved[part, i, j]
    return kappa, advance_loops(0, rows, solution, residual, direction, image, weight, constraints, amplitudes, length)


@compiled
def normalise_loops(field, result):
    rows = field.shape[1]
    size, total = largest_loops(0, rows, field), 0.0
    if size != 0.0:
        total = divide_loops(0, rows, field, size, result)
    return size, total


@inlined
def _multiply(matrix, vector):
    result = np.zeros(len(vector))
    for m in range(len(vector)):
        for n in range(len(vector)):
            result[m] += matrix[m, n] * vector[n]
    return result
