"""The linear equations of pressure and shear together, at fixed zones: one Newton step of `fretsolve.joint`.

Unknown are, in each cell in contact, the change dp of the pressure and of the shear: dq where it sticks, its part y
across the shear where it slips; there dq = y + mu n dp, n = q/|q|. With K the block operator, S = lambda/(mu p) the
slip's own stiffness, T the part across n, M the rigid motions of forced resultants and r their amplitudes,

    T [K (dp, dq) + S y - M r] = right,    resultants of (dp, dq) = missing.

It is not symmetric, because pressure makes shear where cells slip. GMRES solves it, preconditioned by the inverse of
the half-space's symbol as in `fretsolve.projected_cg`, with the balance kept exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic import ElasticOperator
from fretsolve.krylov import gmres

FloatArray = NDArray[np.floating]
BoolArray = NDArray[np.bool_]

REDUCTION = 1e-2
"""By how much a step reduces the residual of the linear equations."""

MOST_ITERATIONS = 100

DEPENDENT = 1e-10
"""Part of the largest at which a combination of the rigid motions counts as none."""


@dataclass(frozen=True)
class Zones:
    """What a step takes as given, in the cells in contact, of which there are n.

    contact: (nx, ny); normal: (2, n), 0 where a cell sticks; drag: friction coefficient where it slips, 0 elsewhere,
    (n,); stiffness: S over the operator's inner unit, (n,); motions: M, (m, 3, n), the first for the gap.
    """

    contact: BoolArray
    normal: FloatArray
    drag: FloatArray
    stiffness: FloatArray
    motions: FloatArray


class JointEquations:
    """The equations at `zones`, with lengths over the operator's inner unit."""

    def __init__(self, operator: ElasticOperator, zones: Zones):
        self._inner, self._operator, self._zones = operator.inner, operator, zones
        self._weight = 1.0 / (1.0 + zones.stiffness)
        shape, dtype = zones.contact.shape, self._inner.dtype
        self._pressure, self._uz = np.zeros(shape), np.zeros(shape)
        self._shear, self._displacement = np.zeros((2, *shape)), np.zeros((2, *shape))
        self._one, self._two = np.zeros((1, *shape), dtype), np.zeros((2, *shape), dtype)
        self._tilted = np.array([self._across(motion) for motion in zones.motions]).reshape(zones.motions.shape)
        self._answers = [self._inverse(motion) for motion in self._tilted]
        columns = [self._resultants(answer) for answer in self._answers]
        self._schur = np.linalg.pinv(np.array(columns).T, rcond=DEPENDENT) if columns else np.zeros((0, 0))

    def solve(self, right: FloatArray, missing: FloatArray) -> tuple[FloatArray, FloatArray, int]:
        """(dp, dq) as (3, n), amplitudes (m,), and GMRES's iterations; right: (3, n); missing: (m,)."""
        first, amplitudes = self._precondition(right, missing)
        image = np.empty_like(right)
        self._apply(first, amplitudes, image)
        left, nothing = right - image, np.zeros_like(missing)

        def apply(direction: FloatArray, out: FloatArray) -> None:
            self._apply(*self._precondition(direction, nothing), out)

        target = REDUCTION * max(float(np.linalg.norm(right)), float(np.linalg.norm(left)))
        combined, iterations = gmres(apply, left, target, MOST_ITERATIONS)
        more, rest = self._precondition(combined, nothing)
        return self._tractions(first + more), amplitudes + rest, iterations

    def _across(self, field: FloatArray) -> FloatArray:
        """T of the last two components."""
        result, normal = field.copy(), self._zones.normal
        result[1:] -= (result[1] * normal[0] + result[2] * normal[1]) * normal
        return result

    def _tractions(self, unknown: FloatArray) -> FloatArray:
        """(dp, dq) from (dp, y)."""
        result = self._across(unknown)
        result[1:] += self._zones.drag * self._zones.normal * unknown[0]
        return result

    def _resultants(self, unknown: FloatArray) -> FloatArray:
        return np.tensordot(self._zones.motions, self._tractions(unknown), axes=2)

    def _apply(self, unknown: FloatArray, amplitudes: FloatArray, out: FloatArray) -> None:
        contact = self._zones.contact
        tractions = self._tractions(unknown)
        self._pressure[contact], self._shear[:, contact] = tractions[0], tractions[1:]
        self._operator.all(self._pressure, self._shear, self._uz, self._displacement)
        out[0], out[1:] = self._uz[contact], self._displacement[:, contact]
        out /= self._inner.unit
        out[1:] += self._zones.stiffness * unknown[1:]
        out[:] = self._across(out)
        out -= np.tensordot(amplitudes, self._tilted, axes=1)

    def _precondition(self, right: FloatArray, missing: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unknowns and amplitudes that meet `missing` exactly and `right` roughly."""
        unknown = self._inverse(right)
        if not len(missing):
            return unknown, np.zeros(0)
        amplitudes: FloatArray = self._schur @ (missing - self._resultants(unknown))
        for amplitude, answer in zip(amplitudes, self._answers, strict=True):
            unknown += amplitude * answer
        return unknown, amplitudes

    def _inverse(self, right: FloatArray) -> FloatArray:
        """The symbol's inverse where cells stick, the diagonal where their own stiffness is large."""
        contact, weight = self._zones.contact, self._weight
        largest = float(np.abs(right).max()) or 1.0
        scaled = right / largest
        self._one[0][contact], self._two[:, contact] = scaled[0], weight * scaled[1:]
        self._inner.inverse.normal(self._one, self._one)
        self._inner.inverse.tangential(self._two, self._two)
        result = np.empty_like(right)
        result[0] = self._one[0][contact]
        result[1:] = weight * (self._two[:, contact] + (1.0 - weight**2) * scaled[1:])
        self._one[:], self._two[:] = 0.0, 0.0
        result *= largest
        return self._across(result)
