"""Conjugate gradients for the linear equations of contact at fixed zones; the imposed loads are kept.

The correction x of a traction (one component: pressure; two: shear) satisfies

    T (B + S) T x = T r + N m,   N' x = 0,   x = 0 out of the zone,   (T6)

with the elastic operator B, the stiffness S of the slip law, the part T across the unit vectors n, and the rigid
motions N of the imposed resultants. Preconditioner (T7), projection (T9) and the steps CG1 to CG6 are those of
docs/theory.md (Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23, 2001). The units are such that the self-coefficient
of a cell and the largest residual are about 1, so single precision suffices at any scale of the problem.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fretsolve.elastic.workspace import Workspace
from fretsolve.kernels import cg
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

Apply = Callable[[FloatArray, FloatArray], None]
"""A linear map of fields (c, nx, ny), ``apply(field, result)``; both may be the same array."""

DEPENDENT_CONSTRAINTS = 1e-6
"""Eigenvalue, over the largest, below which a combination of constraints is ignored: one cell resists no rotation."""

NOTHING_LEFT = 100.0
"""Residual after the projection, in roundings of 1, below which it is only the rounding of a rigid motion."""


class ProjectedCG:
    """Conjugate gradients for fields of one or two components.

    Before `solve`, fill `residual` r (c, nx, ny), `zone` (nx, ny), `weight` W (nx, ny), and with two components
    `stiffness` S (nx, ny) and `normal` n (2, nx, ny), which is 0 where T is 1; then call `constrain`. After `solve`,
    `solution` holds x.
    """

    def __init__(self, workspace: Workspace, components: int = 2):
        self.solution, self.residual = workspace.solution[:components], workspace.residual[:components]
        self._direction, self._image = workspace.direction[:components], workspace.image[:components]
        self.weight = workspace.weight
        vector, shape, dtype = self.solution.shape, self.weight.shape, self.solution.dtype
        alone = len(self.solution) == 1
        self.zone: BoolArray = np.zeros(shape, dtype=bool)
        self.stiffness = np.zeros((1, 1) if alone else shape, dtype)
        self.normal = np.zeros((2, 1, 1) if alone else vector, dtype)
        self._motions = np.zeros((0, *vector), dtype)
        self._constraints, self._moments = self._motions, np.zeros(0)
        self._inverse_gram: FloatArray = np.zeros((0, 0))
        self._nothing_left = NOTHING_LEFT * float(np.finfo(dtype).eps)

    def constrain(self, modes: Sequence[int], motion: Callable[[int, FloatArray], None]) -> None:
        """Keep the solution orthogonal to rigid motions; ``motion(mode, out)`` writes one of them (c, nx, ny)."""
        if len(self._motions) < len(modes):
            self._motions = np.zeros((len(modes), *self.solution.shape), self.solution.dtype)
        self._constraints = self._motions[: len(modes)]
        self._moments = np.zeros(len(modes))
        self._direction[:] = 0.0
        gram: DoubleArray = np.zeros((len(modes), len(modes)))  # symmetric, so its lower half is enough
        for row, (mode, constraint) in enumerate(zip(modes, self._constraints, strict=True)):
            motion(mode, constraint)
            constraint /= cg.largest(constraint) or 1.0
            self._restrict(constraint)
            cg.weigh_moments(constraint, self.weight, self._constraints[: row + 1], gram[row, : row + 1])
        if len(modes) == 1:
            self._inverse_gram = np.divide(1.0, gram, out=np.zeros_like(gram), where=gram > 0.0)
        elif modes:
            self._inverse_gram = _pseudo_inverse(gram)

    def solve(self, elastic: Apply, inverse: Apply, reduction: float, floor: float, limit: int) -> int:
        """Reduce the largest length of the residual by `reduction`, or to `floor`, in at most `limit` iterations.

        elastic: the operator B; inverse: its preconditioner F. Returns the number of iterations, at least one.
        """
        # symbols of docs/theory.md; z and w share an array
        x, r, d, z = self.solution, self.residual, self._direction, self._image
        n, zone, weight, c, moments = self.normal, self.zone, self.weight, self._constraints, self._moments
        w = z
        # CG1: x = d = 0, r = P T r in the zone, by the projection P of (T9); as d = 0, the kernel of CG5 does P alone
        x[:] = 0.0
        d[:] = 0.0
        self._restrict(r)
        cg.weigh_moments(r, weight, c, moments)
        first = cg.advance(x, r, d, d, c, -self._amplitudes(), 1.0)
        if first < self._nothing_left:
            return 1
        target, rho_before, iteration = max(reduction * first, floor), 1.0, 0
        while iteration < limit:
            # CG2: z = M r (T7), rho = r.z
            np.multiply(r, weight, out=z)
            inverse(z, z)
            rho = cg.finish_search(z, r, weight, n, c, moments)
            if not rho > 0.0:
                break
            # CG3: d = P' z + (rho / rho before) d
            cg.turn(d, z, weight, c, self._amplitudes(), rho / rho_before)
            rho_before = rho
            # CG4: w = T (B + S) d in the zone (T6), kappa = d.w
            elastic(d, w)
            kappa = cg.finish_image(w, d, self.stiffness, n, zone, weight, c, moments)
            if not kappa > 0.0:
                break
            # CG5: alpha = rho / kappa, x = x + alpha d, r = r - alpha P w; CG6: stop at the target
            iteration += 1
            if cg.advance(x, r, d, w, c, self._amplitudes(), rho / kappa) <= target:
                break
        return max(iteration, 1)

    def _restrict(self, field: FloatArray) -> None:
        """Compute T field in the zone, 0 outside, in place. As d is 0, the kernel of CG4 does that."""
        none = self._motions[:0], np.zeros(0)
        cg.finish_image(field, self._direction, self.stiffness, self.normal, self.zone, self.weight, *none)

    def _amplitudes(self) -> DoubleArray:
        """Return (c' W c)^-1 times the moments found last, (T9)."""
        return self._inverse_gram @ self._moments if len(self._moments) else self._moments


def _pseudo_inverse(gram: DoubleArray) -> DoubleArray:
    """Return the inverse of a symmetric matrix on the combinations that count; only its lower half is read.

    NumPy's `pinv` takes five times as long, more than an iteration on a small grid.
    """
    values, vectors = np.linalg.eigh(gram)
    counts = values > DEPENDENT_CONSTRAINTS * values[-1]
    inverse: DoubleArray = (vectors[:, counts] / values[counts]) @ vectors[:, counts].T
    return inverse
