"""The linear equations of pressure and shear together at fixed zones: one Newton step of `coupled_newton`.

The unknowns are, in each cell in contact, the change dp of the pressure and a change of the shear: dq where the cell
sticks, its part y across the shear where it slips. There dq = y + b' n dp with n = q/|q|
and the slope b' of the friction limit, which is mu for Coulomb friction.

    T [K (dp, dq) + S y - N m] = right,    N' (dp, dq) = missing   (T13 of docs/theory.md)

K is the elastic operator, S = lam/b the stiffness of the slip law, T the part across n, N the rigid motions of the
imposed loads and m their amplitudes. GMRES (Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) solves the equations,
preconditioned by (T7); SciPy's GMRES applies the operator once more per solve, and takes half a second to import.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fretsolve.contact.kernels.cg import diagonal, share
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.system.arrays import BoolArray, FloatArray

DEPENDENT_MOTIONS = 1e-10
"""Singular value, over the largest, below which a combination of the rigid motions counts as none."""


class CoupledEquations:
    """The equations at fixed zones for the n cells of `contact` (nx, ny), with lengths over the operator's unit.

    normal: (2, n), 0 where a cell sticks; drag: (n,), b' where a cell slips, 0 elsewhere; stiffness: S over the unit,
    (n,); motions: N, (m + k, 3, n), whose first component belongs to the gap: of the m imposed loads, then of the k
    modes of a rig that gives way; compliance: of the rig over the unit, (k, k).
    """

    def __init__(
        self,
        operator: ElasticOperator,
        contact: BoolArray,
        normal: FloatArray,
        drag: FloatArray,
        stiffness: FloatArray,
        motions: FloatArray,
        compliance: FloatArray,
    ):
        self._operator, self._cells = operator, np.flatnonzero(contact)
        self._normal, self._drag, self._stiffness, self._loads = normal, drag, stiffness, motions
        self._imposed, self._compliance = len(motions) - len(compliance), compliance
        self._tractions, self._displacements = np.zeros((3, *contact.shape)), np.empty((3, *contact.shape))
        self._scaled = np.empty((3, *contact.shape), operator.inner.dtype)
        weight = 1.0 / (1.0 + stiffness)
        self._share = share(weight)
        self._diagonal = diagonal(weight, self._share)
        # the motions, preconditioned, and their resultants: the small system of the amplitudes
        self._motions = motions.copy()
        for motion in self._motions:
            self._keep_across(motion)
        self._answers = np.array([self._invert(motion) for motion in self._motions]).reshape(motions.shape)
        resultants = np.array([self._resultants(answer) for answer in self._answers])
        self._schur = resultants
        if resultants.size:
            # a rig gives way by t = -C N' u
            small = self._weighted(resultants.T)
            small[self._imposed :, self._imposed :] += np.eye(len(compliance))
            self._schur = np.linalg.pinv(small, rcond=DEPENDENT_MOTIONS)

    def solve(
        self, right: FloatArray, missing: FloatArray, reduction: float, most: int
    ) -> tuple[FloatArray, FloatArray, int]:
        """Return (dp, dq) as (3, n), the amplitudes (m,), and the number of GMRES iterations.

        right: (3, n); missing: (m,); reduction: of the residual, if `most` iterations suffice.
        """
        # a first solution by (T7) that has the missing resultants, and its residual in (T13)
        first, amplitudes = self._precondition(right, missing)
        residual, nothing = right - self.apply(first, amplitudes), np.zeros_like(missing)
        target = reduction * max(float(np.linalg.norm(right)), float(np.linalg.norm(residual)))

        def apply(vector: FloatArray) -> FloatArray:
            return self.apply(*self._precondition(vector, nothing))

        # GMRES reduces the residual without a change of the resultants
        combined, iterations = gmres(apply, residual, target, min(100, most))
        correction, rest = self._precondition(combined, nothing)
        first += correction
        return self.changes(first), amplitudes + rest, iterations

    def changes(self, unknown: FloatArray) -> FloatArray:
        """Return (dp, dq) of the unknown (dp, y), both (3, n)."""
        change = unknown.copy()
        self._keep_across(change)
        change[1:] += self._drag * unknown[0] * self._normal
        return change

    def apply(self, unknown: FloatArray, amplitudes: FloatArray) -> FloatArray:
        """Return the left-hand side of (T13), (3, n), for the unknown (dp, y) and the amplitudes m."""
        tractions, displacements = self._tractions, self._displacements
        tractions.reshape(3, -1)[:, self._cells] = self.changes(unknown)
        self._operator.all(tractions[0], tractions[1:], displacements[0], displacements[1:])
        image = displacements.reshape(3, -1).take(self._cells, axis=1) / self._operator.unit
        image[1:] += unknown[1:] * self._stiffness
        self._keep_across(image)
        given_way = self._compliance @ self._resultants(unknown)[self._imposed :]
        for amplitude, motion in zip((*amplitudes, *-given_way), self._motions, strict=True):
            image -= motion * amplitude
        return image

    def _weighted(self, resultants: FloatArray) -> FloatArray:
        """Return resultants (m + k, ...), the last k times the rig's compliance."""
        return np.concatenate([resultants[: self._imposed], self._compliance @ resultants[self._imposed :]])

    def _keep_across(self, field: FloatArray) -> None:
        field[1:] -= (field[1] * self._normal[0] + field[2] * self._normal[1]) * self._normal

    def _resultants(self, unknown: FloatArray) -> FloatArray:
        return np.tensordot(self._loads, self.changes(unknown), axes=2)

    def _precondition(self, right: FloatArray, missing: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return unknowns and amplitudes that meet `missing` exactly and `right` roughly."""
        unknown = self._invert(right)
        if not len(self._loads):
            return unknown, np.zeros(0)
        wanted = np.concatenate([missing, np.zeros(len(self._compliance))])
        amplitudes: FloatArray = self._schur @ (wanted - self._weighted(self._resultants(unknown)))
        for amplitude, answer in zip(amplitudes, self._answers, strict=True):
            unknown += answer * amplitude
        return unknown, amplitudes[: self._imposed]

    def _invert(self, right: FloatArray) -> FloatArray:
        """Apply the preconditioner (T7)."""
        within, inverse = self._share, self._operator.preconditioner
        largest = float(np.abs(right).max()) or 1.0
        scaled = right / largest
        by_cell = scaled[1:] * self._diagonal
        scaled[1:] *= within
        self._scaled.fill(0.0)
        self._scaled.reshape(3, -1)[:, self._cells] = scaled
        inverse.normal(self._scaled[:1], self._scaled[:1])
        inverse.tangential(self._scaled[1:], self._scaled[1:])
        result = self._scaled.reshape(3, -1).take(self._cells, axis=1).astype(np.float64)
        result[1:] *= within
        result[1:] += by_cell
        result *= largest
        self._keep_across(result)
        return result


def gmres(
    apply: Callable[[FloatArray], FloatArray], right: FloatArray, target: float, most: int
) -> tuple[FloatArray, int]:
    """Return x with ``|right - A x| <= target`` and the number of iterations, at most `most`.

    apply: returns A v; right: of any shape, which v, A v and x share.
    """
    length = float(np.linalg.norm(right))
    if length <= target or most < 1:
        return np.zeros_like(right), 0
    # pages of the basis that are not reached cost nothing
    basis, hessenberg = np.empty((most + 1, *right.shape)), np.zeros((most + 1, most))
    first_unit = np.zeros(most + 1)
    basis[0], first_unit[0] = right / length, length
    for k in range(most):
        # Arnoldi: the image of the last basis vector, made orthogonal to all of them
        image = apply(basis[k])
        for earlier in range(k + 1):
            hessenberg[earlier, k] = np.vdot(basis[earlier], image)
            image -= basis[earlier] * hessenberg[earlier, k]
        hessenberg[k + 1, k] = grown = float(np.linalg.norm(image))
        # the combination of basis vectors with the least residual
        system = hessenberg[: k + 2, : k + 1]
        shares = np.linalg.lstsq(system, first_unit[: k + 2], rcond=None)[0]
        residual = float(np.linalg.norm(system @ shares - first_unit[: k + 2]))
        if residual <= target or grown <= 1e-14 * length:
            break
        basis[k + 1] = image / grown
    return np.tensordot(shares, basis[: k + 1], axes=1), k + 1
