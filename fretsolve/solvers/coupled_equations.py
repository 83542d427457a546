"""The linear equations of pressure and shear together at fixed zones: one Newton step of `coupled_newton`.

The unknowns are, in each cell in contact, the change dp of the pressure and a change of the shear: dq where the cell
sticks, its part y across the shear where it slips. There dq = y + mu n dp with n = q/|q|.

    T [K (dp, dq) + S y - N m] = right,    N' (dp, dq) = missing   (T13 of docs/theory.md)

K is the block operator, S = lam/b the stiffness of the slip law, T the part across n, N the rigid motions of
imposed resultants and m their amplitudes. GMRES solves the equations, preconditioned by (T7).
"""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.workspace import Workspace
from fretsolve.solvers.gmres import gmres
from fretsolve.system.arrays import FloatArray, IndexArray

MOST_ITERATIONS = 100

DEPENDENT = 1e-10
"""Singular value, over the largest, at which a combination of the rigid motions counts as none."""


class CoupledEquations:
    """The equations at fixed zones, with lengths over the operator's unit, for the n cells in contact.

    cells: their places in a flattened field, (n,); normal: (2, n), 0 where a cell sticks; drag: friction coefficient
    where it slips, 0 elsewhere, (n,); stiffness: S over the unit, (n,); motions: N, (m, 3, n), their first component
    for the gap. arrays: to work in, for pressure and uz (nx, ny) and displacement (2, nx, ny), as is `workspace`.
    """

    def __init__(
        self,
        operator: ElasticOperator,
        workspace: Workspace,
        arrays: tuple[FloatArray, FloatArray, FloatArray],
        cells: IndexArray,
        normal: FloatArray,
        drag: FloatArray,
        stiffness: FloatArray,
        motions: FloatArray,
    ):
        self._operator, self._cells, self._normal, self._drag = operator, cells, normal, drag
        self._stiffness, self._loads = stiffness, motions
        self._pressure, self._uz, self._displacement = arrays
        self._shear, self._two = workspace.double, workspace.image
        self._one = workspace.first_component().direction
        for field in (self._pressure, self._shear, self._one, self._two):
            field.fill(0.0)
        self._weight = 1.0 / (1.0 + stiffness)
        # the preconditioned motions and their resultants: the small system of the amplitudes
        self._motions = motions.copy()
        for motion in self._motions:
            self._keep_across(motion)
        self._answers = np.array([self._invert(motion) for motion in self._motions]).reshape(motions.shape)
        resultants = np.array([self._resultants(answer) for answer in self._answers])
        self._schur = np.linalg.pinv(resultants.T, rcond=DEPENDENT) if resultants.size else resultants

    def solve(
        self, right: FloatArray, missing: FloatArray, reduction: float, most: int
    ) -> tuple[FloatArray, FloatArray, int]:
        """Return (dp, dq) as (3, n), the amplitudes (m,), and the number of GMRES iterations.

        right: (3, n); missing: (m,); reduction: of the residual, if `most` iterations suffice.
        """
        # a first solution that has the missing resultants, and its residual
        first, amplitudes = self._precondition(right, missing)
        residual, nothing = right - self._apply(first, amplitudes), np.zeros_like(missing)
        target = reduction * max(float(np.linalg.norm(right)), float(np.linalg.norm(residual)))

        def apply(vector: FloatArray) -> FloatArray:
            return self._apply(*self._precondition(vector, nothing))

        # GMRES corrects it without changing the resultants
        combined, iterations = gmres(apply, residual, target, min(MOST_ITERATIONS, most))
        correction, rest = self._precondition(combined, nothing)
        first += correction
        return self._tractions(first), amplitudes + rest, iterations

    def _keep_across(self, field: FloatArray) -> None:
        """Apply T to the last two components, in place."""
        field[1:] -= (field[1] * self._normal[0] + field[2] * self._normal[1]) * self._normal

    def _tractions(self, unknown: FloatArray) -> FloatArray:
        """Return (dp, dq) of the unknown (dp, y)."""
        change = unknown.copy()
        self._keep_across(change)
        change[1:] += self._drag * unknown[0] * self._normal
        return change

    def _resultants(self, unknown: FloatArray) -> FloatArray:
        """Return the resultants (m,) of the unknown."""
        return np.tensordot(self._loads, self._tractions(unknown), axes=2)

    def _apply(self, unknown: FloatArray, amplitudes: FloatArray) -> FloatArray:
        """Return the left-hand side of the equations."""
        self._spread(self._tractions(unknown), (self._pressure, *self._shear))
        self._operator.all(self._pressure, self._shear, self._uz, self._displacement)
        image = self._collect((self._uz, *self._displacement))
        image /= self._operator.unit
        image[1:] += unknown[1:] * self._stiffness
        self._keep_across(image)
        for amplitude, motion in zip(amplitudes, self._motions, strict=True):
            image -= motion * amplitude
        return image

    def _precondition(self, right: FloatArray, missing: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return unknowns and amplitudes that meet `missing` exactly and `right` roughly."""
        unknown = self._invert(right)
        if not len(missing):
            return unknown, np.zeros(0)
        amplitudes: FloatArray = self._schur @ (missing - self._resultants(unknown))
        for amplitude, answer in zip(amplitudes, self._answers, strict=True):
            unknown += answer * amplitude
        return unknown, amplitudes

    def _invert(self, right: FloatArray) -> FloatArray:
        """Apply (T7): the inverse of the symbol where cells stick, the diagonal where their slip stiffness is large."""
        weight, inverse = self._weight, self._operator.preconditioner
        largest = float(np.abs(right).max()) or 1.0
        scaled = right / largest
        diagonal = scaled[1:] * (weight * (1.0 - weight**2))
        scaled[1:] *= weight
        self._spread(scaled, (self._one[0], *self._two))
        inverse.normal(self._one, self._one)
        inverse.tangential(self._two, self._two)
        result = self._collect((self._one[0], *self._two))
        self._one.fill(0.0)
        self._two.fill(0.0)
        result[1:] *= weight
        result[1:] += diagonal
        result *= largest
        self._keep_across(result)
        return result

    def _spread(self, values: FloatArray, fields: tuple[FloatArray, ...]) -> None:
        """Write values (3, n) of the cells in contact into planes."""
        for value, field in zip(values, fields, strict=True):
            field.reshape(-1)[self._cells] = value

    def _collect(self, fields: tuple[FloatArray, ...]) -> FloatArray:
        """Return the values (3, n) of the cells in contact of planes, in double precision."""
        return np.array([field.reshape(-1)[self._cells] for field in fields], dtype=np.float64)
