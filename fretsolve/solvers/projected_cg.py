"""Conjugate gradients for the linear equations of contact at fixed zones, with imposed resultants kept.

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

DEPENDENT = 1e-6
"""Eigenvalue, over the largest, at which a combination of constraints counts as none: one cell resists no rotation."""

NOTHING_LEFT = 100.0
"""In roundings of 1: a residual below it after the projection is the rounding of a rigid motion."""


class ProjectedCG:
    """Conjugate gradients for fields of one or two components.

    Before `solve`, fill `residual` r (c, nx, ny), `zone` (nx, ny), `weight` W (nx, ny), and with two components
    `stiffness` S (nx, ny) and `normal` n (2, nx, ny), which is 0 where T takes all; then call `constrain`. After it
    `solution` holds x.
    """

    def __init__(self, workspace: Workspace):
        self.solution, self.residual, self.weight = workspace.solution, workspace.residual, workspace.weight
        self._direction, self._image = workspace.direction, workspace.image
        vector, shape, dtype = self.solution.shape, self.weight.shape, self.solution.dtype
        alone = len(self.solution) == 1
        self.zone: BoolArray = np.zeros(shape, dtype=bool)
        self.stiffness = np.zeros((1, 1) if alone else shape, dtype)
        self.normal = np.zeros((2, 1, 1) if alone else vector, dtype)
        self._motions = np.zeros((0, *vector), dtype)
        self._constraints, self._moments = self._motions, np.zeros(0)
        self._inverse_gram: FloatArray = np.zeros((0, 0))

    def constrain(self, modes: Sequence[int], motion: Callable[[int, FloatArray], None]) -> None:
        """Keep the solution orthogonal to rigid motions; ``motion(mode, out)`` writes one of them (c, nx, ny)."""
        if len(self._motions) < len(modes):
            self._motions = np.zeros((len(modes), *self.solution.shape), self.solution.dtype)
        self._constraints = self._motions[: len(modes)]
        self._moments = np.zeros(len(modes))
        for mode, constraint in zip(modes, self._constraints, strict=True):
            motion(mode, constraint)
            constraint /= float(np.abs(constraint).max()) or 1.0
            cg.restrict(constraint, self.normal, self.zone)
        gram: DoubleArray = np.zeros((len(modes), len(modes)))
        for row, constraint in zip(gram, self._constraints, strict=True):
            cg.weigh_moments(constraint, self.weight, self._constraints, row)
        if len(modes) == 1:
            self._inverse_gram = np.divide(1.0, gram, out=np.zeros_like(gram), where=gram > 0.0)
        elif modes:
            self._inverse_gram = np.linalg.pinv(gram, rcond=DEPENDENT, hermitian=True)

    def solve(self, elastic: Apply, inverse: Apply, reduction: float, floor: float, limit: int) -> int:
        """Reduce the largest length of the residual by `reduction`, or to `floor`, in at most `limit` iterations.

        elastic: the operator B; inverse: its preconditioner F. Returns the number of iterations, at least one.
        """
        # CG1: r = T r - N m with N' W r = 0, x = d = 0
        first = self._project_residual()
        target = max(reduction * first, floor)
        previous, iteration = 1.0, 0
        if first < NOTHING_LEFT * float(np.finfo(self.solution.dtype).eps):
            return 1
        while iteration < limit:
            # CG2: z = M r, rho = r.z
            current = self._precondition(inverse)
            if not current > 0.0:
                break
            # CG3: d = z - W N m + (rho / previous rho) d, with N' d = 0
            cg.turn(
                self._direction, self._image, self.weight, self._constraints, self._amplitudes(), current / previous
            )
            previous = current
            # CG4: w = T (B + S) d, kappa = d.w
            elastic(self._direction, self._image)
            curvature = self._finish_image()
            if not curvature > 0.0:
                break
            # CG5, CG6: x = x + alpha d, r = r - alpha (w - N m) with alpha = rho / kappa, until r is small enough
            iteration += 1
            if self._step(current / curvature) <= target:
                break
        return max(iteration, 1)

    def _project_residual(self) -> float:
        """Make the residual tangential and orthogonal to the constraints; return its largest length."""
        self.solution[:] = 0.0
        self._direction[:] = 0.0
        cg.restrict(self.residual, self.normal, self.zone)
        cg.weigh_moments(self.residual, self.weight, self._constraints, self._moments)
        return cg.remove(self.residual, self._constraints, self._amplitudes())

    def _amplitudes(self) -> DoubleArray:
        """Return the amplitudes m of the constraints' motions from the moments found last."""
        return self._inverse_gram @ self._moments if len(self._moments) else self._moments

    def _precondition(self, inverse: Apply) -> float:
        """Write the preconditioned residual into the image; return its product with the residual."""
        np.multiply(self.residual, self.weight, out=self._image)
        inverse(self._image, self._image)
        return cg.finish_search(
            self._image, self.residual, self.weight, self.normal, self._constraints, self._moments
        )

    def _finish_image(self) -> float:
        """Turn B d in the image into T (B + S) d; return its product with d."""
        stiffness, normal, moments = self.stiffness, self.normal, self._moments
        return cg.finish_image(
            self._image, self._direction, stiffness, normal, self.zone, self.weight, self._constraints, moments
        )

    def _step(self, length: float) -> float:
        """Step along the direction, with the residual kept orthogonal to the constraints; return its largest length."""
        constraints, amplitudes = self._constraints, self._amplitudes()
        return cg.advance(
            self.solution, self.residual, self._direction, self._image, constraints, amplitudes, length
        )
