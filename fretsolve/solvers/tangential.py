"""The tangential contact problem: shear, stick and slip at a given pressure [2.3].

    s = e + rigid motion,   |q| <= bound,   s = 0 where |q| < bound,   q = bound s/|s| where s != 0,

s the slip increment of body 1 relative to body 2, `bound` = mu p, and e the elastic slip: by how much the tangential
elastic displacement has become less since the increment's start. It follows the shear; a change dq adds -B dq to it,
B the tangential elastic operator. The rigid motion is (delta_x - phi_z y, delta_y + phi_z x) over the increment;
each of its three parts is imposed or belongs to an imposed Qx, Qy, Mz. It is a convex quadratic program: its solution
is unique.

A semismooth Newton method with conjugate gradients inside. At fixed zones, with n = q/|q| and lam = s.n on the
slip zone, the Newton equation is T (B + lam/bound) T dq = T s, T taking the part tangential to the friction
circle [28]; `projected_cg` solves it in the balance of forces. Then shear beyond the bound is put back on
the circle and slips, and slipping cells with lam < 0 stick.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.incremental_update import Room
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP, ROUNDING, TINY, rounding_of
from fretsolve.kernels import cg, friction
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.projected_cg import ProjectedCG, Space
from fretsolve.solvers.rigid_modes import TangentialModes, is_singular, solve_modes
from fretsolve.system.arrays import BoolArray, FloatArray, Vector

REDUCTION = 0.1
"""By how much CG reduces the residual at fixed zones before the zones are looked at again."""

STIFFEST = 1e25
"""Limit of lam/bound in units of the inner iterations, within single precision with room for products."""

PATIENCE = 5
"""Passes without halving the residual after which it is asked whether it is down to rounding ..."""

STALLED = 100
"""... and after which the zones go round in a circle, as they may where next to nothing sticks."""


@dataclass(frozen=True)
class TangentialResult:
    """rigid: increments of (delta_x, delta_y, phi_z); residual: largest violation of the slip law over its scale;
    least_scale: the smaller one of the lengths that this is (mm); converged: to the tolerance, or to rounding."""

    rigid: Vector
    iterations: int
    residual: float
    least_scale: float
    converged: bool


@dataclass(frozen=True)
class SlipScales:
    """What slips count against in the increment that a solve is a part of.

    last_tolerance: of the solves that go on from its elastic slip, for which the rounding must be small enough;
    least_scale: that of the last result (mm), 0 before the first; least_slip: that slips count by at least (mm);
    displacement: the largest one that the elastic slip is the change of (mm).
    """

    last_tolerance: float
    least_scale: float = 0.0
    least_slip: float = 0.0
    displacement: float = 0.0


class TangentialSolver:
    """Working arrays of the tangential problem on one grid; `solve` may be called any number of times."""

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator = operator
        self.modes = TangentialModes(grid)
        vector, shape = (2, *grid.shape), grid.shape
        self._slip, self._normal = (np.zeros(vector) for _ in range(2))
        self._cg = ProjectedCG(2, shape, operator.inner.dtype)
        self._contact = self._cg.zone
        self._update = operator.incremental_tangential
        self.slipping: BoolArray = np.zeros(shape, dtype=bool)
        self._gram, self._sums = np.zeros((3, 3)), np.zeros(3)
        self._reach = max(grid.size) / 2.0

    @property
    def space(self) -> Space:
        """Arrays that hold nothing between solves."""
        shape, dtype = self._contact.shape, self.operator.inner.dtype
        return Space(self._slip, ProjectedCG(1, shape, dtype, lender=self._cg))

    @property
    def room(self) -> Room:
        """The same for the change of a traction."""
        return Room(self._slip, self._cg.spare)

    def solve(
        self,
        elastic_slip: FloatArray,
        control: LoadControl,
        bound: FloatArray,
        shear: FloatArray,
        tolerance: float,
        max_iterations: int,
        motion: float,
        scales: SlipScales | None = None,
    ) -> TangentialResult:
        """Solve in place for `shear` (2, nx, ny), which holds the first estimate; `slipping` tells its slip zone.

        elastic_slip: e above at the first estimate, (2, nx, ny), mm, changed in place with the shear; balance: of
        (Qx|delta_x, Qy|delta_y, Mz|phi_z), displacements as increments; bound: friction coefficient times pressure,
        (nx, ny), MPa; tolerance: on the residual; max_iterations: of CG; motion: largest rigid displacement increment
        known so far (mm), which scales the residual together with those found. On return `slipping` tells the slip
        zone.
        """
        scales = scales or SlipScales(tolerance)
        iterations = 0
        least, since, unborne = np.inf, 0, 0
        np.copyto(self._slip, shear)
        self._start_zones(control, bound, shear)
        self._follow(elastic_slip, shear, scales.last_tolerance * scales.least_scale, 0.0)
        while True:
            rigid = self._update_slip_and_zones(elastic_slip, control, bound)
            residual, largest, scale = self._violation(rigid, motion, scales.least_slip)
            least, since = (residual, 0) if residual < 0.5 * least else (least, since + 1)
            excess = self._excess(bound, shear)
            unsettled = max(self._unbalance(control, bound, shear), excess)
            if residual <= tolerance and unsettled <= tolerance:
                return TangentialResult(rigid, iterations, residual, scale, True)
            rounding = self._rounding(elastic_slip, rigid, scales.displacement) if since >= PATIENCE else 0.0
            if largest <= rounding and unsettled <= tolerance:
                return TangentialResult(rigid, iterations, residual, scale, True)
            if iterations >= max_iterations or since >= STALLED or not np.isfinite(residual):
                return TangentialResult(rigid, iterations, residual, scale, False)
            unborne = 0 if residual > tolerance else unborne + 1
            largest = largest or 1.0
            friction.scale_tangential(self._slip, self._normal, 1.0 / largest, self._cg.residual)
            np.copyto(self._slip, shear)
            if residual > tolerance:
                floor = 0.3 * tolerance * scale
                iterations += self._newton_step(control, shear, largest, floor, max_iterations - iterations)
            if unborne and unborne % PATIENCE == 0:
                self._release()
            elif residual > tolerance or excess > tolerance:
                friction.return_to_circle(shear, bound, self._contact, self.slipping, self._normal)
            self._restore_balance(control, self._cg.weight, shear)
            self._follow(elastic_slip, shear, scales.last_tolerance * scale, largest)

    def _release(self) -> None:
        """All cells stick: all slip as they should, but these zones cannot bear the load."""
        self.slipping[:] = False
        self._normal[:] = 0.0
        np.copyto(self._cg.weight, self._contact)

    def _follow(self, elastic_slip: FloatArray, shear: FloatArray, bearable: float, expected: float) -> None:
        """Bring the elastic slip from the shear in `_slip` up to `shear`."""
        np.subtract(shear, self._slip, out=self._slip)
        self._update.add(elastic_slip, self.room, bearable, -1.0, expected)

    def _start_zones(self, control: LoadControl, bound: FloatArray, shear: FloatArray) -> None:
        """Contact is where friction can carry shear. What is missing of the load goes where it can be borne."""
        np.greater(bound, 0.0, out=self._contact)
        shear *= self._contact
        self.slipping &= self._contact
        self._start_fresh_cells(bound, shear)
        friction.return_to_circle(shear, bound, self._contact, self.slipping, self._normal)
        self._restore_balance(control, bound, shear)
        friction.return_to_circle(shear, bound, self._contact, self.slipping, self._normal)
        np.copyto(self._cg.weight, self._contact)

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

    def _update_slip_and_zones(
        self, elastic_slip: FloatArray, control: LoadControl, bound: FloatArray
    ) -> Vector:
        """Slip with the forced rigid motion by weighted least squares; slipping cells moved backwards stick [44]."""
        x, y, weight = self.modes.x, self.modes.y, self._cg.weight
        imposed = control.imposed_displacement
        released = True
        while released:
            friction.take_slip(self._slip, elastic_slip, imposed, x, y, self._normal, weight, self._sums)
            friction.gram(weight, self._normal, x, y, self._gram)
            undetermined = is_singular(self._gram, control.forced_index)
            forced = -solve_modes(self._gram, self._sums, control.forced_index)
            before = int(np.count_nonzero(self.slipping)) if undetermined else 0
            friction.move(
                self._slip,
                forced,
                x,
                y,
                self._normal,
                bound,
                self.slipping,
                self._cg.stiffness,
                weight,
                self.operator.inner.unit,
                STIFFEST,
            )
            # Where all slip the same way, how far is told by the first cells that stick, not by those that slip.
            released = undetermined and int(np.count_nonzero(self.slipping)) < before
        return imposed + forced

    def _rounding(self, elastic_slip: FloatArray, rigid: Vector, displacement: float) -> float:
        """What is lost of slips in rounding (mm)."""
        farthest = max(float(np.abs(self.modes.x).max()), float(np.abs(self.modes.y).max()))
        dx, dy, turn = np.abs(rigid)
        elastic = rounding_of(self.operator.dtype) * float(np.abs(elastic_slip).max())
        return max(elastic, ROUNDING * float(max(displacement, dx, dy, turn * farthest)))

    def _violation(self, rigid: Vector, motion: float, least_slip: float) -> tuple[float, float, float]:
        """Largest |slip| in the stick zone over the motion, or part of it across the shear over the largest slip.

        Also the larger one of these two slips, and the smaller one of the lengths that they are measured against (mm).
        """
        scale = max(motion, abs(rigid[0]), abs(rigid[1]), abs(rigid[2]) * self._reach, TINY)
        largest, in_slip, in_stick = friction.violation(self._slip, self._normal, self.slipping)
        largest = max(largest, LEAST_SLIP * scale, least_slip)
        residual = np.maximum(in_stick / scale, in_slip / largest)
        return float(residual), max(in_slip, in_stick), min(scale, largest)

    def _unbalance(self, control: LoadControl, bound: FloatArray, shear: FloatArray) -> float:
        """Worst imposed resultant's error over what friction could carry."""
        if not control.forced_index:
            return 0.0
        error = np.abs(self.modes.resultants(shear) - control.imposed_resultant)
        capacity = float(bound.sum(dtype=np.float64)) * self.modes.cell_area or TINY
        return float(np.max((error / (capacity * np.array([1.0, 1.0, self._reach])))[control.forced_index]))

    def _excess(self, bound: FloatArray, shear: FloatArray) -> float:
        """Largest excess of |shear| over the bound, over the largest bound."""
        return friction.excess(shear, bound) / (float(bound.max()) or TINY)

    def _newton_step(
        self, control: LoadControl, shear: FloatArray, largest: float, floor: float, limit: int
    ) -> int:
        """Correct the shear by the Newton equation at fixed zones, its residual reduced from `largest`, or to `floor`
        (mm); conjugate gradients have the residual over `largest`."""
        inner, motions = self.operator.inner, self._turn_about_the_contact(control)
        np.copyto(self._cg.normal, self._normal, casting="same_kind")
        self._cg.constrain(control.forced_index, lambda mode, out: self.modes.displacement(motions[mode], out))
        iterations = self._cg.solve(inner.tangential, REDUCTION, floor / largest, limit)
        cg.add(shear, self._cg.solution, largest / inner.unit)
        return iterations

    def _turn_about_the_contact(self, control: LoadControl) -> FloatArray:
        """The modes with the turn about the contact's middle, as far as imposed forces make it the same set."""
        x, y = self.modes.middle(self._contact)
        turn = [y if control.forced[0] else 0.0, -x if control.forced[1] else 0.0, 1.0]
        return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], turn])

    def _restore_balance(self, control: LoadControl, weight: FloatArray, shear: FloatArray) -> None:
        """Add the weighted rigid pattern, tangential in the slip zone, that makes the imposed resultants hold [45]."""
        forced = control.forced_index
        if not forced:
            return
        x, y = self.modes.x, self.modes.y
        missing = control.imposed_resultant - self.modes.resultants(shear)
        friction.gram(weight, self._normal, x, y, self._gram)
        amplitudes = solve_modes(self._gram, missing / self.modes.cell_area, forced)
        friction.add_motion(shear, amplitudes, x, y, weight, self._normal)
