"""Conjugate gradients for the linear equations of contact at fixed zones, in the balance of forces.

The correction x of a traction (one component: pressure; two: shear) is sought with

    T (B + S) T x = T r + N m,   N' x = 0,   x = 0 out of the zone,

B the elastic operator, S >= 0 a diagonal (the slip's own stiffness), T the part across the unit vectors n where there
are any (the tangents to the friction circle), N the rigid motions whose resultants are imposed, m theirs. The
preconditioner is

    W F W + (1 - W^2) W,   W = 1/(1 + S) in the zone, 0 out of it,

F the inverse of the half-space's symbol: F where S = 0, the diagonal where S is large. The constraints are kept
by projection (Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23, 2001), orthogonal with the weight W.

All is in units in which about the self-coefficient of a cell and the largest residual are 1, so that single precision
holds at any scale of the problem; a correction of a few digits is all that is asked of one solve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.interface import Operators
from fretsolve.kernels import cg
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

DEPENDENT = 1e-6
"""Part of the largest at which a combination of the constraints counts as none: one cell resists no rotation."""

NOTHING_LEFT = 100.0
"""In roundings of 1: a residual below it after the projection is the rounding of a rigid motion."""


class ProjectedCG:
    """Working arrays for fields of one or two components on ``shape``.

    Before `solve`: `residual` r (c, nx, ny); `zone` (nx, ny); `weight` W (nx, ny); and for two components
    `stiffness` S (nx, ny) and `normal` n (2, nx, ny), 0 where T takes all; and the constraints by `constrain`.
    After it `solution` holds x. lender: one of more components to work in the arrays of, `weight` too; not for use at
    the same time.
    """

    def __init__(
        self,
        components: int,
        shape: tuple[int, int],
        dtype: type[np.floating],
        lender: ProjectedCG | None = None,
    ):
        vector, alone = (components, *shape), components == 1
        if lender is None:
            self._arrays = tuple(np.zeros(vector, dtype) for _ in range(4))
            self.weight = np.zeros(shape, dtype)
        else:
            self._arrays, self.weight = tuple(array[:components] for array in lender._arrays), lender.weight
        self.solution, self.residual, self._direction, self._image = self._arrays
        self.zone: BoolArray = np.zeros(shape, dtype=bool)
        self.stiffness = np.zeros((1, 1) if alone else shape, dtype)
        self.normal = np.zeros((2, 1, 1) if alone else vector, dtype)
        self._room = np.zeros((0, *vector), dtype)
        self._constraints, self._moments = self._room, np.zeros(0)
        self._inverse_gram: FloatArray = np.zeros((0, 0))

    @property
    def spare(self) -> tuple[FloatArray, FloatArray]:
        """Two arrays (c, nx, ny) that are free between solves."""
        return self._direction, self._image

    def constrain(self, motions: Sequence[int], motion: Callable[[int, FloatArray], None]) -> None:
        """Keep the solution orthogonal to rigid motions; ``motion(mode, out)`` writes one of them (c, nx, ny)."""
        if len(self._room) < len(motions):
            self._room = np.zeros((len(motions), *self.solution.shape), self.solution.dtype)
        self._constraints = self._room[: len(motions)]
        self._moments = np.zeros(len(motions))
        for mode, constraint in zip(motions, self._constraints, strict=True):
            motion(mode, constraint)
            constraint /= float(np.abs(constraint).max()) or 1.0
            cg.restrict(constraint, self.normal, self.zone)
        gram: DoubleArray = np.zeros((len(motions), len(motions)))
        for row, constraint in zip(gram, self._constraints, strict=True):
            cg.weigh_moments(constraint, self.weight, self._constraints, row)
        if len(motions) == 1:
            self._inverse_gram = np.divide(1.0, gram, out=np.zeros_like(gram), where=gram > 0.0)
        elif motions:
            self._inverse_gram = np.linalg.pinv(gram, rcond=DEPENDENT, hermitian=True)

    def solve(self, operators: Operators, reduction: float, floor: float, limit: int) -> int:
        """Reduce the residual's largest length by `reduction`, or to `floor`; at most `limit` iterations.

        Returns the iterations made, at least one.
        """
        start = self._start()
        target = max(reduction * start, floor)
        previous, iteration = 1.0, 0
        if start < NOTHING_LEFT * float(np.finfo(self.solution.dtype).eps):
            return 1
        while iteration < limit:
            current = self._precondition(operators)
            if not current > 0.0:
                break
            cg.turn(
                self._direction, self._image, self.weight, self._constraints, self._amplitudes(), current / previous
            )
            previous = current
            operators.elastic(self._direction, self._image)
            curvature = self._finish_image()
            if not curvature > 0.0:
                break
            iteration += 1
            if self._step(current / curvature) <= target:
                break
        return max(iteration, 1)

    def _start(self) -> float:
        """Residual made tangential and orthogonal to the constraints; its largest length."""
        self.solution[:] = 0.0
        self._direction[:] = 0.0
        cg.restrict(self.residual, self.normal, self.zone)
        cg.weigh_moments(self.residual, self.weight, self._constraints, self._moments)
        return cg.remove(self.residual, self._constraints, self._amplitudes())

    def _amplitudes(self) -> DoubleArray:
        """Of the constraints' motions, from the moments found last."""
        return self._inverse_gram @ self._moments if len(self._moments) else self._moments

    def _precondition(self, operators: Operators) -> float:
        """The preconditioned residual in `_image`; its product with the residual."""
        np.multiply(self.residual, self.weight, out=self._image)
        operators.inverse(self._image, self._image)
        return cg.finish_search(
            self._image, self.residual, self.weight, self.normal, self._constraints, self._moments
        )

    def _finish_image(self) -> float:
        """T (B + S) d from B d in `_image`; its product with d."""
        return cg.finish_image(
            self._image,
            self._direction,
            self.stiffness,
            self.normal,
            self.zone,
            self.weight,
            self._constraints,
            self._moments,
        )

    def _step(self, length: float) -> float:
        """Step along the direction; the residual stays orthogonal to the constraints. Its largest length."""
        return cg.advance(
            self.solution,
            self.residual,
            self._direction,
            self._image,
            self._constraints,
            self._amplitudes(),
            length,
        )


@dataclass(frozen=True)
class Space:
    """What a solver of one component works in: one or two planes (nx, ny) in double precision, and its inner solver."""

    planes: FloatArray
    cg: ProjectedCG
