"""Conjugate gradients for the linear equations of contact at fixed zones; the imposed loads are kept.

The correction x of a traction (one component: pressure; two: shear) satisfies

    T (B + S) T x = T r + N m,   N' x = 0,   x = 0 out of the zone,   (T6)

with the elastic operator B, the stiffness S of the slip law, the part T across the unit vectors n, and the rigid
motions N of the imposed resultants. docs/theory.md describes the preconditioner (T7), the projection (T9) and the steps
CG1 to CG6 (Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23, 2001). The units are such that the self-coefficient of a
cell and the largest residual are about 1, so single precision suffices at any scale of the problem.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fretsolve.contact.kernels import ON_ANY_GRID, GridKernels
from fretsolve.contact.kernels.cg import diagonal, share
from fretsolve.contact.solvers.incremental_update import Workspace
from fretsolve.contact.solvers.rigid_modes import SINGLE_MODES, inverse_of
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, Products, Sums, Vector

Apply = Callable[[FloatArray, FloatArray], None]
"""A linear map of fields (c, nx, ny), ``apply(field, result)``; both may be the same array."""

Springs = tuple[list[int], DoubleArray]
"""The modes of a rig that gives way, and its compliance (3, 3)."""

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

    def __init__(self, workspace: Workspace, components: int = 2, kernels: GridKernels = ON_ANY_GRID):
        self._kernels = kernels.cg
        self.solution, self.residual = workspace.solution[:components], workspace.residual[:components]
        self._direction, self._image = workspace.direction[:components], workspace.image[:components]
        self._displacement, self._moved = workspace.displacement[:components], workspace.moved[:components]
        self.weight = workspace.weight
        vector, shape, dtype = self.solution.shape, self.weight.shape, self.solution.dtype
        alone = len(self.solution) == 1
        self.zone: BoolArray = np.zeros(shape, dtype=bool)
        self.stiffness = np.zeros((1, 1) if alone else shape, dtype)
        self.normal = np.zeros((2, 1, 1) if alone else vector, dtype)
        self._all_constraints = np.zeros((0, *vector), dtype)
        self._constraints, self._inverse_gram = self._all_constraints, np.zeros((0, 0))
        self._springs: _Springs | None = None
        self._nothing_left = NOTHING_LEFT * float(np.finfo(dtype).eps)

    @property
    def found(self) -> tuple[FloatArray, FloatArray]:
        """The solution x and B x, (c, nx, ny) each; both hold until the workspace has another use."""
        return self.solution, self._displacement

    def constrain(self, motions: Sequence[Sums], x: FloatArray, y: FloatArray, springs: Springs | None = None) -> None:
        """Keep the solution orthogonal to m rigid motions, each of three amplitudes (a, b, c).

        With one component they are a + b y + c x, with two (a - c y, b + c x); x (nx,), y (ny,): centres of the cells,
        in order. springs: as from `springs_of`.
        """
        sprung, compliance = ([], None) if springs is None else springs
        motions = [*motions, *(SINGLE_MODES[mode] for mode in sprung)]
        count = len(motions)
        if len(self._all_constraints) < count:
            self._all_constraints = np.zeros((count, *self.solution.shape), self.solution.dtype)
        self._constraints, self._inverse_gram, self._springs = self._all_constraints[:count], np.zeros((0, 0)), None
        if count:
            scaled = np.array([_scaled(motion, x, y, len(self.solution)) for motion in motions])
            gram = self._kernels.constrain(self._constraints, scaled, x, y, self.normal, self.zone, self.weight)
            self._inverse_gram = _pseudo_inverse(gram, count - len(sprung))
            if compliance is not None:
                sizes = np.array([1.0 / row[mode] for row, mode in zip(scaled[-len(sprung) :], sprung, strict=True)])
                block = compliance[np.ix_(sprung, sprung)] * np.outer(sizes, sizes)
                self._springs = _Springs(self._constraints, np.array(gram)[:count, :count], self._inverse_gram, block)
                self._sizes = dict(zip(sprung, sizes, strict=True))

    def push(self, motion: Vector) -> None:
        """Add the sprung modes of a motion (3,), over the unit of the residual, to the residual in the zone."""
        assert self._springs is not None
        for (mode, size), constraint in zip(self._sizes.items(), self._springs.sprung, strict=True):
            self.residual += self.residual.dtype.type(size * motion[mode]) * constraint

    def solve(self, elastic: Apply, inverse: Apply, reduction: float, floor: float, limit: int) -> int:
        """Reduce the largest length of the residual by `reduction`, or to `floor`, in at most `limit` iterations.

        elastic: the operator B; inverse: its preconditioner F. Returns the number of iterations, at least one.
        """
        # symbols of docs/theory.md; z and w share an array
        x, r, d, z = self.solution, self.residual, self._direction, self._image
        n, zone, s, weight, c, inverse_gram = (
            self.normal,
            self.zone,
            self.stiffness,
            self.weight,
            self._constraints,
            self._inverse_gram,
        )
        u, b_d, w, cg = self._displacement, self._moved, z, self._kernels
        springs = self._springs
        if springs is not None:
            inverse_gram = springs.softened(self._stiffness_of(springs, inverse))
        # CG1: x = d = 0, u = B x = 0, r = P T r in the zone, by the projection P of (T9); z = V r
        first = cg.start(x, u, d, r, z, s, n, zone, weight, c, inverse_gram)
        if first < self._nothing_left:
            return 1
        target, rho_before, iteration = max(reduction * first, floor), 1.0, 0
        while iteration < limit:
            # CG2, CG3: z = M r (T7), rho = r.z, d = P' z + (rho / rho before) d
            inverse(z, z)
            rho = cg.search(z, d, r, weight, n, c, inverse_gram, rho_before)
            if not rho > 0.0:
                break
            rho_before = rho
            # CG4, CG5: w = T (B + S) d in the zone (T6), kappa = d.w, alpha = rho / kappa, x = x + alpha d,
            # u = u + alpha B d, r = r - alpha P w; z = V r for the next iteration
            elastic(d, b_d)
            if springs is not None:
                springs.give_way(d, b_d)
            kappa, largest = cg.step(x, u, r, d, b_d, w, s, n, zone, weight, c, inverse_gram, rho)
            if not kappa > 0.0:
                break
            # CG6: stop at the target
            iteration += 1
            if largest <= target:
                break
        if springs is not None:  # u is B x alone
            springs.give_way(x, u, -1.0)
        return max(iteration, 1)

    def _stiffness_of(self, springs: _Springs, inverse: Apply) -> DoubleArray:
        """Return the loads that the preconditioner (T7) takes for displacements along each sprung motion, (k, k)."""
        z, within = self._image, share(self.weight) if len(self._image) == 2 else self.weight
        loads = []
        for constraint in springs.sprung:
            z[:] = within * constraint
            inverse(z, z)
            z *= within
            if len(z) == 2:
                z += diagonal(self.weight, within) * constraint
            loads.append([_product(other, z) for other in springs.sprung])
        stiffness: DoubleArray = np.array(loads)
        stiffness += stiffness.T.copy()
        return 0.5 * stiffness


def springs_of(control: LoadControl, scale: float) -> Springs | None:
    """Return the modes of a rig that gives way, and its compliance (3, 3) times `scale`; None without a rig."""
    return None if control.compliance is None else (control.sprung_index, scale * control.matrix)


class _Springs:
    """A rig in series: the surfaces give way by its compliance times the resultants of the traction.

    constraints: T N of the m imposed resultants, then of the k sprung motions, (m + k, c, nx, ny); gram: c' W c;
    inverse_gram: of the imposed resultants, (m, m); compliance: of the sprung motions, (k, k), in the units of the
    inner iterations.
    """

    def __init__(self, constraints: FloatArray, gram: DoubleArray, inverse_gram: DoubleArray, compliance: DoubleArray):
        self.count = len(inverse_gram)
        self.sprung, self._gram, self._inverse_gram = constraints[self.count :], gram, inverse_gram
        self._compliance = compliance

    def give_way(self, traction: FloatArray, displacement: FloatArray, sign: float = 1.0) -> None:
        """Add `sign` N C N' times a traction to a displacement, both (c, nx, ny)."""
        loads = [_product(motion, traction) for motion in self.sprung]
        for motion, amplitude in zip(self.sprung, (sign * self._compliance @ loads).tolist(), strict=True):
            displacement += displacement.dtype.type(amplitude) * motion

    def softened(self, stiffness: DoubleArray) -> DoubleArray:
        """Return the matrix A, (m + k, m + k), with which P = 1 - c A c' W (T9) preconditions a contact on springs.

        An imposed resultant leaves nothing of a residual along its motion, an imposed displacement all of it, and a
        spring (1 + E C)^-1/2, with the stiffness E of the contact: so P' M P is there (E^-1 + C)^-1, about the inverse
        of contact and rig in series.
        """
        m, forced = self.count, self._inverse_gram
        # the sprung motions less their parts along the motions of imposed resultants, and of length 1
        parts = -forced @ self._gram[:m, m:]
        rest = self._gram[m:, m:] + self._gram[m:, :m] @ parts
        values, vectors = np.linalg.eigh(rest)
        counts = values > DEPENDENT_CONSTRAINTS * self._gram.diagonal().max()
        unit = vectors[:, counts] / np.sqrt(values[counts])
        along = rest @ unit
        # E and C of these, and 1 - (1 + E C)^-1/2
        root = np.sqrt(np.maximum(np.einsum("ik,ij,jk->k", unit, stiffness, unit), 0.0))
        in_series = np.eye(root.size) + root[:, None] * (along.T @ self._compliance @ along) * root
        lengths, turned = np.linalg.eigh(in_series)
        held = np.eye(root.size) - (turned / np.sqrt(lengths)) @ turned.T
        found = np.zeros((len(self._gram), len(self._gram)))
        found[:m, :m] = forced
        whole = np.concatenate([parts, np.eye(len(rest))]) @ unit
        found += whole @ held @ whole.T
        return found


