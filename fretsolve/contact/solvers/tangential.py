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

from fretsolve.contact.kernels import kernels_of
from fretsolve.contact.solvers.incremental_update import Workspace, add_correction, add_displacement
from fretsolve.contact.solvers.normal import SolverResult
from fretsolve.contact.solvers.projected_cg import ProjectedCG, springs_of
from fretsolve.contact.solvers.rigid_modes import (
    SINGLE_MODES,
    SINGULAR,
    TangentialModes,
    is_singular,
    larger,
    largest_error,
    solve_modes,
)
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP, ROUNDING, rounding_of
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import TINY, BoolArray, FloatArray, Vector

STIFFEST = 1e25
"""Limit of lam/b in units of the inner iterations; it leaves room for products in single precision."""

REDUCTION, LATER_REDUCTION = 0.2, 0.03
"""Factors by which CG reduces the residual of the Newton equation (TG5): in the first solve of an increment,
and in later ones, whose zones hardly change."""

FLOOR = 0.7
"""CG reduces it to this part of the tolerance (TG4). Mode I.3 takes 3 % fewer applications than with 0.3."""

PATIENCE = 5
"""Rounds without halving the residual after which rounding is allowed for (TG4)."""


@dataclass(frozen=True)
class SlipScales:
    """Lengths (mm) of an increment that slips are measured against.

    motion: largest rigid displacement increment known so far; least_slip: least length for slips; displacement: largest
    elastic displacement at the start; last: `scale` of the increment's last solve, 0 before the first; last_tolerance:
    tightest tolerance of later solves that reuse this elastic slip (None: the tolerance of this solve).
    """

    motion: float = 0.0
    least_slip: float = 0.0
    displacement: float = 0.0
    last: float = 0.0
    last_tolerance: float | None = None


