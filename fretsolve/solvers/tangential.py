"""The tangential contact problem: find shear, stick and slip at a given pressure.

    s = e + rigid motion,   |q| <= b,   s = 0 where |q| < b,   q = b s/|s| where s != 0.

s is the slip increment of body 1 relative to body 2, b = mu p the friction limit, and e the elastic slip: by how much
the tangential elastic displacement has decreased since the increment's start. The rigid motion is
(delta_x - phi_z y, delta_y + phi_z x) over the increment; each of its three parts is imposed or belongs to an imposed
Qx, Qy, Mz. The method is semismooth Newton with conjugate gradients inside; TG1 to TG8 are its steps in docs/theory.md,
with n = q/|q| and lam = s.n in the slip zone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.incremental_update import add_displacement
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP, ROUNDING, TINY, rounding_of
from fretsolve.elastic.workspace import Workspace
from fretsolve.kernels import cg, friction
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.normal import SolverResult
from fretsolve.solvers.projected_cg import ProjectedCG
from fretsolve.solvers.rigid_modes import TangentialModes, is_singular, solve_modes
from fretsolve.system.arrays import BoolArray, FloatArray, Vector

REDUCTION = 0.1
"""Factor by which CG reduces the residual at fixed zones before the zones change."""

STIFFEST = 1e25
"""Limit of lam/b in units of the inner iterations; it leaves room for products in single precision."""

PATIENCE = 5
"""Rounds without halving the residual after which rounding is taken into account ..."""

STALLED = 100
"""... and after which the zones are taken to cycle, as they may where almost nothing sticks."""


@dataclass(frozen=True)
class SlipScales:
    """Lengths (mm) that slips are measured against in the increment that a solve is a part of.

    motion: largest rigid displacement increment known so far; least_slip: least value for slips; displacement: largest
    displacement that the elastic slip is a change of; last: scale of the last result, 0 before the first;
    last_tolerance: tightest tolerance of the later solves that reuse this elastic slip (None: that of this solve).
    """

    motion: float = 0.0
    least_slip: float = 0.0
    displacement: float = 0.0
    last: float = 0.0
    last_tolerance: float | None = None


class TangentialSolver:
    """Solves the tangential problem on one grid, any number of times."""

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator = operator
        self.modes = TangentialModes(grid)
        self.workspace = Workspace.zeros(2, grid.shape, operator.inner.dtype)
        self._slip, self._normal = self.workspace.double, np.zeros((2, *grid.shape))
        self._cg = ProjectedCG(self.workspace)
        self._contact = self._cg.zone
        self.slipping: BoolArray = np.zeros(grid.shape, dtype=bool)
        self._gram, self._sums = np.zeros((3, 3)), np.zeros(3)
        self._reach = max(grid.size) / 2.0

    def solve(
        self,
        elastic_slip: FloatArray,
        control: LoadControl,
        friction_limit: FloatArray,
        shear: FloatArray,
        tolerance: float,
        max_iterations: int,
        scales: SlipScales,
    ) -> SolverResult:
        """Solve in place for `shear` (2, nx, ny), which holds the first estimate, as `slipping` does of the slip zone.

        elastic_slip: e at the first estimate, (2, nx, ny), mm, changed in place with the shear; control: of
        (Qx|delta_x, Qy|delta_y, Mz|phi_z), displacements as increments; friction_limit: (nx, ny), MPa; tolerance: on
        the residual. On return `slipping` holds the slip zone.
        """
        iterations, unborne, least, since_halved = 0, 0, np.inf, 0
        last_tolerance = tolerance if scales.last_tolerance is None else scales.last_tolerance
        # TG1: zones and shear of the estimate
        np.copyto(self._slip, shear)
        self._start_zones(control, friction_limit, shear)
        self._update_elastic_slip(elastic_slip, shear, last_tolerance * scales.last, 0.0)
        while True:
            # TG2, TG3: slip and rigid motion [44]; cells that slip against their shear stick
            rigid = self._update_slip_and_zones(elastic_slip, control, friction_limit)
            # TG4: stop at the tolerance, or where rounding allows no better, if loads and friction limit hold as well
            residual, largest, scale = self._violation(rigid, scales)
            least, since_halved = (residual, 0) if residual < 0.5 * least else (least, since_halved + 1)
            excess = friction.excess(shear, friction_limit) / (float(friction_limit.max()) or TINY)
            rounding = self._rounding(elastic_slip, rigid, scales) if since_halved >= PATIENCE else 0.0
            solved = (residual <= tolerance or largest <= rounding) and (
                max(self._unbalance(control, friction_limit, shear), excess) <= tolerance
            )
            if solved or iterations >= max_iterations or since_halved >= STALLED or not np.isfinite(residual):
                return SolverResult(rigid, iterations, residual, scale, solved)
            # TG5: CG reduces the residual of the Newton equation (T11) at fixed zones
            correction = largest if residual > tolerance else 0.0
            if correction:
                self._prepare_cg(control, largest)
                floor, limit = 0.3 * tolerance * scale / largest, max_iterations - iterations
                elastic, inverse = self.operator.inner.tangential, self.operator.preconditioner.tangential
                iterations += self._cg.solve(elastic, inverse, REDUCTION, floor, limit)
            # TG6, TG7, TG8: excess returns to the circle and slips, resultants are restored [45]; the new elastic slip
            unborne = 0 if correction else unborne + 1
            release = unborne > 0 and unborne % PATIENCE == 0
            self._correct(control, friction_limit, shear, correction, excess > tolerance, release)
            self._update_elastic_slip(elastic_slip, shear, last_tolerance * scale, largest or 1.0)

    def _correct(
        self,
        control: LoadControl,
        friction_limit: FloatArray,
        shear: FloatArray,
        largest: float,
        exceeds: bool,
        release: bool,
    ) -> None:
        """Correct shear and zones, and leave the shear before in `_slip`.

        largest: the solution of CG is added, whose residual was over this (mm), 0 for none; exceeds: some shear is
        beyond the friction limit; release: all cells stick, since all slip as they should in zones that cannot carry
        the load.
        """
        np.copyto(self._slip, shear)
        if largest:
            cg.add(shear, self._cg.solution, largest / self.operator.unit)
        if release:
            self.slipping[:] = False
            self._normal[:] = 0.0
            np.copyto(self._cg.weight, self._contact)
        elif largest or exceeds:
            friction.return_to_circle(shear, friction_limit, self._contact, self.slipping, self._normal)
        self._restore_balance(control, self._cg.weight, shear)

    def _update_elastic_slip(
        self, elastic_slip: FloatArray, shear: FloatArray, allowed: float, expected: float
    ) -> None:
        """Update the elastic slip from the shear in `_slip` to `shear`, with an error of less than `allowed` (mm)."""
        np.subtract(shear, self._slip, out=self._slip)
        add_displacement(
            self.operator, ElasticOperator.tangential, elastic_slip, self._slip, self.workspace, allowed, -1.0, expected
        )

    def _start_zones(self, control: LoadControl, friction_limit: FloatArray, shear: FloatArray) -> None:
        """Start with contact where friction can carry shear; what is missing of the load is added where it can be."""
        np.greater(friction_limit, 0.0, out=self._contact)
        shear *= self._contact
        self.slipping &= self._contact
        self._start_fresh_cells(friction_limit, shear)
        friction.return_to_circle(shear, friction_limit, self._contact, self.slipping, self._normal)
        self._restore_balance(control, friction_limit, shear)
        friction.return_to_circle(shear, friction_limit, self._contact, self.slipping, self._normal)
        np.copyto(self._cg.weight, self._contact)

    def _start_fresh_cells(self, friction_limit: FloatArray, shear: FloatArray) -> None:
        """Let cells new in contact slip like their neighbours: they lie at the contact's edge, where all slips."""
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
        shear[:, cells[0], cells[1]] = around[:, moved] / length[moved] * friction_limit[cells]
        self.slipping[cells] = True

    def _update_slip_and_zones(
        self, elastic_slip: FloatArray, control: LoadControl, friction_limit: FloatArray
    ) -> Vector:
        """Compute the slip, with the forced rigid motion by weighted least squares; cells that slip against their shear
        stick [44]. Returns the rigid motion."""
        x, y, weight = self.modes.x, self.modes.y, self._cg.weight
        imposed = control.imposed_displacement
        released = True
        while released:
            friction.take_slip(self._slip, elastic_slip, imposed, x, y, self._normal, weight, self._sums)
            friction.gram(weight, self._normal, x, y, self._gram)
            undetermined = is_singular(self._gram, control.forced_index)
            forced = -solve_modes(self._gram, self._sums, control.forced_index)
            before = int(np.count_nonzero(self.slipping)) if undetermined else 0
            stiffness, unit = self._cg.stiffness, self.operator.unit
            friction.move(
                self._slip, forced, x, y, self._normal, friction_limit, self.slipping, stiffness, weight, unit, STIFFEST
            )
            # Where all slip the same way, the first cells that stick determine how far, not those that slip.
            released = undetermined and int(np.count_nonzero(self.slipping)) < before
        return imposed + forced

    def _rounding(self, elastic_slip: FloatArray, rigid: Vector, scales: SlipScales) -> float:
        """Return the rounding error of slips (mm)."""
        dx, dy, turn = np.abs(rigid)
        elastic = rounding_of(self.operator.dtype) * float(np.abs(elastic_slip).max())
        return max(elastic, ROUNDING * float(max(scales.displacement, dx, dy, turn * self.modes.farthest)))

    def _violation(self, rigid: Vector, scales: SlipScales) -> tuple[float, float, float]:
        """Return the violation of the slip law, the largest slip (mm) in it, and the smaller one of its scales (mm).

        The violation is the largest |slip| in the stick zone over the motion, or the largest part of a slip across the
        shear over the largest slip.
        """
        scale = max(scales.motion, abs(rigid[0]), abs(rigid[1]), abs(rigid[2]) * self._reach, TINY)
        largest, in_slip, in_stick = friction.violation(self._slip, self._normal, self.slipping)
        largest = max(largest, LEAST_SLIP * scale, scales.least_slip)
        residual = np.maximum(in_stick / scale, in_slip / largest)
        return float(residual), max(in_slip, in_stick), min(scale, largest)

    def _unbalance(self, control: LoadControl, friction_limit: FloatArray, shear: FloatArray) -> float:
        """Return the largest error of an imposed resultant over what friction could carry."""
        if not control.forced_index:
            return 0.0
        error = np.abs(self.modes.resultants(shear) - control.imposed_resultant)
        capacity = float(friction_limit.sum(dtype=np.float64)) * self.modes.cell_area or TINY
        return float(np.max((error / (capacity * np.array([1.0, 1.0, self._reach])))[control.forced_index]))

    def _prepare_cg(self, control: LoadControl, largest: float) -> None:
        """Give CG the tangential slip over its `largest` value (mm), the directions of the shear, and the rigid motions
        of the imposed forces."""
        friction.scale_tangential(self._slip, self._normal, 1.0 / largest, self._cg.residual)
        np.copyto(self._cg.normal, self._normal, casting="same_kind")
        # the modes with the turn about the contact's middle, as far as imposed forces allow the same set
        x, y = self.modes.middle(self._contact)
        turn = [y if control.forced[0] else 0.0, -x if control.forced[1] else 0.0, 1.0]
        motions = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], turn])
        self._cg.constrain(control.forced_index, lambda mode, out: self.modes.displacement(motions[mode], out))

    def _restore_balance(self, control: LoadControl, weight: FloatArray, shear: FloatArray) -> None:
        """Add the weighted rigid pattern, tangential in the slip zone, that restores the imposed resultants [45]."""
        forced = control.forced_index
        if not forced:
            return
        x, y = self.modes.x, self.modes.y
        missing = control.imposed_resultant - self.modes.resultants(shear)
        friction.gram(weight, self._normal, x, y, self._gram)
        amplitudes = solve_modes(self._gram, missing / self.modes.cell_area, forced)
        friction.add_motion(shear, amplitudes, x, y, weight, self._normal)
