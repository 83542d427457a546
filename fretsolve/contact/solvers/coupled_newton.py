"""The coupled Newton method: pressure and shear solved together, where staggered iterations do not converge.

Each semismooth Newton step solves the linear equations of both at fixed zones (`coupled_equations`), then the zones
change. CN1 to CN9 are the steps in docs/theory.md.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.contact.kernels import kernels_of
from fretsolve.contact.solvers.coupled_equations import CoupledEquations
from fretsolve.contact.solvers.rigid_modes import GapErrors, NormalModes, TangentialModes, solve_modes
from fretsolve.contact.solvers.tangential import STIFFEST
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray, Vector, grown

ROUGHLY, CLOSELY = 1e-2, 1e-6
"""Factors by which GMRES reduces the residual of (T13): at first, and if the steps then do not converge. At strong
friction an edge cell may hold a large shear under a pressure that is too small to count in the residual."""


@dataclass(frozen=True)
class CoupledProblem:
    """An increment on one grid.

    separation: (nx, ny), undeformed; elastic_slip: (2, nx, ny), since the increment's start, at the tractions
    `pressure` (nx, ny) and `shear` (2, nx, ny); before: delta_z, phi_x, phi_y at the start; friction: the
    friction limit by the pressure; normal, tangential: what is imposed, tangential displacements as increments; motion,
    least_slip: as in `SlipScales`; coupling: as in `Increment`.
    """

    separation: FloatArray
    pressure: FloatArray
    shear: FloatArray
    elastic_slip: FloatArray
    before: Vector
    friction: FrictionLimit
    normal: LoadControl
    tangential: LoadControl
    motion: float
    least_slip: float
    coupling: FloatArray | None = None

    @property
    def rig(self) -> DoubleArray:
        """The compliance of the rig, (6, 6)."""
        compliance = np.zeros((6, 6))
        compliance[:3, :3], compliance[3:, 3:] = self.normal.matrix, self.tangential.matrix
        if self.coupling is not None:
            compliance[:3, 3:], compliance[3:, :3] = self.coupling, self.coupling.T
        return compliance


@dataclass
class CoupledState:
    """The unknowns. pressure, slipping: (nx, ny); shear: (2, nx, ny); direction: of the shear where it slips, else 0,
    (2, nx, ny); rigid: delta_z, phi_x, phi_y, and the increments of delta_x, delta_y, phi_z."""

    pressure: FloatArray
    shear: FloatArray
    slipping: BoolArray
    direction: FloatArray
    rigid: Vector


class CoupledNewton:
    """Solves for pressure and shear together on one grid; iterations: of GMRES in all attempts."""

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator = operator
        self._kernels = kernels_of(operator)
        self._normal, self._tangential = NormalModes(grid, self._kernels), TangentialModes(grid, self._kernels)
        self._arms = self._normal.arms
        self._uz, self._uz_before, self._gap, self._forward = (np.zeros(grid.shape) for _ in range(4))
        self._moved, self._slip = np.zeros((2, *grid.shape)), np.zeros((2, *grid.shape))
        self._contact: BoolArray = np.zeros(grid.shape, dtype=bool)
        self.iterations = self._most = 0

    def solve(
        self, problem: CoupledProblem, start: CoupledState, tolerance: float, max_iterations: int
    ) -> CoupledState | None:
        """Return the solution, or None where none is found.

        start: a state at other loads; from there the loads change to the problem's in as few parts as possible;
        max_iterations: of GMRES for each attempt.
        """
        self.begin(problem, max_iterations)
        loads = self.resultants(start)
        motions = start.rigid + self._rig @ loads
        reached, part, reduction = 0.0, 1.0, ROUGHLY
        while reached < 1.0:
            # CN9: the problem with a part of the change of the loads, at first the whole change
            to = min(1.0, reached + part)
            partial = replace(
                problem,
                normal=_moved(problem.normal, loads[:3], motions[:3], to),
                tangential=_moved(problem.tangential, loads[3:], motions[3:], to),
            )
            wanted = tolerance if to == 1.0 else 1e-3  # parts only give estimates
            found = self.solve_from(partial, start, wanted, reduction)
            if found is None and reduction == ROUGHLY:  # CN8: again, with GMRES to six digits
                reduction = CLOSELY
                found = self.solve_from(partial, start, wanted, reduction)
            # CN9: go on with twice the part, or try a quarter of the part
            if found is not None:
                start, reached, part = found, to, 2.0 * part
            elif (part := part / 4.0) < 0.01:
                return None
        return start

    def begin(self, problem: CoupledProblem, max_iterations: int) -> None:
        """Prepare to solve a problem, whole and in parts."""
        self.iterations, self._most = 0, max_iterations
        self._forced = np.array([*problem.normal.forced, *problem.tangential.forced])
        self._rig = problem.rig
        self._sprung = np.flatnonzero(self._rig.any(axis=0))
        self._uz_before.fill(0.0)
        if problem.pressure.any():
            pressure, shear = problem.pressure.astype(np.float64), problem.shear.astype(np.float64)
            self.operator.all(pressure, shear, self._uz_before, self._moved)

    def resultants(self, state: CoupledState) -> Vector:
        """Return P, Mx, My, Qx, Qy, Mz (N, N mm)."""
        normal = self._normal.resultants(state.pressure)
        return np.concatenate([normal, self._tangential.resultants(state.shear)])

    def solve_from(
        self, problem: CoupledProblem, start: CoupledState, tolerance: float, reduction: float
    ) -> CoupledState | None:
        """Return the solution, or None where the Newton steps from `start` do not converge.

        reduction: factor by which GMRES reduces the residual of (T13).
        """
        # CN8: cells that join the contact slip if a neighbour does; all of them slip; and this from gross slip
        ways = [(start, False), (start, True)]
        if problem.tangential.imposed_displacement.any():
            ways.append((self._in_gross_slip(problem, start), True))
        for first, joining_slip in ways:
            found = self._newton(problem, deepcopy(first), tolerance, joining_slip, reduction)
            if found is not None:
                return found
        return None

    def _newton(
        self, problem: CoupledProblem, work: CoupledState, tolerance: float, joining_slip: bool, reduction: float
    ) -> CoupledState | None:
        """Return `work`, changed to the solution by Newton steps; joining_slip: cells that join the contact slip."""
        self._contact = contact = work.pressure > 0.0
        left = np.zeros_like(contact)
        last = self.iterations + self._most
        for step in range(30):
            # CN1: shear beyond the friction limit slips; in the slip zone q = b n
            self._return_map(problem, work)
            # CN2: displacements of the tractions; in the first step a fit of the rigid displacements
            pressure, shear = work.pressure - problem.pressure, work.shear - problem.shear
            self.operator.all(pressure, shear, self._uz, self._moved)
            self._uz += self._uz_before
            if step == 0:
                self._fit_rigid(problem, work)
            self._give_way(problem, work)
            # CN3: gap (T1), slip (T2), lam = s.n, and missing loads (T3)
            errors = self._take_gap_and_slip(problem, work)
            imposed = np.concatenate([problem.normal.imposed_resultant, problem.tangential.imposed_resultant])
            missing = np.where(self._forced, imposed - self.resultants(work), 0.0)
            # CN4: stop at the tolerance; give up at a residual of 100, from which no step comes back
            residuals = errors.residual, self._slip_residual(problem, work), self._unbalance(problem, work, missing)
            worst = float(np.max(residuals))
            if worst <= tolerance:
                return work
            if not worst < 100.0 or self.iterations >= last:
                return None
            # CN5: slipping cells with lam < 0 stick; penetrating cells join, and slip if a neighbour does or if they
            # have left under tension before, since then they can neither stick nor be open
            backwards = work.slipping & (self._forward < 0.0)
            work.slipping &= ~backwards
            work.direction[:, backwards] = 0.0
            joining = ~contact & (self._gap < -0.3 * tolerance * errors.gap_scale)
            contact |= joining
            self._let_slip(work, joining if joining_slip else joining & (grown(work.slipping) | left))
            # CN6: GMRES on (T13) at these zones
            if not self._add_correction(problem, work, missing, reduction, last - self.iterations):
                return None
            # CN7: cells under tension leave the contact and lose their shear
            np.maximum(work.pressure, 0.0, out=work.pressure)
            left |= contact & (work.pressure == 0.0)
            contact &= work.pressure > 0.0
            work.shear *= contact
        return None

    def _in_gross_slip(self, problem: CoupledProblem, start: CoupledState) -> CoupledState:
        work = deepcopy(start)
        np.greater(work.pressure, 0.0, out=work.slipping)
        given_way = (self._rig @ self.resultants(start))[3:]
        self._tangential.displacement(problem.tangential.imposed_displacement - given_way, work.shear)
        work.shear *= work.slipping
        work.shear /= float(np.abs(work.shear).max()) or 1.0
        return work

    def _return_map(self, problem: CoupledProblem, work: CoupledState) -> None:
        """Let shear beyond the friction limit slip, and give it the length of the limit in the slip zone."""
        length, friction_limit = np.hypot(work.shear[0], work.shear[1]), problem.friction.limit(work.pressure)
        work.slipping |= length > friction_limit
        work.slipping &= self._contact
        turned = work.slipping & (length > 0.0)
        work.direction[:, turned] = work.shear[:, turned] / length[turned]
        work.direction[:, ~work.slipping] = 0.0
        work.shear[:, work.slipping] = (friction_limit * work.direction)[:, work.slipping]

    def _give_way(self, problem: CoupledProblem, work: CoupledState) -> None:
        """Take the motions that a rig leaves to the surfaces under the present loads."""
        if len(sprung := self._sprung):
            imposed = np.array([*problem.normal.values, *problem.tangential.values])
            work.rigid[sprung] = (imposed - self._rig @ self.resultants(work))[sprung]

    def _fit_rigid(self, problem: CoupledProblem, work: CoupledState) -> None:
        """Estimate the forced rigid displacements by least squares of gap and slip over the contact."""
        work.rigid[:3] = np.where(problem.normal.forced, work.rigid[:3], problem.normal.imposed_displacement)
        work.rigid[3:] = problem.tangential.imposed_displacement
        self._give_way(problem, work)
        self._take_gap_and_slip(problem, work)
        gaps = self._normal.gap_sums(problem.separation, self._uz, work.rigid[:3], self._contact)
        work.rigid[:3] += solve_modes(self._normal.gram(self._contact), gaps, problem.normal.forced_index)
        weight = self._contact.astype(np.float64)
        gram = self._kernels.friction.gram(weight, work.direction, self._normal.x, self._normal.y)
        across = (self._slip - self._forward * work.direction) * self._contact
        work.rigid[3:] -= solve_modes(gram, self._tangential.sums(across), problem.tangential.forced_index)

    def _take_gap_and_slip(self, problem: CoupledProblem, work: CoupledState) -> GapErrors:
        """Compute gap, slip increment, and its part along the shear where cells slip; return the errors of the gap."""
        self._tangential.displacement(work.rigid[3:], self._slip)
        self._slip += problem.elastic_slip
        self._slip -= self._moved
        np.einsum("kij,kij->ij", self._slip, work.direction, out=self._forward)
        return self._normal.gap(problem.separation, self._uz, work.rigid[:3], self._contact, self._gap)

    def _slip_residual(self, problem: CoupledProblem, work: CoupledState) -> float:
        """Return the largest error of the slip over its scale, as in `tangential`."""
        moved = np.abs(np.concatenate([work.rigid[:3] - problem.before, work.rigid[3:]])) * self._arms
        motion = max(problem.motion, float(moved.max()), TINY)
        largest, in_slip, in_stick = self._kernels.friction.violation(
            self._slip * self._contact, work.direction, work.slipping
        )
        largest = max(largest, LEAST_SLIP * motion, problem.least_slip)
        return float(np.maximum(in_stick / motion, in_slip / largest))

    def _unbalance(self, problem: CoupledProblem, work: CoupledState, missing: Vector) -> float:
        """Return the largest missing resultant over P, or over what friction can carry (a moment: times its arm)."""
        load = float(work.pressure.sum()) * self._normal.cell_area
        carried = float(problem.friction.limit(work.pressure).sum()) * self._normal.cell_area
        scale = np.maximum(np.repeat([load, carried], 3) * self._arms, TINY)
        return float(np.max(np.abs(missing) / scale))

    def _let_slip(self, work: CoupledState, cells: BoolArray) -> None:
        length = np.hypot(self._slip[0], self._slip[1])
        cells = cells & (length > 0.0)
        work.direction[:, cells] = self._slip[:, cells] / length[cells]
        work.slipping |= cells

    def _add_correction(
        self, problem: CoupledProblem, work: CoupledState, missing: Vector, reduction: float, most: int
    ) -> bool:
        """Add the solution of (T13) at the present zones; return whether there is one."""
        contact, unit, cell_area = self._contact, self.operator.unit, self._normal.cell_area
        if not contact.any():
            return False
        forced, normal = np.flatnonzero(self._forced), work.direction[:, contact]
        right = np.array([-self._gap[contact], *self._slip[:, contact]])
        right[1:] -= np.einsum("kn,kn->n", right[1:], normal) * normal
        try:
            change, amplitudes, iterations = self._equations(problem, work).solve(
                right / unit, (missing / self._arms)[forced] / cell_area, reduction, most
            )
        except np.linalg.LinAlgError:  # numbers that overflow, from zones that cannot carry the load
            return False
        self.iterations += iterations
        work.pressure[contact] += change[0]
        work.shear[:, contact] += change[1:]
        work.rigid[forced] += amplitudes * unit / self._arms[forced]
        return True

    def _equations(self, problem: CoupledProblem, work: CoupledState) -> CoupledEquations:
        """Return (T13) at the present zones, with rigid motions over their arms."""
        contact, unit = self._contact, self.operator.unit
        friction, pressure = problem.friction.part(contact), work.pressure[contact]
        slipping, friction_limit = work.slipping[contact], friction.limit(pressure)
        stiffness = np.full(friction_limit.shape, STIFFEST)
        np.divide(self._forward[contact], friction_limit * unit, out=stiffness, where=friction_limit * unit > 0.0)
        stiffness = np.where(slipping, np.clip(stiffness, 0.0, STIFFEST), 0.0)
        row, column = np.nonzero(contact)
        x, y = self._normal.x[row] / self._arms[2], self._normal.y[column] / self._arms[1]
        motions = np.zeros((6, 3, row.size))
        motions[0, 0], motions[1, 0], motions[2, 0] = 1.0, y, x
        motions[3, 1], motions[4, 2], motions[5, 1], motions[5, 2] = 1.0, 1.0, -y, x
        normal, drag = work.direction[:, contact], friction.slope(pressure) * slipping
        sprung, compliance = self._sprung, self._rig * (self._normal.cell_area / unit)
        block = (compliance * np.outer(self._arms, self._arms))[np.ix_(sprung, sprung)]
        kept = np.concatenate([np.flatnonzero(self._forced), sprung])
        return CoupledEquations(self.operator, contact, normal, drag, stiffness, motions[kept], block)


def _moved(control: LoadControl, loads: Vector, motions: Vector, part: float) -> LoadControl:
    """Return what is imposed when `part` of the change from `loads` and `motions` is made."""
    if part == 1.0:
        return control
    before = np.where(control.forced, loads, motions)
    x, y, z = (float(b + part * (v - b)) for b, v in zip(before, control.values, strict=True))
    return replace(control, values=(x, y, z))