def _product(one: FloatArray, other: FloatArray) -> float:
    """Return the sum of the products in all cells, in double precision."""
    return float(np.einsum("kij,kij->", one, other, dtype=np.float64))


def _scaled(motion: Sums, x: FloatArray, y: FloatArray, components: int) -> Sums:
    """Return a rigid motion over its largest displacement, which it has at a corner of the grid."""
    a, b, c = motion
    if not c and (components == 2 or not b):
        largest = max(abs(a), abs(b))  # the same in all cells
    else:
        ends_x, ends_y = (float(x[0]), float(x[-1])), (float(y[0]), float(y[-1]))
        if components == 1:
            largest = max(abs(a + b * y_end + c * x_end) for y_end in ends_y for x_end in ends_x)
        else:
            largest = max(*(abs(a - c * y_end) for y_end in ends_y), *(abs(b + c * x_end) for x_end in ends_x))
    largest = largest or 1.0
    return a / largest, b / largest, c / largest


def _pseudo_inverse(gram: Products, count: int) -> DoubleArray:
    """Return the inverse of the first `count` rows and columns of a symmetric matrix on the combinations that count."""
    inverse = inverse_of(gram, range(count))
    if inverse is not None:
        return np.array(inverse)
    if count < 2:
        return np.zeros((count, count))
    values, vectors = np.linalg.eigh(np.array(gram)[:count, :count])
    counts = values > DEPENDENT_CONSTRAINTS * values[-1]
    pseudo: DoubleArray = (vectors[:, counts] / values[counts]) @ vectors[:, counts].T
    return pseudo
