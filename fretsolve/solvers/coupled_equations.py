"""The linear equations of pressure and shear together, at fixed zones: one Newton step of `coupled_newton`.

Unknown are, in each cell in contact, the change dp of the pressure and of the shear: dq where it sticks, its part y
across the shear where it slips; there dq = y + mu n dp, n = q/|q|. With K the block operator, S = lambda/(mu p) the
slip's own stiffness, T the part across n, M the rigid motions of forced resultants and r their amplitudes,

    T [K (dp, dq) + S y - M r] = right,    resultants of (dp, dq) = missing.

It is not symmetric, because pressure makes shear where cells slip. GMRES solves it, preconditioned by the inverse of
the half-space's symbol as in `projected_cg`, with the balance kept exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.solvers.gmres import gmres
from fretsolve.system.arrays import FloatArray, IndexArray

MOST_ITERATIONS = 100

DEPENDENT = 1e-10
"""Part of the largest at which a combination of the rigid motions counts as none."""


@dataclass(frozen=True)
class Zones:
    """What a step takes as given, in the cells in contact, of which there are n.

    cells: their places in a flattened field, (n,); normal: (2, n), 0 where a cell sticks; drag: friction coefficient
    where it slips, 0 elsewhere, (n,); stiffness: S over the operator's inner unit, (n,); motions: M, (m, 3, n), the
    first for the gap.
    """

    cells: IndexArray
    normal: FloatArray
    drag: FloatArray
    stiffness: FloatArray
    motions: FloatArray


@dataclass(frozen=True)
class Fields:
    """Room on the grid for tractions and displacements (components, nx, ny), in double precision, and for the inverse's
    fields of one and of two components, in the inner one."""

    pressure: FloatArray
    shear: FloatArray
    uz: FloatArray
    displacement: FloatArray
    one: FloatArray
    two: FloatArray


class JointEquations:
    """The equations at `zones`, with lengths over the operator's inner unit; `fields` are worked in."""

    def __init__(self, operator: ElasticOperator, fields: Fields, zones: Zones):
        self._inner, self._operator, self._fields, self._zones = operator.inner, operator, fields, zones
        for field in (fields.pressure, fields.shear, fields.one, fields.two):
            field.fill(0.0)
        count = zones.cells.size
        self._weight = 1.0 / (1.0 + zones.stiffness)
        self._rest = self._weight * (1.0 - self._weight**2)
        self._change, self._part = np.empty((3, count)), np.empty((3, count))
        self._column = np.empty(count, self._inner.dtype)
        self._tilted = zones.motions.copy()
        self._answers = np.empty_like(zones.motions)
        columns = np.empty((len(zones.motions), len(zones.motions)))
        for tilted, answer, column in zip(self._tilted, self._answers, columns, strict=True):
            self._leave_across(tilted)
            self._invert(tilted, answer)
            column[:] = self._resultants(answer)
        self._schur = np.linalg.pinv(columns.T, rcond=DEPENDENT) if columns.size else columns

    def solve(
        self, right: FloatArray, missing: FloatArray, reduction: float, most: int
    ) -> tuple[FloatArray, FloatArray, int]:
        """(dp, dq) as (3, n), amplitudes (m,), and GMRES's iterations; right: (3, n); missing: (m,).

        reduction: of the residual, if `most` iterations suffice.
        """
        first, direction, image = np.empty_like(right), np.empty_like(right), np.empty_like(right)
        amplitudes = self._precondition(right, missing, first)
        self._apply(first, amplitudes, image)
        left, nothing = right - image, np.zeros_like(missing)
        target = reduction * max(float(np.linalg.norm(right)), float(np.linalg.norm(left)))

        def apply(residual: FloatArray, out: FloatArray) -> None:
            self._apply(direction, self._precondition(residual, nothing, direction), out)

        # pages of the basis that are not reached cost nothing
        basis = np.empty((min(MOST_ITERATIONS, most) + 1, *right.shape))
        combined, iterations = gmres(apply, left, target, basis)
        rest = self._precondition(combined, nothing, direction)
        first += direction
        self._take_tractions(first)
        return self._change, amplitudes + rest, iterations

    def _leave_across(self, field: FloatArray) -> None:
        """T of the last two components, in place."""
        along, pair, normal = self._part[0], self._part[1:], self._zones.normal
        np.multiply(field[1:], normal, out=pair)
        np.add(pair[0], pair[1], out=along)
        field[1:] -= np.multiply(along, normal, out=pair)

    def _take_tractions(self, unknown: FloatArray) -> None:
        """(dp, dq) from (dp, y), into `_change`."""
        change, along, pair, zones = self._change, self._part[0], self._part[1:], self._zones
        np.copyto(change, unknown)
        self._leave_across(change)
        np.multiply(zones.drag, unknown[0], out=along)
        change[1:] += np.multiply(along, zones.normal, out=pair)

    def _resultants(self, unknown: FloatArray) -> FloatArray:
        self._take_tractions(unknown)
        return np.tensordot(self._zones.motions, self._change, axes=2)

    def _apply(self, unknown: FloatArray, amplitudes: FloatArray, out: FloatArray) -> None:
        fields, pair = self._fields, self._part[1:]
        self._take_tractions(unknown)
        self._spread(self._change, (fields.pressure, *fields.shear))
        self._operator.all(fields.pressure, fields.shear, fields.uz, fields.displacement)
        self._collect((fields.uz, *fields.displacement), out)
        out /= self._inner.unit
        out[1:] += np.multiply(unknown[1:], self._zones.stiffness, out=pair)
        self._leave_across(out)
        for amplitude, tilted in zip(amplitudes, self._tilted, strict=True):
            out -= np.multiply(tilted, amplitude, out=self._part)

    def _precondition(self, right: FloatArray, missing: FloatArray, out: FloatArray) -> FloatArray:
        """Unknowns, into `out`, and amplitudes that meet `missing` exactly and `right` roughly."""
        self._invert(right, out)
        if not len(missing):
            return np.zeros(0)
        amplitudes: FloatArray = self._schur @ (missing - self._resultants(out))
        for amplitude, answer in zip(amplitudes, self._answers, strict=True):
            out += np.multiply(answer, amplitude, out=self._part)
        return amplitudes

    def _invert(self, right: FloatArray, out: FloatArray) -> None:
        """The symbol's inverse where cells stick, the diagonal where their own stiffness is large."""
        fields, part, inverse = self._fields, self._part, self._inner.inverse
        np.abs(right, out=part)
        largest = float(part.max()) or 1.0
        np.divide(right, largest, out=part)
        part[1:] *= self._weight
        self._spread(part, (fields.one[0], *fields.two))
        inverse.normal(fields.one, fields.one)
        inverse.tangential(fields.two, fields.two)
        self._collect((fields.one[0], *fields.two), out)
        fields.one.fill(0.0)
        fields.two.fill(0.0)
        out[1:] *= self._weight
        np.divide(right[1:], largest, out=part[1:])
        part[1:] *= self._rest
        out[1:] += part[1:]
        out *= largest
        self._leave_across(out)

    def _spread(self, values: FloatArray, fields: tuple[FloatArray, ...]) -> None:
        """Values of the cells in contact into planes."""
        for value, field in zip(values, fields, strict=True):
            field.reshape(-1)[self._zones.cells] = value

    def _collect(self, fields: tuple[FloatArray, ...], out: FloatArray) -> None:
        """Values of the cells in contact out of planes."""
        for value, field in zip(out, fields, strict=True):
            column = value if field.dtype == value.dtype else self._column
            np.take(field.reshape(-1), self._zones.cells, out=column, mode="clip")
            value[:] = column
