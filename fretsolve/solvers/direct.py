"""Direct solution of an increment with few cells in contact: Newton steps whose linear equations are solved as a whole.

On up to a hundred cells an iteration of conjugate gradients costs the calls that it is made of, and the matrix of the
cells in contact is solved in the time of a few of them. The conditions are those of `normal` and `tangential`, and D1
to D6 are the steps in docs/theory.md. As the linear equations are solved exactly, each step of the shear is followed by
all that it changes of the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from threadpoolctl import ThreadpoolController

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP, circle_width, slips
from fretsolve.friction.bound import FrictionBound
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.coupled_newton import CoupledProblem
from fretsolve.solvers.influence_matrices import Cells, InfluenceTables
from fretsolve.solvers.rigid_modes import NormalModes, solve_modes
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray, Vector

MOST_STEPS = 15
"""Steps of the shear, and of the contact zone after each of them, after which a solve is given up."""

JOINING = 1e-3
"""Penetration, in units of the tolerance, from which a cell joins the contact."""

LOST = 100.0
"""Residual from which no step comes back."""


@dataclass(frozen=True)
class DirectSolution:
    """pressure: (nx, ny); shear: (2, nx, ny); rigid: delta_z, phi_x, phi_y, and the increments of delta_x, delta_y,
    phi_z."""

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector


class DirectSolver:
    """Solves increments on one grid, in double precision.

    pressings, slidings: steps of the contact zone and of the shear in the last solve; threads: of the linear algebra,
    one of which is to be used.
    """

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator, self._grid = operator, grid
        self._modes, self._arms = NormalModes(grid, operator.kernels), NormalModes(grid).arms
        self._tables = InfluenceTables(operator, grid)
        self._uz, self._gap, self._separation = (np.zeros(grid.shape) for _ in range(3))
        self._cells = Cells(np.zeros(0, np.intp), grid, self._tables)
        # More threads gain nothing with so small matrices, and the bits would depend on their number.
        self.threads = _threads_of_libraries()
        self.pressings = self.slidings = 0

    def solve(
        self,
        problem: CoupledProblem,
        estimate: DirectSolution,
        tolerance: float,
        slipping: BoolArray | bool = False,
        *,
        presses: bool,
        slides: bool,
    ) -> DirectSolution | None:
        """Return the solution, or None where none is found.

        slipping: cells (nx, ny) expected to slip besides those that have reached the friction limit; presses, slides:
        which of pressure and shear there is to solve for. Tractions of `problem` must be 0.
        """
        self.pressings = self.slidings = 0
        coupled = slides and self.operator.terms.normal_tangential_coupling
        work = self._begin(problem, estimate, slipping)
        for step in range(MOST_STEPS):
            # D1: where the shear has changed the gap, a pressure that closes it
            pressed = self._opened(problem, work) > tolerance if step and coupled else presses and not step
            if pressed and not self._press(problem, work, tolerance, coupled):
                return None
            if not slides:
                return self._solution(work)
            # D2: shear on the friction limit where it slips
            if pressed or not step:
                work.put_on_circle()
            # D3: slip (T2), by a fitted motion at first, and missing loads (T3); stop at the tolerance
            slip = self._slip(problem, work, coupled)
            if not step:
                self._fit_motion(problem.tangential, work, slip)
            missing = problem.tangential.imposed_resultant / self._grid.cell_area - work.cells.motions @ work.shear
            residual = self._residual(problem, work, slip, missing)
            if residual <= tolerance and not (pressed and coupled):
                return self._solution(work)
            if not residual < LOST:
                return None
            # D4 to D6
            if residual > tolerance and not self._slide(problem.tangential, work, slip, missing):
                return None
        return None

    def _begin(self, problem: CoupledProblem, estimate: DirectSolution, expected: BoolArray | bool) -> _Contact:
        """Return the estimate on the cells in contact."""
        contact, limit = estimate.pressure > 0.0, problem.friction.limit(estimate.pressure)
        cells = self._cells_of(contact)
        shear = np.array(estimate.shear.reshape(2, -1)[:, cells.index], np.float64).ravel()
        slipping = (slips(estimate.shear, limit, circle_width(np.float64)) | expected).ravel()[cells.index]
        pressure = np.array(estimate.pressure.ravel()[cells.index], np.float64)
        return _Contact(problem.friction, contact, cells, pressure, shear, slipping, estimate.rigid.copy())

    def _cells_of(self, contact: BoolArray) -> Cells:
        """Return the cells in contact; the matrices between the last ones are kept."""
        index = np.flatnonzero(contact)
        if not np.array_equal(index, self._cells.index):
            self._cells = Cells(index, self._grid, self._tables)
        return self._cells

    def _opened(self, problem: CoupledProblem, work: _Contact) -> float:
        """Return the largest gap in contact over the largest uz."""
        cells = work.cells
        uz = cells.normal @ work.pressure
        gap = problem.separation.ravel()[cells.index] + uz + work.shear @ cells.sideways - work.rigid[:3] @ cells.tilts
        return float(np.abs(gap).max()) / max(float(uz.max()), TINY)

    def _press(self, problem: CoupledProblem, work: _Contact, tolerance: float, coupled: bool) -> bool:
        """Find the pressure at the present shear, as N1 to N8 do; return whether there is one."""
        control, separation, contact = problem.normal, problem.separation, work.contact
        forced, loads = control.forced_index, control.imposed_resultant / self._grid.cell_area
        if coupled:
            shear = self._on_grid(work.cells, work.shear.reshape(2, -1))
            self.operator.normal_from_shear(shear, self._separation)
            separation = np.add(self._separation, separation, out=self._separation)
        whole = np.zeros(self._grid.shape)
        for _ in range(MOST_STEPS):
            cells = self._cells_of(contact)
            if not cells.count:
                return False
            self.pressings += 1
            right = control.imposed_displacement @ cells.tilts - separation.ravel()[cells.index]
            found = _solve(cells.normal, right, cells.tilts[forced], loads[forced])
            if found is None:
                return False
            pressure, work.rigid[:3] = found[0], control.imposed_displacement
            work.rigid[forced] = found[1]
            whole.fill(0.0)
            whole.ravel()[cells.index] = pressure
            self.operator.normal(whole, self._uz)
            errors = self._modes.gap(separation, self._uz, work.rigid[:3], contact, self._gap)
            deep = JOINING * tolerance * errors.gap_scale
            if pressure.min() > 0.0 and errors.penetration <= deep:
                work.move_to(contact, cells, pressure)
                return True
            contact = (whole > 0.0) | (self._gap < -deep) & ~contact
        return False

    def _slip(self, problem: CoupledProblem, work: _Contact, coupled: bool) -> DoubleArray:
        """Return the slip of the cells in contact without the forced motion, (2 n,)."""
        cells = work.cells
        slip: DoubleArray = problem.elastic_slip.reshape(2, -1)[:, cells.index].ravel() - cells.tangential @ work.shear
        if coupled:
            slip -= cells.sideways @ work.pressure
        slip += work.rigid[3:] @ cells.motions
        return slip

    def _fit_motion(self, control: LoadControl, work: _Contact, slip: DoubleArray) -> None:
        """Add to `slip` the imposed motion, and the forced one that makes it least across the shear (N' W T s = 0)."""
        motions, forced = work.cells.motions, control.forced_index
        work.rigid[3:] = control.imposed_displacement
        slip += work.rigid[3:] @ motions
        if forced:
            across = work.across(motions)
            work.rigid[3:] -= solve_modes(across @ across.T, across @ slip, forced)
            slip += (work.rigid[3:] - control.imposed_displacement) @ motions

    def _residual(self, problem: CoupledProblem, work: _Contact, slip: DoubleArray, missing: Vector) -> float:
        """Return the largest error of slips and loads over their scales, as in `tangential`."""
        moved = work.rigid.copy()
        moved[:3] -= problem.before
        motion = max(problem.motion, float((np.abs(moved) * self._arms).max()), TINY)
        (slip_x, slip_y), (along_x, along_y) = slip.reshape(2, -1), work.direction
        distance, forward = np.hypot(slip_x, slip_y), slip_x * along_x + slip_y * along_y
        across = np.abs(slip_x * along_y - slip_y * along_x)
        largest = max(float(distance.max()), LEAST_SLIP * motion, problem.least_slip)
        errors = np.where(work.slipping, np.maximum(across / largest, -forward / motion), distance / motion)
        forced, carried = problem.tangential.forced_index, max(float(work.limit.sum()), TINY)
        unbalance = float(np.max(np.abs(missing / self._arms[3:])[forced], initial=0.0)) / carried
        return max(float(errors.max()), unbalance)

    def _slide(self, control: LoadControl, work: _Contact, slip: DoubleArray, missing: Vector) -> bool:
        """Change the shear by a Newton step; return whether there is one."""
        self.slidings += 1
        # D4: cells that slip against their shear stick
        forward = np.einsum("kn,kn->n", slip.reshape(2, -1), work.direction)
        work.let_stick(forward < 0.0)
        # D5: (T11) as a whole. Unknown is the change across the shear of each cell that slips, and along x and y of one
        # that sticks
        matrix, forced = work.reduced(work.reduced(work.cells.tangential).T), control.forced_index
        slipping = np.flatnonzero(work.slipping)
        matrix[slipping, slipping] += forward[slipping] / work.limit[slipping]
        right, motions = work.reduced(slip[None])[0], work.reduced(work.cells.motions[forced])
        found = _solve(matrix, right, motions, missing[forced])
        if found is None:
            return False
        work.shear += work.expanded(found[0])
        work.rigid[3:][forced] += found[1]
        # D6: shear beyond the friction limit slips; in the slip zone q = b n
        work.put_on_circle()
        return True

    def _on_grid(self, cells: Cells, values: DoubleArray) -> DoubleArray:
        """Return values (c, n) of cells as a field (c, nx, ny)."""
        field = np.zeros((len(values), *self._grid.shape))
        field.reshape(len(values), -1)[:, cells.index] = values
        return field

    def _solution(self, work: _Contact) -> DirectSolution:
        (pressure,) = self._on_grid(work.cells, work.pressure[None])
        return DirectSolution(pressure, self._on_grid(work.cells, work.shear.reshape(2, -1)), work.rigid)


class _Contact:
    """The unknowns of the n cells in contact.

    contact: the cells, (nx, ny); pressure, slipping, limit (of friction): (n,); shear: (2 n,), all x before all y;
    direction: of the shear where it slips, else 0, (2, n); rigid: as in `DirectSolution`.
    """

    def __init__(
        self,
        friction: FrictionBound,
        contact: BoolArray,
        cells: Cells,
        pressure: DoubleArray,
        shear: DoubleArray,
        slipping: BoolArray,
        rigid: Vector,
    ):
        self._friction, self.contact, self.cells, self.pressure = friction, contact, cells, pressure
        self.shear, self.slipping, self.rigid = shear, slipping, rigid
        self.limit: FloatArray = pressure
        self.direction: DoubleArray = np.zeros((2, cells.count))

    def move_to(self, contact: BoolArray, cells: Cells, pressure: DoubleArray) -> None:
        """Take the pressure of cells in contact; those that are new stick without shear."""
        if cells is not self.cells:
            shear, slipping = np.zeros((2, contact.size)), np.zeros(contact.size, bool)
            shear[:, self.cells.index], slipping[self.cells.index] = self.shear.reshape(2, -1), self.slipping
            self.shear, self.slipping = shear[:, cells.index].ravel(), slipping[cells.index]
        self.contact, self.cells, self.pressure = contact, cells, pressure

    def put_on_circle(self) -> None:
        """Let shear beyond the friction limit slip, and give it the length of the limit where it slips."""
        shear, self.limit = self.shear.reshape(2, -1), self._friction.part(self.contact).limit(self.pressure)
        length = np.hypot(shear[0], shear[1])
        self.slipping = self.slipping & (length > 0.0) | (length > self.limit)
        self.direction = shear * (self.slipping / np.maximum(length, TINY))
        self.shear = np.where(self.slipping, self.limit * self.direction, shear).ravel()

    def let_stick(self, cells: BoolArray) -> None:
        """Let slipping cells stick; the directions in which others may change follow."""
        self.slipping &= ~cells
        self._sticking = np.flatnonzero(~self.slipping)
        x, y = self.direction
        self._first = np.where(self.slipping, -y, 1.0), np.where(self.slipping, x, 0.0)

    def across(self, fields: DoubleArray) -> DoubleArray:
        """Return fields (m, 2 n) without their part along the direction of the shear."""
        x, y = self.direction
        parts = fields.reshape(len(fields), 2, -1)
        along = parts[:, 0] * x + parts[:, 1] * y
        rest: DoubleArray = fields - (along[:, None] * self.direction).reshape(fields.shape)
        return rest

    def reduced(self, fields: DoubleArray) -> DoubleArray:
        """Return fields (m, 2 n) by the unknowns of D5."""
        x, y = fields[:, : self.cells.count], fields[:, self.cells.count :]
        return np.concatenate([x * self._first[0] + y * self._first[1], y[:, self._sticking]], axis=1)

    def expanded(self, unknown: DoubleArray) -> DoubleArray:
        """Return the field (2 n,) of the unknowns of D5."""
        count = self.cells.count
        field = np.concatenate([unknown[:count] * self._first[0], unknown[:count] * self._first[1]])
        field[count + self._sticking] += unknown[count:]
        return field


def _solve(
    matrix: DoubleArray, right: DoubleArray, motions: DoubleArray, loads: DoubleArray
) -> tuple[DoubleArray, DoubleArray] | None:
    """Return x and m of ``matrix x = right + motions' m``, ``motions x = loads``; None where the matrix is singular."""
    try:
        answers: DoubleArray = np.linalg.solve(matrix, np.concatenate([right[None], motions]).T)
        if not len(motions):
            return answers[:, 0], loads
        resultants = motions @ answers
        amplitudes = np.linalg.solve(resultants[:, 1:], loads - resultants[:, 0]).astype(np.float64)
    except np.linalg.LinAlgError:
        return None
    return answers[:, 0] + answers[:, 1:] @ amplitudes, amplitudes


@cache
def _threads_of_libraries() -> ThreadpoolController:
    """Return what sets the threads of linear algebra.

    Finding the libraries takes 1 ms, a tenth of a small coarse run.
    """
    return ThreadpoolController()
