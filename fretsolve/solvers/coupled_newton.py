"""Pressure and shear solved together, where they act on each other too strongly to be solved in turns.

Semismooth Newton steps on both at once: each solves the linear equations at fixed zones (`coupled_equations`);
then cells under tension leave the contact and cells that penetrate join it, shear beyond the bound slips, and cells
that slip against their shear stick. Where the steps do not settle, the loads are taken in parts: first estimates on
the way to the whole, which is then solved as one increment, as it has to be.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretsolve.elastic.incremental_update import Room
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP, TINY
from fretsolve.kernels import friction
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.coupled_equations import Fields, JointEquations, Zones
from fretsolve.solvers.normal import grown
from fretsolve.solvers.rigid_modes import NormalModes, TangentialModes, solve_modes
from fretsolve.solvers.tangential import STIFFEST
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray, Vector

MOST_STEPS = 30
"""Newton steps before the loads are taken in smaller parts."""

ROUGHLY, CLOSELY = 1e-2, 1e-6
"""By how much a step reduces the residual of its linear equations: at first, and where the steps then do not settle,
as at strong friction, where a pressure too small to tell in the residual holds a large shear."""

LEAST_PART = 0.01
"""Of the loads; an increment that needs smaller ones is given up."""

DIVERGED = 100.0
"""Residual from which on no step comes back."""

ROUGH = 1e-3
"""Tolerance of the estimates on the way."""


@dataclass(frozen=True)
class Problem:
    """An increment on one grid.

    separation: undeformed (nx, ny); elastic_slip: since the increment's start, (2, nx, ny), at the tractions pressure
    (nx, ny) and shear (2, nx, ny); before: delta_z, phi_x, phi_y at the start; normal, tangential: what is imposed, the
    latter's displacements as increments; motion, least_slip: lengths that slips are measured against at least (mm), as
    in `tangential`.
    """

    separation: FloatArray
    pressure: FloatArray
    shear: FloatArray
    elastic_slip: FloatArray
    before: Vector
    friction: float
    normal: LoadControl
    tangential: LoadControl
    motion: float
    least_slip: float


@dataclass
class Estimate:
    """What is solved for: pressure (nx, ny), shear (2, nx, ny), where it slips, and the directions of shear there
    (2, nx, ny); rigid: delta_z, phi_x, phi_y, and the increments of delta_x, delta_y, phi_z."""

    pressure: FloatArray
    shear: FloatArray
    slipping: BoolArray
    direction: FloatArray
    rigid: Vector

    def copy(self) -> Estimate:
        """With arrays of its own."""
        return Estimate(*(array.copy() for array in vars(self).values()))


def solve_jointly(
    solver: JointSolver, problem: Problem, start: Estimate, tolerance: float, max_iterations: int
) -> Estimate | None:
    """The solution, or None where none is found; `start` meets other loads than the problem's.

    Its loads are moved to the problem's in as few parts as it takes; max_iterations: of GMRES for each attempt.
    """
    solver.begin(problem, max_iterations)
    loads, rigid = solver.resultants(start), start.rigid.copy()
    reached, part, reduction = 0.0, 1.0, ROUGHLY
    while reached < 1.0:
        to = min(1.0, reached + part)
        partial = replace(
            problem,
            normal=_moved(problem.normal, loads[:3], rigid[:3], to),
            tangential=_moved(problem.tangential, loads[3:], rigid[3:], to),
        )
        wanted = tolerance if to == 1.0 else ROUGH
        found = solver.solve(partial, start, wanted, reduction)
        if found is None and reduction == ROUGHLY:
            reduction = CLOSELY
            found = solver.solve(partial, start, wanted, reduction)
        if found is not None:
            start, reached, part = found, to, 2.0 * part
        elif (part := part / 4.0) < LEAST_PART:
            return None
    return start


def _moved(control: LoadControl, loads: Vector, rigid: Vector, part: float) -> LoadControl:
    """Part of the way from `loads` and `rigid` to what is imposed."""
    if part == 1.0:
        return control
    before = np.where(control.forced, loads, rigid)
    x, y, z = (float(b + part * (v - b)) for b, v in zip(before, control.values, strict=True))
    return LoadControl(control.forced, (x, y, z))


class JointSolver:
    """Working arrays for problems on one grid; room: of the tangential solver on it, which rests meanwhile.

    iterations: of GMRES in all attempts.
    """

    def __init__(self, operator: ElasticOperator, grid: Grid, room: Room):
        self.operator = operator
        self._normal, self._tangential = NormalModes(grid), TangentialModes(grid)
        shape = grid.shape
        self._uz, self._uz_before, self._gap, self._forward, self._scratch = (np.zeros(shape) for _ in range(5))
        self._moved, self._slip = np.zeros((2, *shape)), room.double
        self._fields = Fields(self._scratch, self._slip, self._uz, self._moved, room.single[0][:1], room.single[1])
        self._contact: BoolArray = np.zeros(shape, dtype=bool)
        self._left: BoolArray = np.zeros(shape, dtype=bool)
        self._reach = max(grid.size) / 2.0
        self._arms = np.array([1.0, self._reach, self._reach, 1.0, 1.0, self._reach])
        self.iterations = self._most = 0

    def begin(self, problem: Problem, max_iterations: int) -> None:
        """Take up a problem, to be solved whole and in parts."""
        self.iterations, self._most = 0, max_iterations
        self._uz_before.fill(0.0)
        if problem.pressure.any():
            np.copyto(self._scratch, problem.pressure)
            np.copyto(self._slip, problem.shear)
            self.operator.all(self._scratch, self._slip, self._uz_before, self._moved)

    def resultants(self, estimate: Estimate) -> Vector:
        """P, Mx, My, Qx, Qy, Mz (N, N mm)."""
        normal = self._normal.resultants(estimate.pressure)
        return np.concatenate([normal, self._tangential.resultants(estimate.shear)])

    def solve(self, problem: Problem, start: Estimate, tolerance: float, reduction: float) -> Estimate | None:
        """The solution from `start`, or None where no way to it settles; reduction: of a step's linear equations.

        Cells that join the contact slip if those beside them do; or all do; or all of the contact slides at first.
        """
        ways = [(start, False), (start, True)]
        if problem.tangential.imposed_displacement.any():
            ways.append((self._slid(problem, start), True))
        for first, sliding in ways:
            found = self._settled(problem, first.copy(), tolerance, sliding, reduction)
            if found is not None:
                return found
        return None

    def _settled(
        self, problem: Problem, work: Estimate, tolerance: float, sliding: bool, reduction: float
    ) -> Estimate | None:
        """`work` brought to the solution by Newton steps; sliding: cells that join the contact slip at first."""
        np.greater(work.pressure, 0.0, out=self._contact)
        self._left[:] = False
        last = self.iterations + self._most
        for step in range(MOST_STEPS):
            self._put_on_circle(problem, work)
            self._displace(problem, work)
            if step == 0:
                self._fit_rigid(problem, work)
            self._take_gap_and_slip(problem, work)
            missing = self._missing(problem, work)
            error, scale = self._violation(problem, work)
            worst = max(error, self._unbalance(problem, work, missing))
            if worst <= tolerance:
                return work
            if not worst < DIVERGED or self.iterations >= last:
                return None
            self._change_zones(work, 0.3 * tolerance * scale, sliding)
            if not self._step(problem, work, missing, reduction, last - self.iterations):
                return None
        return None

    def _displace(self, problem: Problem, work: Estimate) -> None:
        """uz, and how far the surfaces have moved tangentially since the tractions of the problem."""
        np.subtract(work.pressure, problem.pressure, out=self._scratch)
        np.subtract(work.shear, problem.shear, out=self._slip)
        self.operator.all(self._scratch, self._slip, self._uz, self._moved)
        self._uz += self._uz_before

    def _slid(self, problem: Problem, start: Estimate) -> Estimate:
        """`start` with all of its contact sliding along the imposed motion."""
        work = start.copy()
        np.greater(work.pressure, 0.0, out=work.slipping)
        self._tangential.displacement(problem.tangential.imposed_displacement, work.shear)
        work.shear *= work.slipping
        work.shear /= float(np.abs(work.shear).max()) or 1.0
        return work

    def _put_on_circle(self, problem: Problem, work: Estimate) -> None:
        """In the slip zone the shear gets the length of its bound; beyond the bound it slips."""
        length = np.hypot(work.shear[0], work.shear[1])
        bound = np.multiply(work.pressure, problem.friction, out=self._scratch)
        work.slipping |= length > bound
        work.slipping &= self._contact
        turned = work.slipping & (length > 0.0)
        work.direction[:, turned] = work.shear[:, turned] / length[turned]
        work.direction[:, ~work.slipping] = 0.0
        work.shear[:, work.slipping] = (bound * work.direction)[:, work.slipping]

    def _fit_rigid(self, problem: Problem, work: Estimate) -> None:
        """First rigid displacements of forced modes, by least squares of gap and slip over the contact."""
        work.rigid[:3] = np.where(problem.normal.forced, work.rigid[:3], problem.normal.imposed_displacement)
        work.rigid[3:] = problem.tangential.imposed_displacement
        self._take_gap_and_slip(problem, work)
        forced, gram = problem.normal.forced_index, self._normal.gram(self._contact)
        gap = np.where(self._contact, self._gap, 0.0)
        work.rigid[:3] += solve_modes(gram, self._normal.sums(gap), forced)
        x, y, weight = self._normal.x, self._normal.y, self._contact.astype(np.float64)
        gram = np.zeros((3, 3))
        friction.gram(weight, work.direction, x, y, gram)
        across = (self._slip - self._forward * work.direction) * self._contact
        work.rigid[3:] -= solve_modes(gram, self._tangential.sums(across), problem.tangential.forced_index)

    def _take_gap_and_slip(self, problem: Problem, work: Estimate) -> None:
        """Gap, slip increment, and its part along the shear where cells slip."""
        self._normal.displacement(work.rigid[:3], self._scratch)
        np.add(problem.separation, self._uz, out=self._gap)
        self._gap -= self._scratch
        self._tangential.displacement(work.rigid[3:], self._slip)
        self._slip += problem.elastic_slip
        self._slip -= self._moved
        np.einsum("kij,kij->ij", self._slip, work.direction, out=self._forward)

    def _missing(self, problem: Problem, work: Estimate) -> Vector:
        """Imposed resultants that are not there yet (N, N mm)."""
        imposed = np.concatenate([problem.normal.imposed_resultant, problem.tangential.imposed_resultant])
        return np.where(_forced(problem), imposed - self.resultants(work), 0.0)

    def _violation(self, problem: Problem, work: Estimate) -> tuple[float, float]:
        """Worst of gap and slip over their scales, as in `normal` and `tangential`; the gap's."""
        contact = self._contact
        scale = self._normal.approach(self._uz, contact, work.rigid[:3])
        in_contact = float(np.max(np.abs(self._gap), where=contact, initial=0.0))
        penetration = -float(np.min(self._gap, where=~contact, initial=0.0))
        moved = np.abs(np.concatenate([work.rigid[:3] - problem.before, work.rigid[3:]])) * self._arms
        motion = max(problem.motion, float(moved.max()), TINY)
        distance = np.hypot(self._slip[0], self._slip[1])
        largest = max(float(np.max(distance, where=contact, initial=0.0)), LEAST_SLIP * motion, problem.least_slip)
        across = self._slip - self._forward * work.direction
        in_stick = float(np.max(distance, where=contact & ~work.slipping, initial=0.0))
        in_slip = float(np.max(np.hypot(across[0], across[1]), where=work.slipping, initial=0.0))
        return float(np.max([max(in_contact, penetration) / scale, in_stick / motion, in_slip / largest])), scale

    def _unbalance(self, problem: Problem, work: Estimate, missing: Vector) -> float:
        """Worst of what is missing over P, or over what friction could carry."""
        load = float(work.pressure.sum()) * self._normal.cell_area
        scale = np.maximum(np.repeat([load, problem.friction * load], 3) * self._arms, TINY)
        return float(np.max(np.abs(missing) / scale))

    def _change_zones(self, work: Estimate, deep: float, sliding: bool) -> None:
        """Cells that slip against their shear stick; cells that penetrate by more than `deep` (mm) join the contact.

        Those that have left it under tension slip, as all do at first if `sliding`: they can neither stick nor be open.
        """
        backwards = work.slipping & (self._forward < 0.0)
        work.slipping &= ~backwards
        work.direction[:, backwards] = 0.0
        joining = ~self._contact & (self._gap < -deep)
        self._contact |= joining
        fresh = joining if sliding else joining & (grown(work.slipping) | self._left)
        length = np.hypot(self._slip[0], self._slip[1])
        fresh &= length > 0.0
        work.direction[:, fresh] = self._slip[:, fresh] / length[fresh]
        work.slipping |= fresh

    def _step(self, problem: Problem, work: Estimate, missing: Vector, reduction: float, most: int) -> bool:
        """A Newton step at the present zones, then cells under tension leave; whether it could be made."""
        contact, unit = self._contact, self.operator.inner.unit
        if not contact.any():
            return False
        forced = np.flatnonzero(_forced(problem))
        zones = self._zones(problem, work, forced)
        right = np.empty((3, zones.cells.size))
        right[0], right[1:] = -self._gap[contact], self._slip[:, contact]
        right[1:] -= np.einsum("kn,kn->n", right[1:], zones.normal) * zones.normal
        right /= unit
        wanted = (missing / self._arms)[forced] / self._normal.cell_area
        try:
            equations = JointEquations(self.operator, self._fields, zones)
            change, amplitudes, iterations = equations.solve(right, wanted, reduction, most)
        except np.linalg.LinAlgError:  # numbers without bounds, from zones that cannot bear the load
            return False
        self.iterations += iterations
        work.pressure[contact] += change[0]
        work.shear[:, contact] += change[1:]
        work.rigid[forced] += amplitudes * unit / self._arms[forced]
        np.maximum(work.pressure, 0.0, out=work.pressure)
        self._left |= contact & (work.pressure == 0.0)
        contact &= work.pressure > 0.0
        work.shear *= contact
        return True

    def _zones(self, problem: Problem, work: Estimate, forced: IndexArray) -> Zones:
        """What a step takes as given, with the motions of the `forced` modes."""
        contact, unit = self._contact, self.operator.inner.unit
        slipping, bound = work.slipping[contact], problem.friction * work.pressure[contact]
        stiffness = np.full(bound.shape, STIFFEST)
        np.divide(self._forward[contact], bound * unit, out=stiffness, where=bound * unit > 0.0)
        stiffness = np.where(slipping, np.clip(stiffness, 0.0, STIFFEST), 0.0)
        row, column = np.nonzero(contact)
        x, y = self._normal.x[row] / self._reach, self._normal.y[column] / self._reach
        motions = np.zeros((6, 3, bound.size))
        motions[0, 0], motions[1, 0], motions[2, 0] = 1.0, y, x
        motions[3, 1], motions[4, 2], motions[5, 1], motions[5, 2] = 1.0, 1.0, -y, x
        cells = np.flatnonzero(contact)
        return Zones(cells, work.direction[:, contact], problem.friction * slipping, stiffness, motions[forced])


def _forced(problem: Problem) -> BoolArray:
    return np.array([*problem.normal.forced, *problem.tangential.forced])