class TangentialSolver:
    """Solves the tangential problem on one grid, any number of times; slipping: the slip zone (nx, ny)."""

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator = operator
        self._kernels = kernels_of(operator).friction
        self.modes = TangentialModes(grid, kernels_of(operator))
        self.workspace = Workspace(2, grid.shape, operator.inner.dtype)
        self._slip, self._normal = self.workspace.double, np.zeros((2, *grid.shape))
        self._cg = ProjectedCG(self.workspace, 2, kernels_of(operator))
        self._contact = self._cg.zone
        self.slipping: BoolArray = np.zeros(grid.shape, dtype=bool)

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
        """Solve for `shear` (2, nx, ny) and `slipping` (nx, ny) in place; both hold a first estimate.

        elastic_slip: e at the first estimate, (2, nx, ny), mm, changed in place with the shear; control: of
        (Qx|delta_x, Qy|delta_y, Mz|phi_z), displacements as increments; friction_limit: (nx, ny), MPa; tolerance: on
        the residual.
        """
        iterations, only_loads_missed, least, since_halved = 0, 0, np.inf, 0
        largest_limit = float(friction_limit.max()) or TINY
        capacity = float(friction_limit.sum(dtype=np.float64)) * self.modes.cell_area or TINY
        last_tolerance = tolerance if scales.last_tolerance is None else scales.last_tolerance
        # TG1: zones and shear of the estimate
        np.copyto(self._slip, shear)
        self._start_zones(control, friction_limit, shear)
        self._update_elastic_slip(elastic_slip, shear, last_tolerance * scales.last, 0.0)
        while True:
            # TG2, TG3: slip (T2) with the forced rigid motion by least squares; cells with lam <= 0 stick; S and W
            by_law, misfit, missing = self._meet_rig(elastic_slip, control, shear)
            rigid, errors = self._update_slip_and_zones(elastic_slip, control, by_law - misfit, friction_limit)
            # TG4: stop at the tolerance, or where rounding allows no better, if loads and friction limit hold as well
            residual, largest, scale = self._violation(errors, rigid, scales)
            least, since_halved = (residual, 0) if residual < 0.5 * least else (least, since_halved + 1)
            rounding = self._rounding(elastic_slip, rigid, scales) if since_halved >= PATIENCE else 0.0
            accurate = residual <= tolerance or largest <= rounding
            excess = self._kernels.excess(shear, friction_limit) / largest_limit if accurate else 0.0
            loads = control.with_springs_at(self.modes.resultants(shear) + missing) if accurate else control
            solved = accurate and max(self._unbalance(loads, capacity, shear), excess) <= tolerance
            # given up after 100 rounds without halving: the zones cycle, as they may where almost nothing sticks
            if solved or iterations >= max_iterations or since_halved >= 100 or not np.isfinite(residual):
                return SolverResult(rigid, iterations, residual, scale, solved)
            corrected = residual > tolerance
            only_loads_missed = 0 if corrected else only_loads_missed + 1
            # TG5: CG1 to CG6 reduce the residual of the Newton equation (T11) at fixed zones
            if corrected:
                self._prepare_cg(control, largest, misfit)
                floor, limit = FLOOR * tolerance * scale / largest, max_iterations - iterations
                elastic, inverse = self.operator.inner.tangential, self.operator.preconditioner.tangential
                reduction = LATER_REDUCTION if scales.last else REDUCTION
                iterations += self._cg.solve(elastic, inverse, reduction, floor, limit)
                fields = shear, self._slip, elastic_slip
                moved = add_correction(
                    self.operator, self._cg.found, largest, *fields, last_tolerance * scale, sign=-1.0
                )
            else:
                moved = False
                np.copyto(self._slip, shear)
            # TG6: shear beyond the friction limit slips, or all sticks, where the slip zone cannot carry the loads
            if only_loads_missed and only_loads_missed % PATIENCE == 0:
                self.slipping[:] = False
                self._normal[:] = 0.0
                np.copyto(self._cg.weight, self._contact)
            elif corrected or excess > tolerance:
                self._kernels.return_map(shear, friction_limit, self._contact, self.slipping, self._normal)
            # TG7: restore the imposed loads
            self._restore_balance(control, self._cg.weight, shear)
            # TG8: elastic slip of the change of the shear
            self._update_elastic_slip(elastic_slip, shear, last_tolerance * scale, 0.0 if moved else largest or 1.0)

    def _update_elastic_slip(
        self, elastic_slip: FloatArray, shear: FloatArray, allowed: float, expected: float
    ) -> None:
        """Update the elastic slip from the shear in `_slip` to `shear`, with an error of less than `allowed` (mm)."""
        np.subtract(shear, self._slip, out=self._slip)
        add_displacement(
            self.operator,
            type(self.operator).tangential,
            elastic_slip,
            self._slip,
            self.workspace,
            allowed,
            -1.0,
            expected,
        )

    def _start_zones(self, control: LoadControl, friction_limit: FloatArray, shear: FloatArray) -> None:
        """Take contact where the friction limit is positive, and restore the imposed loads there (TG6, TG7)."""
        np.greater(friction_limit, 0.0, out=self._contact)
        shear *= self._contact
        self.slipping &= self._contact
        self._start_fresh_cells(friction_limit, shear)
        self._kernels.return_map(shear, friction_limit, self._contact, self.slipping, self._normal)
        self._restore_balance(control, friction_limit, shear)
        self._kernels.return_map(shear, friction_limit, self._contact, self.slipping, self._normal)
        np.copyto(self._cg.weight, self._contact)

    def _start_fresh_cells(self, friction_limit: FloatArray, shear: FloatArray) -> None:
        """Let cells new in contact slip like their neighbours: they lie at the contact's edge, where cells slip.

        Those at the edge of the grid, which no contact may reach, are left alone. A line has one column of cells.
        """
        fresh = shear[0] == 0.0
        fresh &= shear[1] == 0.0
        fresh &= self._contact
        columns = range(-1, 2) if fresh.shape[1] > 1 else range(1)
        fresh[0] = fresh[-1] = False
        if len(columns) > 1:
            fresh[:, 0] = fresh[:, -1] = False
        if not 0 < np.count_nonzero(fresh) < np.count_nonzero(self._contact):
            return
        row, column = np.nonzero(fresh)
        around = sum((shear[:, row + i, column + j] for i in range(-1, 2) for j in columns), np.zeros((2, row.size)))
        length = np.hypot(around[0], around[1])
        moved = length > 0.0
        row, column = row[moved], column[moved]
        shear[:, row, column] = around[:, moved] / length[moved] * friction_limit[row, column]
        self.slipping[row, column] = True

    def _update_slip_and_zones(
        self, elastic_slip: FloatArray, control: LoadControl, imposed: Vector, friction_limit: FloatArray
    ) -> tuple[Vector, tuple[float, float, float]]:
        """Compute the slip and let cells stick that slip against their shear; return the rigid motion and `violation`.

        Least squares give the forced part of the motion, N' W T s = 0.
        """
        x, y, weight = self.modes.x, self.modes.y, self._cg.weight
        released = True
        while released:
            sums, gram = self._kernels.take_slip(self._slip, elastic_slip, imposed, x, y, self._normal, weight)
            undetermined = is_singular(gram, control.forced_index)
            forced = -solve_modes(gram, sums, control.forced_index)
            before = int(np.count_nonzero(self.slipping)) if undetermined else 0
            stiffness, unit = self._cg.stiffness, self.operator.unit
            errors: tuple[float, float, float] = self._kernels.move(
                self._slip, forced, x, y, self._normal, friction_limit, self.slipping, stiffness, weight, unit, STIFFEST
            )
            # if all cells slip in one direction, N' W T s = 0 leaves the motion open until some of them stick
            released = undetermined and int(np.count_nonzero(self.slipping)) < before
        return imposed + forced, errors

    def _rounding(self, elastic_slip: FloatArray, rigid: Vector, scales: SlipScales) -> float:
        """Return the rounding error of slips (mm)."""
        dx, dy, turn = np.abs(rigid)
        elastic = rounding_of(self.operator.dtype) * float(np.abs(elastic_slip).max())
        return max(elastic, ROUNDING * float(max(scales.displacement, dx, dy, turn * self.modes.farthest)))

    def _violation(
        self, errors: tuple[float, float, float], rigid: Vector, scales: SlipScales
    ) -> tuple[float, float, float]:
        """Return the residual of the slip law, the largest error in it (mm), and the smaller one of its scales (mm).

        Errors are slips of sticking cells, over the rigid motion, and in the slip zone the part of a slip across the
        shear, over the largest slip.
        """
        dx, dy, turn = rigid.tolist()
        scale = max(scales.motion, abs(dx), abs(dy), abs(turn) * self.modes.arm, TINY)
        largest, in_slip, in_stick = errors
        largest = max(largest, LEAST_SLIP * scale, scales.least_slip)
        residual = larger(in_stick / scale, in_slip / largest)
        return residual, max(in_slip, in_stick), min(scale, largest)

    def _unbalance(self, control: LoadControl, capacity: float, shear: FloatArray) -> float:
        """Return the largest error of an imposed resultant over what friction can carry, N (a torque: its arm)."""
        if not control.forced_index:
            return 0.0
        return largest_error(self.modes.resultants(shear), control, capacity, self.modes.arms[3:])

    def _meet_rig(
        self, elastic_slip: FloatArray, control: LoadControl, shear: FloatArray
    ) -> tuple[Vector, Vector, Vector]:
        """Return the imposed motion by the law of a rig, the part of it that its loads still take, and their change.

        Without a rig the last two are 0.
        """
        if control.compliance is None:
            return control.imposed_displacement, np.zeros(3), np.zeros(3)
        imposed, arguments = control.displacement(self.modes.resultants(shear)), (self.modes.x, self.modes.y)
        fields = self._normal, self._cg.weight
        sums, gram = self._kernels.take_slip(self._slip, elastic_slip, imposed, *arguments, *fields)
        # where all cells slip along a motion, they take nothing of it, and its weight is rounding
        least = SINGULAR * (gram[0][0] + gram[1][1]) * np.square(self.modes.arms[3:])
        misfit = solve_modes(gram, sums, [mode for mode in control.fitted_index if gram[mode][mode] > least[mode]])
        return imposed, *self.modes.meet_rig(control, misfit, gram, self.operator.unit)

    def _prepare_cg(self, control: LoadControl, largest: float, misfit: Vector) -> None:
        """Give CG T s over its `largest` value (mm), n, and the rigid motions of the imposed loads (T11).

        misfit: the motion that the loads of a rig are to take, which has been left out of the slip s.
        """
        self._kernels.scale_tangential(self._slip, self._normal, 1.0 / largest, self._cg.residual)
        np.copyto(self._cg.normal, self._normal, casting="same_kind")
        motions = list(SINGLE_MODES)
        if control.forced[2]:
            # With imposed forces the turn may be about the contact's middle: then it is not nearly dependent.
            x, y = self.modes.middle(self._contact)
            motions[2] = y if control.forced[0] else 0.0, -x if control.forced[1] else 0.0, 1.0
        springs = springs_of(control, self.modes.cell_area / self.operator.unit)
        self._cg.constrain([motions[mode] for mode in control.forced_index], self.modes.x, self.modes.y, springs)
        if springs is not None:
            self._cg.push(misfit / largest)

    def _restore_balance(self, control: LoadControl, weight: FloatArray, shear: FloatArray) -> None:
        """Add the rigid pattern W T N a to the shear, so that it has the imposed resultants."""
        forced = control.forced_index
        if not forced:
            return
        x, y = self.modes.x, self.modes.y
        sums, gram = self._kernels.balance(shear, weight, self._normal, x, y)
        amplitudes = solve_modes(gram, self.modes.missing(control, sums), forced)
        self._kernels.add_motion(shear, amplitudes, x, y, weight, self._normal)
