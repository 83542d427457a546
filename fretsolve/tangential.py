"""The tangential contact problem: shear, stick and slip at a given pressure [2.3].

    s = c + rigid motion - B q,   |q| <= bound,   s = 0 where |q| < bound,   q = bound s/|s| where s != 0,

s the slip increment of body 1 relative to body 2, B the tangential elastic operator, `bound` = mu p, and c what is
known beforehand: the elastic displacement at the increment's start less what the pressure causes now. The
rigid motion is (delta_x - phi_z y, delta_y + phi_z x) over the increment; each of its three parts is imposed
or belongs to an imposed Qx, Qy, Mz. It is a convex quadratic program: its solution is unique.

A semismooth Newton method with conjugate gradients inside. At fixed zones, with n = q/|q| and lam = s.n on the
slip zone, the Newton equation is T (B + lam/bound) T dq = T s, T taking the part tangential to the friction
circle [28]. lam/bound grows without limit towards the contact's edge, so CG is preconditioned by
W F W + (1 - W^2)/(k0 + lam/bound) with F the inverse of B's symbol in the half-space, W = k0/(k0 + lam/bound) and
k0 about the self-coefficient of a cell: F in the stick zone, the diagonal deep in the slip zone. It is constrained to
the balance equations. Then shear beyond the bound is put back on the circle and slips, and slipping cells with
lam < 0 stick.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.certificate import LEAST_SLIP
from fretsolve.elastic import ElasticOperator
from fretsolve.grid import Grid
from fretsolve.modes import TINY, Balance, TangentialModes, Vector, solve_modes

FloatArray = NDArray[np.floating]
BoolArray = NDArray[np.bool_]

REDUCTION = 0.3
"""By how much CG reduces the residual at fixed zones before the zones are looked at again."""

SELF_COEFFICIENTS = 2.0
"""k0 in units of the self-coefficient of a cell; from one to three the iterations hardly differ."""

STIFFEST = 1e12
"""Limit of lam/bound in units of k0: beyond it a cell does not move in double precision anyway."""

@dataclass(frozen=True)
class TangentialResult:
    """rigid: increments of (delta_x, delta_y, phi_z); residual: largest violation of the slip law over `scale`."""

    rigid: Vector
    iterations: int
    residual: float
    converged: bool


class TangentialSolver:
    """Working arrays of the tangential problem on one grid; `solve` may be called any number of times."""

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator = operator
        self.modes = TangentialModes(grid)
        vector, shape = (2, *grid.shape), grid.shape
        self.displacement = np.zeros(vector)
        self._slip, self._normal, self._direction, self._image, self._search = (
            np.zeros(vector) for _ in range(5)
        )
        self._length, self._weight, self._stiffness = (np.zeros(shape) for _ in range(3))
        self._scratch = np.zeros(shape)
        self._contact: BoolArray = np.zeros(shape, dtype=bool)
        self.slipping: BoolArray = np.zeros(shape, dtype=bool)
        self._gram = np.zeros((3, 3))
        self._self_coefficient = SELF_COEFFICIENTS * operator.tangential_self_coefficient
        self._reach = max(grid.size) / 2.0

    def solve(
        self,
        known: FloatArray,
        balance: Balance,
        bound: FloatArray,
        shear: FloatArray,
        tolerance: float,
        max_iterations: int,
        motion: float,
    ) -> TangentialResult:
        """Solve in place for `shear` (2, nx, ny), which holds the first estimate; `slipping` tells its slip zone.

        known: c above, (2, nx, ny), mm; balance: of (Qx|delta_x, Qy|delta_y, Mz|phi_z), displacements as increments;
        bound: friction coefficient times pressure, (nx, ny), MPa; tolerance: on the residual;
        max_iterations: of CG; motion: largest rigid displacement increment known so far (mm), which scales
        the residual together with those found. On return `displacement` holds B q and `slipping` the slip zone.
        """
        iterations, passes = 0, 0
        self._start_zones(balance, bound, shear)
        self.operator.tangential(shear, self.displacement)
        while True:
            rigid = self._update_slip_and_zones(known, balance, bound, shear)
            residual, scale = self._violation(rigid, motion)
            unsettled = max(self._unbalance(balance, bound, shear), self._excess(bound, shear))
            if residual <= tolerance and unsettled <= tolerance:
                return TangentialResult(rigid, iterations, residual, True)
            if iterations >= max_iterations or passes >= max_iterations:
                return TangentialResult(rigid, iterations, residual, False)
            if residual > tolerance:
                floor = 0.3 * tolerance * scale
                iterations += self._newton_step(balance, shear, floor, max_iterations - iterations)
            self._return_to_circle(bound, shear)
            self._restore_balance(balance, self._weight, shear)
            self.operator.tangential(shear, self.displacement)
            passes += 1

    def _start_zones(self, balance: Balance, bound: FloatArray, shear: FloatArray) -> None:
        """Contact is where friction can carry shear. What is missing of the load goes where it can be borne."""
        np.greater(bound, 0.0, out=self._contact)
        shear *= self._contact
        self.slipping &= self._contact
        self._start_fresh_cells(bound, shear)
        self._normal[:] = 0.0
        self._stiffness[:] = 0.0
        self._return_to_circle(bound, shear)
        self._restore_balance(balance, bound, shear)
        self._return_to_circle(bound, shear)
        self._update_weight(balance)

    def _start_fresh_cells(self, bound: FloatArray, shear: FloatArray) -> None:
        """Cells new in contact slip like their neighbours; they lie at the contact's edge, where all slips."""
        fresh = self._contact & ~shear.any(axis=0)
        at = np.nonzero(fresh)
        if at[0].size == 0 or at[0].size == np.count_nonzero(self._contact):
            return
        padded = np.pad(shear, [(0, 0), (1, 1), (1, 1)])
        around = np.zeros((2, at[0].size))
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                around += padded[:, at[0] + 1 + i, at[1] + 1 + j]
        length = np.hypot(around[0], around[1])
        moved = length > 0.0
        cells = (at[0][moved], at[1][moved])
        shear[:, cells[0], cells[1]] = around[:, moved] / length[moved] * bound[cells]
        self.slipping[cells] = True

    def _update_weight(self, balance: Balance) -> None:
        """Preconditioner on the contact, and the Gram matrix of the forced modes in it."""
        np.add(self._stiffness, self._self_coefficient, out=self._weight)
        np.divide(self._contact, self._weight, out=self._weight)
        self._gram = self._weighted_gram(balance, self._weight)

    def _weighted_gram(self, balance: Balance, weight: FloatArray) -> NDArray[np.float64]:
        """Sums of products of the forced modes' tangential parts."""
        gram = np.zeros((3, 3))
        for mode in balance.forced_index:
            self.modes.displacement(np.eye(3)[mode], self._search)
            self._take_tangential(self._search)
            self._search *= weight
            gram[mode] = self.modes.sums(self._search)
        return gram

    def _take_tangential(self, field: FloatArray) -> None:
        """Remove the part of `field` (2, nx, ny) along the shear in the slip zone."""
        np.einsum("kij,kij->ij", field, self._normal, out=self._length)
        for part, normal in zip(field, self._normal, strict=True):
            part -= np.multiply(normal, self._length, out=self._scratch)

    def _update_slip_and_zones(
        self, known: FloatArray, balance: Balance, bound: FloatArray, shear: FloatArray
    ) -> Vector:
        """Slip with the forced rigid motion by weighted least squares; slipping cells moved backwards stick [44]."""
        slip, contact = self._slip, self._contact
        imposed = balance.imposed_displacement
        self.modes.displacement(imposed, slip)
        slip += known
        slip -= self.displacement
        slip *= contact
        np.copyto(self._search, slip)
        self._take_tangential(self._search)
        self._search *= self._weight
        forced = -solve_modes(self._gram, self.modes.sums(self._search), balance.forced_index)
        self.modes.displacement(forced, self._search)
        self._search *= contact
        slip += self._search
        forward = np.einsum("kij,kij->ij", slip, self._normal, out=self._stiffness)
        self.slipping &= forward > 0.0
        self._normal *= self.slipping
        forward *= self.slipping
        np.divide(forward, bound, out=forward, where=self.slipping)
        np.minimum(forward, STIFFEST * self._self_coefficient, out=forward)
        self._update_weight(balance)
        return imposed + forced

    def _violation(self, rigid: Vector, motion: float) -> tuple[float, float]:
        """Largest |slip| in the stick zone over the motion, or part of it across the shear over the largest slip.

        Also the smaller one of the two lengths (mm).
        """
        scale = max(motion, abs(rigid[0]), abs(rigid[1]), abs(rigid[2]) * self._reach, TINY)
        np.copyto(self._search, self._slip)
        self._take_tangential(self._search)
        squared = np.einsum("kij,kij->ij", self._slip, self._slip, out=self._length)
        largest = max(np.sqrt(squared.max()), LEAST_SLIP * scale)
        across = np.einsum("kij,kij->ij", self._search, self._search, out=self._length)
        in_slip = np.sqrt(np.max(across, where=self.slipping, initial=0.0))
        in_stick = np.sqrt(np.max(across, where=~self.slipping, initial=0.0))
        return float(max(in_stick / scale, in_slip / largest)), float(min(scale, largest))

    def _unbalance(self, balance: Balance, bound: FloatArray, shear: FloatArray) -> float:
        """Worst imposed resultant's error over what friction could carry."""
        if not balance.forced_index:
            return 0.0
        error = np.abs(self.modes.resultants(shear) - balance.imposed_resultant)
        capacity = float(bound.sum(dtype=np.float64)) * self.modes.cell_area or TINY
        return float(np.max((error / (capacity * np.array([1.0, 1.0, self._reach])))[balance.forced_index]))

    def _excess(self, bound: FloatArray, shear: FloatArray) -> float:
        """Largest excess of |shear| over the bound, over the largest bound."""
        length = np.hypot(shear[0], shear[1], out=self._length)
        length -= bound
        return float(length.max()) / (float(bound.max()) or TINY)

    def _newton_step(self, balance: Balance, shear: FloatArray, floor: float, limit: int) -> int:
        """CG on the Newton equation at fixed zones until its residual is reduced, or below `floor` (mm)."""
        residual, direction, image = self._slip, self._direction, self._image
        self._take_tangential(residual)
        target = max(REDUCTION * self._largest(residual), floor)
        direction[:] = 0.0
        previous, iteration = 1.0, 0
        while iteration < limit:
            self._precondition(balance)
            current = float(np.vdot(residual, self._search))
            if not current > 0.0:
                break
            direction *= current / previous
            direction += self._search
            previous = current
            self.operator.tangential(direction, image)
            for part, along in zip(image, direction, strict=True):
                part += np.multiply(self._stiffness, along, out=self._scratch)
            curvature = float(np.vdot(direction, image))
            if not curvature > 0.0:
                break
            step = current / curvature
            np.multiply(direction, step, out=self._search)
            shear += self._search
            image *= step
            image *= self._contact
            self._take_tangential(image)
            residual -= image
            iteration += 1
            if self._largest(residual) <= target:
                break
        return max(iteration, 1)

    def _largest(self, field: FloatArray) -> float:
        """Largest length of a vector of the field."""
        return float(np.sqrt(np.einsum("kij,kij->ij", field, field, out=self._length).max()))

    def _precondition(self, balance: Balance) -> None:
        """`_search` from the residual, tangential and in balance; the residual loses its forced rigid motion."""
        residual, image, search = self._slip, self._image, self._search
        if balance.forced_index:
            np.multiply(residual, self._weight, out=image)
            self._rigid_pattern(self.modes.sums(image), balance, image)
            residual -= image
        np.multiply(residual, self._weight, out=image)
        image *= self._self_coefficient
        self.operator.tangential_inverse(image, search)
        search *= self._weight
        search *= self._self_coefficient
        self._take_tangential(search)
        np.multiply(self._weight, self._self_coefficient, out=self._scratch)
        np.multiply(self._scratch, self._scratch, out=self._scratch)
        np.subtract(1.0, self._scratch, out=self._scratch)
        self._scratch *= self._weight
        np.multiply(residual, self._scratch, out=image)
        search += image
        if balance.forced_index:
            self._rigid_pattern(self.modes.sums(search), balance, image)
            image *= self._weight
            search -= image

    def _rigid_pattern(self, resultant: Vector, balance: Balance, out: FloatArray) -> None:
        """The forced rigid motion, tangential and in the contact, whose weighted resultant is `resultant`."""
        self.modes.displacement(solve_modes(self._gram, resultant, balance.forced_index), out)
        out *= self._contact
        self._take_tangential(out)

    def _return_to_circle(self, bound: FloatArray, shear: FloatArray) -> None:
        """Shear beyond the bound slips; in the slip zone the shear goes back to the friction circle."""
        length = np.hypot(shear[0], shear[1], out=self._length)
        self.slipping |= length > bound
        self.slipping &= self._contact
        np.divide(1.0, length, out=length, where=length > 0.0)
        np.multiply(shear, length, out=self._normal)
        self._normal *= self.slipping
        for part, normal in zip(shear, self._normal, strict=True):
            np.multiply(normal, bound, out=part, where=self.slipping)

    def _restore_balance(self, balance: Balance, weight: FloatArray, shear: FloatArray) -> None:
        """Add the weighted rigid pattern, tangential in the slip zone, that makes the imposed resultants hold [45]."""
        forced = balance.forced_index
        if not forced:
            return
        missing = balance.imposed_resultant - self.modes.resultants(shear)
        self._gram = self._weighted_gram(balance, weight)
        amplitudes = solve_modes(self._gram, missing / self.modes.cell_area, forced)
        self.modes.displacement(amplitudes, self._search)
        self._take_tangential(self._search)
        self._search *= weight
        shear += self._search
