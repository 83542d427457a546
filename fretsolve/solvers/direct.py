"""Direct solution of an increment with few cells in contact: Newton steps whose linear equations are solved as a whole.

On up to a hundred cells an iteration of conjugate gradients costs the calls that it is made of, and the matrix of the
cells in contact is solved in the time of a few of them. The conditions are those of `normal` and `tangential`, and D1
to D7 are the steps in docs/theory.md. As the linear equations are solved exactly, each step of the shear is followed by
all that it changes of the pressure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial

import numpy as np
from threadpoolctl import ThreadpoolController

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import LEAST_SLIP, circle_width, slips
from fretsolve.model.grid import Grid, LineGrid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.coupled_newton import CoupledProblem
from fretsolve.solvers.direct_contact import DirectContact, DirectSolution
from fretsolve.solvers.influence_matrices import Cells, InfluenceTables
from fretsolve.solvers.rigid_modes import GapErrors, NormalModes, solve_modes
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray, Vector

MOST_STEPS = 25
"""Steps of the shear, and of the contact zone after each of them, after which a solve is given up. At fixed zones the
error falls by a factor of about mu beta in each of them, since the pressure follows the shear."""

JOINING = 1e-3
"""Penetration, in units of the tolerance, from which a cell joins the contact."""

MAY_JOIN = 1e-3
"""Change of the gap over the largest uz from which cells may join the contact. Below it they are looked for in the end
alone, as that takes two convolutions."""

LOST = 100.0
"""Residual from which no step comes back."""

LinearSolver = Callable[[DoubleArray], DoubleArray]
"""Solves the equations of a matrix for right-hand sides (n, k)."""


class DirectSolver:
    """Solves increments on one grid, in double precision.

    pressings, slidings: steps of the contact zone and of the shear in the last solve.
    """

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.operator, self._grid = operator, grid
        self._modes = NormalModes(grid, operator.kernels)
        self._tables = InfluenceTables(operator, grid)
        self._uz, self._gap, self._separation = (np.zeros(grid.shape) for _ in range(3))
        self._cells = Cells(np.zeros(0, np.intp), grid, self._tables)
        self._is_line = isinstance(grid, LineGrid)
        self.pressings = self.slidings = 0

    def solve(
        self, problem: CoupledProblem, estimate: DirectSolution, tolerance: float, *, presses: bool, slides: bool
    ) -> DirectSolution | None:
        """Return the solution, or None where none is found.

        presses, slides: which of pressure and shear there is to solve for. Tractions of `problem` must be 0.
        """
        self.pressings = self.slidings = 0
        coupled = slides and self.operator.terms.normal_tangential_coupling
        work = self._begin(problem, estimate)
        if slides and not work.has_friction:
            return None
        pressing, beyond = presses, True  # whether D1 presses, and with a look beyond the contact
        for step in range(MOST_STEPS):
            # D1: a pressure that closes the gap
            if pressing and not self._press(problem, work, tolerance, coupled, beyond):
                return None
            if not slides:
                return self._solution(work)
            # D2: shear on the friction limit where it slips
            if pressing or not step:
                work.put_on_circle()
                if not work.has_friction:
                    return None
            # D3: slip (T2), by a fitted motion at first, and missing loads (T3)
            slip = self._slip(problem, work, coupled)
            if not step:
                self._fit_motion(problem.tangential, work, slip)
            missing = problem.tangential.imposed_resultant / self._grid.cell_area - work.cells.motions @ work.shear
            forward = work.along(slip)
            residual = self._residual(problem, work, slip, forward, missing)
            settled = residual <= tolerance
            # D4 to D6
            if not settled and not (residual < LOST and self._slide(problem.tangential, work, slip, forward, missing)):
                return None
            # D7: stop where the gap stays closed, also beyond the contact; else go to D1
            opened = self._opened(problem, work) if coupled else 0.0
            if settled and opened <= tolerance:
                if beyond or not self._penetrates(problem, work, tolerance):
                    return self._solution(work)
                opened = math.inf
            pressing = opened > tolerance
            if pressing:
                beyond = opened > MAY_JOIN
        return None

    def _begin(self, problem: CoupledProblem, estimate: DirectSolution) -> DirectContact:
        """Return the estimate on the cells in contact."""
        contact, limit = estimate.pressure > 0.0, problem.friction.limit(estimate.pressure)
        cells = self._cells_of(contact)
        shear = np.array(estimate.shear.reshape(2, -1)[:, cells.index], np.float64).ravel()
        slipping = slips(estimate.shear, limit, circle_width(np.float64)).ravel()[cells.index]
        pressure = np.array(estimate.pressure.ravel()[cells.index], np.float64)
        return DirectContact(problem.friction, contact, cells, pressure, shear, slipping, estimate.rigid.copy())

    def _cells_of(self, contact: BoolArray) -> Cells:
        """Return the cells in contact; the matrices between the last ones are kept."""
        index = np.flatnonzero(contact)
        if not np.array_equal(index, self._cells.index):
            self._cells = Cells(index, self._grid, self._tables)
        return self._cells

    def _opened(self, problem: CoupledProblem, work: DirectContact) -> float:
        """Return the largest gap in contact over the largest uz."""
        cells = work.cells
        uz = cells.normal @ work.pressure
        gap = problem.separation.ravel()[cells.index] + uz + work.shear @ cells.sideways - work.rigid[:3] @ cells.tilts
        return float(max(gap.max(), -gap.min())) / max(float(uz.max()), TINY)

    def _press(
        self, problem: CoupledProblem, work: DirectContact, tolerance: float, coupled: bool, beyond: bool
    ) -> bool:
        """Find the pressure at the present shear, as N1 to N8 do; return whether there is one.

        beyond: whether cells beyond the contact may join it, whose gaps take two convolutions.
        """
        if not beyond:
            return self._press_within(problem, work)
        contact = work.contact
        separation = self._sheared(problem, work) if coupled else problem.separation
        for _ in range(MOST_STEPS):
            cells = self._cells_of(contact)
            found = self._pressed(cells, problem.normal, separation.ravel()[cells.index], cells.pressures)
            if found is None:
                return False
            pressure, work.rigid[:3] = found
            errors = self._gap_errors(separation, contact, cells, pressure, work.rigid)
            deep = JOINING * tolerance * errors.gap_scale
            if pressure.min() > 0.0 and errors.penetration <= deep:
                work.move_to(contact, cells, pressure)
                return True
            stays = self._on_grid(cells, pressure[None])[0] > 0.0
            contact = stays | (self._gap < -deep) & ~contact
        return False

    def _press_within(self, problem: CoupledProblem, work: DirectContact) -> bool:
        """Find the pressure at the present shear, of which no cell joins the contact; return whether there is one.

        It follows from the inverse of the matrix of the cells, which are most likely the same ones for some steps.
        """
        contact, cells = work.contact, work.cells
        separation = problem.separation.ravel()[cells.index] + work.shear @ cells.sideways
        for _ in range(MOST_STEPS):
            found = self._pressed(cells, problem.normal, separation, cells.pressures_by_inverse)
            if found is None:
                return False
            pressure, work.rigid[:3] = found
            stays = pressure > 0.0
            if stays.all():
                work.move_to(contact, cells, pressure)
                return True
            contact = contact.copy()
            contact.ravel()[cells.index] = stays
            cells, separation = self._cells_of(contact), separation[stays]
        return False

    def _pressed(
        self, cells: Cells, control: LoadControl, separation: FloatArray, solve: LinearSolver
    ) -> tuple[DoubleArray, Vector] | None:
        """Return pressure and rigid displacements that close a separation (n,) of cells; None if there are none.

        solve: returns the pressures for displacements of the cells.
        """
        if not cells.count:
            return None
        self.pressings += 1
        forced, rigid = control.forced_index, np.array(control.imposed_displacement)
        loads = control.imposed_resultant[forced] / self._grid.cell_area
        found = _solve(solve, rigid @ cells.tilts - separation, cells.tilts[forced], loads)
        if found is None:
            return None
        rigid[forced] = found[1]
        return found[0], rigid

    def _sheared(self, problem: CoupledProblem, work: DirectContact) -> DoubleArray:
        """Return the separation (nx, ny) of the surfaces under the present shear."""
        shear = self._on_grid(work.cells, work.shear.reshape(2, -1))
        self.operator.normal_from_shear(shear, self._separation)
        return np.add(self._separation, problem.separation, out=self._separation)

    def _gap_errors(
        self, separation: FloatArray, contact: BoolArray, cells: Cells, pressure: DoubleArray, rigid: Vector
    ) -> GapErrors:
        """Return the errors of the gap under the pressure (n,) of cells, and keep that gap."""
        self.operator.normal(self._on_grid(cells, pressure[None])[0], self._uz)
        return self._modes.gap(separation, self._uz, rigid[:3], contact, self._gap)

    def _penetrates(self, problem: CoupledProblem, work: DirectContact, tolerance: float) -> bool:
        """Return whether cells beyond the contact are to join it at the present pressure and shear."""
        separation = self._sheared(problem, work)
        errors = self._gap_errors(separation, work.contact, work.cells, work.pressure, work.rigid)
        return errors.penetration > JOINING * tolerance * errors.gap_scale

    def _slip(self, problem: CoupledProblem, work: DirectContact, coupled: bool) -> DoubleArray:
        """Return the slip of the cells in contact without the forced motion, (2 n,)."""
        cells = work.cells
        slip: DoubleArray = problem.elastic_slip.reshape(2, -1)[:, cells.index].ravel() - cells.tangential @ work.shear
        if coupled:
            slip -= cells.sideways @ work.pressure
        slip += work.rigid[3:] @ cells.motions
        return slip

    def _fit_motion(self, control: LoadControl, work: DirectContact, slip: DoubleArray) -> None:
        """Add to `slip` the imposed motion, and the forced one that makes it least across the shear (N' W T s = 0)."""
        motions, forced = work.cells.motions, control.forced_index
        work.rigid[3:] = control.imposed_displacement
        slip += work.rigid[3:] @ motions
        if forced:
            across = work.across(motions)
            work.rigid[3:] -= solve_modes(across @ across.T, across @ slip, forced)
            slip += (work.rigid[3:] - control.imposed_displacement) @ motions

    def _residual(
        self, problem: CoupledProblem, work: DirectContact, slip: DoubleArray, forward: DoubleArray, missing: Vector
    ) -> float:
        """Return the largest error of slips and loads over their scales, as in `tangential`.

        forward: the part of the slip along the shear, (n,).
        """
        moved = work.rigid.copy()
        moved[:3] -= problem.before
        motion = max(problem.motion, float((np.abs(moved) * self._modes.arms).max()), TINY)
        (slip_x, slip_y), (along_x, along_y) = slip.reshape(2, -1), work.direction
        distance, across = np.hypot(slip_x, slip_y), np.abs(slip_x * along_y - slip_y * along_x)
        largest = max(float(distance.max()), LEAST_SLIP * motion, problem.least_slip)
        errors = np.where(work.slipping, np.maximum(across / largest, -forward / motion), distance / motion)
        carried = max(float(work.limit.sum()), TINY)
        unbalance = max(
            (abs(missing[mode]) / self._modes.arms[3 + mode] for mode in problem.tangential.forced_index), default=0.0
        )
        return max(float(errors.max()), unbalance / carried)

    def _slide(
        self, control: LoadControl, work: DirectContact, slip: DoubleArray, forward: DoubleArray, missing: Vector
    ) -> bool:
        """Change the shear by a Newton step; return whether there is one.

        slip: (2 n,), its part `forward` along the shear, (n,); missing: loads over a cell's area, (3,).
        """
        self.slidings += 1
        # D4: cells that slip against their shear stick
        along_y = not self._is_line or slip[work.cells.count :].any() or missing[1] or work.direction[1].any()
        forced = [mode for mode in control.forced_index if along_y or mode == 0]
        sticking = ~work.slipping | (forward < 0.0)
        if not along_y and forced and not sticking.any():
            sticking = forward == forward.min()  # where all of a line contact slips, nothing else could carry the force
        work.slipping &= ~sticking
        # D5: (T11) as a whole. Unknown is the change across the shear of each cell that slips, and along x and y of one
        # that sticks; in the plane of a line contact that along x of each one that sticks
        unknowns = work.unknowns(in_plane=not along_y)
        right, motions = unknowns.reduced(slip[None])[0], unknowns.reduced(work.cells.motions[forced])
        found = _solve(partial(np.linalg.solve, unknowns.matrix(forward)), right, motions, missing[forced])
        if found is None:
            return False
        work.shear += unknowns.expanded(found[0])
        work.rigid[3:][forced] += found[1]
        # D6: shear beyond the friction limit slips; in the slip zone q = b n
        work.put_on_circle()
        return True

    def _on_grid(self, cells: Cells, values: DoubleArray) -> DoubleArray:
        """Return values (c, n) of cells as a field (c, nx, ny)."""
        field = np.zeros((len(values), *self._grid.shape))
        field.reshape(len(values), -1)[:, cells.index] = values
        return field

    def _solution(self, work: DirectContact) -> DirectSolution:
        (pressure,) = self._on_grid(work.cells, work.pressure[None])
        return DirectSolution(pressure, self._on_grid(work.cells, work.shear.reshape(2, -1)), work.rigid)


def _solve(
    solve: LinearSolver, right: DoubleArray, motions: DoubleArray, loads: DoubleArray
) -> tuple[DoubleArray, DoubleArray] | None:
    """Return x and m of ``K x = right + motions' m``, ``motions x = loads``; None where the matrix K is singular.

    solve: returns ``K^-1 y`` (n, k) for right-hand sides y (n, k).
    """
    try:
        answers = solve(np.concatenate([right[None], motions]).T)
        if not len(motions):
            return answers[:, 0], loads
        resultants = motions @ answers
        if len(motions) == 1 and resultants[0, 1]:  # NumPy's solver would take a twentieth of a small increment here
            amplitudes = (loads - resultants[:, 0]) / resultants[0, 1]
        else:
            amplitudes = np.linalg.solve(resultants[:, 1:], loads - resultants[:, 0]).astype(np.float64)
    except np.linalg.LinAlgError:
        return None
    return answers[:, 0] + answers[:, 1:] @ amplitudes, amplitudes


@contextmanager
def on_one_thread() -> Iterator[None]:
    """Let linear algebra run on one thread: more threads gain nothing, and the bits would depend on their number."""
    libraries = _libraries()
    if all(library.num_threads == 1 for library in libraries.lib_controllers if library.user_api == "blas"):
        yield  # setting them anew takes 2 % of a small increment
    else:
        with libraries.limit(limits=1, user_api="blas"):
            yield


@cache
def _libraries() -> ThreadpoolController:
    """Return what sets the threads of linear algebra.

    Finding the libraries takes 1 ms, a tenth of a small coarse run.
    """
    return ThreadpoolController()
