"""Direct solution of an increment of a line contact: Newton steps whose linear equations are solved as a whole.

On up to a few hundred strips an iteration of conjugate gradients costs the calls that it is made of, and the matrix of
the strips in contact is solved in the time of a few iterations. Shear and slip are along x. `normal` and `tangential`
state the conditions, and D1 to D7 are the steps in docs/theory.md. As the linear equations are solved exactly, each
step of the shear is followed by all that it changes of the pressure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from threadpoolctl import ThreadpoolController

from fretsolve.contact.kernels import kernels_of
from fretsolve.contact.solvers.coupled_newton import CoupledProblem
from fretsolve.contact.solvers.rigid_modes import GapErrors, NormalModes
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.operator_on_grid import strip_influence
from fretsolve.elastic.rounding import circle_width, slips
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray, IndexArray, Vector

MOST_STEPS = 25
"""Steps of the shear, and of the contact zone after each of them, after which a solve is given up. At fixed zones the
error falls by a factor of about mu beta in each of them, since the pressure follows the shear."""

JOINING = 1e-3
"""Penetration, in units of the tolerance, from which a strip joins the contact."""

MAY_JOIN = 1e-3
"""Change of the gap over the largest uz from which strips may join the contact. Below it they are looked for only at
the end, as the search takes two convolutions."""

LinearSolver = Callable[[DoubleArray], FloatArray]
"""Solves the equations of a matrix for right-hand sides (n, k)."""


@dataclass(frozen=True)
class DirectSolution:
    """pressure: (nx, 1); shear: (2, nx, 1); rigid: delta_z, phi_x, phi_y, and the increments of delta_x, delta_y,
    phi_z."""

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector


class Strips:
    """n strips of a grid, the rigid motions of their gap, (3, n), and the influence matrices between them (mm/MPa)."""

    def __init__(self, index: IndexArray, grid: LineGrid, tables: dict[str, DoubleArray]):
        self.index, self.count, self._tables = index, index.size, tables
        self.tilts: DoubleArray = np.array([np.ones(index.size), np.zeros(index.size), grid.x[index]])

    @cached_property
    def normal(self) -> DoubleArray:
        """From pressure to uz, (n, n)."""
        return self._between("zz")

    @cached_property
    def tangential(self) -> DoubleArray:
        """From shear to ux, (n, n)."""
        return self._between("xx")

    @cached_property
    def tangential_from_pressure(self) -> DoubleArray:
        """From pressure to ux, (n, n); its transpose is from shear to uz."""
        return self._between("xz") * np.sign(np.subtract.outer(self.index, self.index))

    def pressures(self, displacements: DoubleArray) -> FloatArray:
        """Return the pressures (n, k) under which the strips have these uz (n, k). Raises LinAlgError."""
        return np.linalg.solve(self.normal, displacements)

    def pressures_by_inverse(self, displacements: DoubleArray) -> DoubleArray:
        """Return the pressures by the inverse matrix, which takes two solutions and is kept. Raises LinAlgError."""
        found: DoubleArray = self._inverse @ displacements
        return found

    @cached_property
    def _inverse(self) -> DoubleArray:
        return np.asarray(np.linalg.inv(self.normal), np.float64)

    def _between(self, name: str) -> DoubleArray:
        return self._tables[name].take(np.abs(np.subtract.outer(self.index, self.index)))


class LineState:
    """The unknowns of the n strips in contact.

    contact: (nx, 1); pressure, shear, slipping, limit (of friction) and direction, the sign of the shear where it slips
    and else 0: (n,); rigid: as in `DirectSolution`.
    """

    def __init__(
        self, friction: FrictionLimit, contact: BoolArray, strips: Strips, estimate: DirectSolution, slipping: BoolArray
    ):
        self._friction, self.contact, self.strips = friction, contact, strips
        self.pressure: FloatArray = np.array(estimate.pressure[strips.index, 0], np.float64)
        self.shear: FloatArray = np.array(estimate.shear[0, strips.index, 0], np.float64)
        self.slipping, self.rigid = slipping[strips.index, 0], estimate.rigid.copy()
        self.limit: FloatArray = friction.part(contact).limit(self.pressure)
        self.direction: DoubleArray = np.zeros(strips.count)

    @property
    def has_friction(self) -> bool:
        """True if all strips have friction: others neither stick nor have a direction in which they slip."""
        return bool(self.limit.all())

    def move_to(self, contact: BoolArray, strips: Strips, pressure: FloatArray) -> None:
        """Take the pressure of strips in contact; one that is new slips as its neighbours do, or sticks."""
        if strips is not self.strips:
            shear, slipping = np.zeros(len(contact) + 2), np.zeros(len(contact) + 2, bool)
            shear[1:-1][self.strips.index], slipping[1:-1][self.strips.index] = self.shear, self.slipping
            new = np.flatnonzero(contact & ~self.contact)
            around = shear * slipping
            shear[1:-1][new] = around[new] + around[new + 2]
            slipping[1:-1][new] = shear[1:-1][new] != 0.0
            self.shear, self.slipping = shear[1:-1][strips.index], slipping[1:-1][strips.index]
        self.contact, self.strips, self.pressure = contact, strips, pressure

    def return_map(self) -> None:
        """Let shear beyond the friction limit slip, and give it the size of the limit where it slips."""
        self.limit = self._friction.part(self.contact).limit(self.pressure)
        size = np.abs(self.shear)
        self.slipping = self.slipping & (size > 0.0) | (size > self.limit)
        self.direction = np.sign(self.shear) * self.slipping
        self.shear = np.where(self.slipping, self.limit * self.direction, self.shear)


class LineDirectSolver:
    """Solves increments on one row of strips, in double precision.

    pressings, slidings: steps of the contact zone and of the shear in the last solve.
    """

    def __init__(self, operator: ElasticOperator, grid: LineGrid):
        self.operator, self._grid = operator, grid
        self._modes = NormalModes(grid, kernels_of(operator))
        self._tables = {name: strip_influence(name, grid, operator.compliances)[:, 0] for name in ("zz", "xx", "xz")}
        self._uz, self._gap, self._separation = (np.zeros(grid.shape) for _ in range(3))
        self._strips = Strips(np.zeros(0, np.intp), grid, self._tables)
        self.pressings = self.slidings = 0

    def solve(
        self, problem: CoupledProblem, estimate: DirectSolution, tolerance: float, *, presses: bool, slides: bool
    ) -> DirectSolution | None:
        """Return the solution, or None where none is found.

        presses, slides: which of pressure and shear there is to solve for. Tractions of `problem` must be 0.
        """
        self.pressings = self.slidings = 0
        coupled = slides and self.operator.terms.normal_tangential_coupling
        if slides and not _is_plane(problem, estimate):
            return None
        contact, limit = estimate.pressure > 0.0, problem.friction.limit(estimate.pressure)
        at_limit = slips(estimate.shear, limit, circle_width(np.float64))
        work = LineState(problem.friction, contact, self._strips_of(contact), estimate, at_limit)
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
                work.return_map()
                if not work.has_friction:
                    return None
            # D3: slip (T2), by a fitted motion at first, and missing loads (T3)
            slip = self._slip(problem, work, coupled)
            if not step:
                work.rigid[3:] = problem.tangential.imposed_displacement
                if not work.slipping.all():
                    work.rigid[3] = -slip[~work.slipping].mean()
            slip += work.rigid[3]
            missing = problem.tangential.imposed_resultant[0] / self._grid.cell_area - work.shear.sum()
            residual = self._residual(problem, work, slip, missing)
            settled = residual <= tolerance
            if settled and abs(work.direction.sum()) == work.strips.count:
                return None  # all strips slide one way: the load is the largest, which `tangential` refuses
            # D4 to D6
            # from a residual of 100 no step comes back
            if not settled and not (residual < 100.0 and self._slide(work, slip, missing)):
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

    def _strips_of(self, contact: BoolArray) -> Strips:
        """Return the strips in contact; the matrices between the last ones are kept."""
        index = np.flatnonzero(contact)
        if not np.array_equal(index, self._strips.index):
            self._strips = Strips(index, self._grid, self._tables)
        return self._strips

    def _opened(self, problem: CoupledProblem, work: LineState) -> float:
        """Return the largest gap in contact over the largest uz."""
        strips = work.strips
        uz = strips.normal @ work.pressure
        gap = problem.separation[strips.index, 0] + uz + work.shear @ strips.tangential_from_pressure
        gap -= work.rigid[:3] @ strips.tilts
        return float(max(gap.max(), -gap.min())) / max(float(uz.max()), TINY)

    def _press(self, problem: CoupledProblem, work: LineState, tolerance: float, coupled: bool, beyond: bool) -> bool:
        """Find the pressure at the present shear, as N1 to N8 do; return whether there is one.

        beyond: whether strips beyond the contact may join it, whose gaps take two convolutions. Else the pressure
        follows from the inverse of the matrix of the strips, which are most likely the same ones for some steps.
        """
        contact, strips = work.contact, work.strips
        if beyond:
            separation = (self._sheared(problem, work) if coupled else problem.separation)[:, 0]
        else:
            separation = problem.separation[:, 0].copy()
            separation[strips.index] += work.shear @ strips.tangential_from_pressure
        for _ in range(MOST_STEPS):
            strips = self._strips_of(contact)
            solve = strips.pressures if beyond else strips.pressures_by_inverse
            found = self._pressed(strips, problem.normal, separation[strips.index], solve)
            if found is None:
                return False
            pressure, work.rigid[:3] = found
            stays, joins = self._on_grid(strips, pressure) > 0.0, np.zeros_like(contact)
            if beyond:
                errors = self._gap_errors(separation[:, None], contact, strips, pressure, work.rigid)
                deep = JOINING * tolerance * errors.gap_scale
                if errors.penetration > deep:
                    joins = (self._gap < -deep) & ~contact
            if not joins.any() and pressure.min() > 0.0:
                work.move_to(contact, strips, pressure)
                return True
            contact = stays | joins
        return False

    def _pressed(
        self, strips: Strips, control: LoadControl, separation: FloatArray, solve: LinearSolver
    ) -> tuple[FloatArray, Vector] | None:
        """Return pressure and rigid displacements that close a separation (n,) of strips; None if there are none.

        solve: returns the pressures for displacements of the strips.
        """
        if not strips.count:
            return None
        self.pressings += 1
        forced, rigid = control.forced_index, np.array(control.imposed_displacement)
        loads = control.imposed_resultant[forced] / self._grid.cell_area
        found = _solve(solve, rigid @ strips.tilts - separation, strips.tilts[forced], loads)
        if found is None:
            return None
        rigid[forced] = found[1]
        return found[0], rigid

    def _sheared(self, problem: CoupledProblem, work: LineState) -> DoubleArray:
        """Return the separation (nx, 1) of the surfaces under the present shear."""
        self.operator.normal_from_shear(self._shear_of(work), self._separation)
        return np.add(self._separation, problem.separation, out=self._separation)

    def _gap_errors(
        self, separation: FloatArray, contact: BoolArray, strips: Strips, pressure: FloatArray, rigid: Vector
    ) -> GapErrors:
        """Return the errors of the gap under the pressure (n,) of strips, and keep that gap."""
        self.operator.normal(self._on_grid(strips, pressure), self._uz)
        return self._modes.gap(separation, self._uz, rigid[:3], contact, self._gap)

    def _penetrates(self, problem: CoupledProblem, work: LineState, tolerance: float) -> bool:
        """Return whether strips beyond the contact are to join it at the present pressure and shear."""
        separation = self._sheared(problem, work)
        errors = self._gap_errors(separation, work.contact, work.strips, work.pressure, work.rigid)
        return errors.penetration > JOINING * tolerance * errors.gap_scale

    def _slip(self, problem: CoupledProblem, work: LineState, coupled: bool) -> DoubleArray:
        strips = work.strips
        slip: DoubleArray = problem.elastic_slip[0, strips.index, 0] - strips.tangential @ work.shear
        if coupled:
            slip -= strips.tangential_from_pressure @ work.pressure
        return slip

    def _residual(self, problem: CoupledProblem, work: LineState, slip: DoubleArray, missing: float) -> float:
        """Return the largest error of slips and loads over their scales, as in `tangential`."""
        moved = work.rigid.copy()
        moved[:3] -= problem.before
        motion = max(problem.motion, float((np.abs(moved) * self._modes.arms).max()), TINY)
        errors = np.where(work.slipping, np.maximum(0.0, -slip * work.direction), np.abs(slip)) / motion
        return max(float(errors.max()), abs(missing) / max(float(work.limit.sum()), TINY))

    def _slide(self, work: LineState, slip: DoubleArray, missing: float) -> bool:
        """Change the shear by a Newton step; return whether there is one.

        slip: (n,); missing: of the load along x, over a cell's area.
        """
        self.slidings += 1
        # D4: strips that slip against their shear stick
        forward = slip * work.direction
        sticking = ~work.slipping | (forward < 0.0)
        if not sticking.any():
            sticking = forward == forward.min()  # where all strips slip, nothing else could carry the force
        work.slipping &= ~sticking
        # D5: (T11) as a whole; unknown is the change in each strip that sticks
        stuck = np.flatnonzero(sticking)
        matrix = work.strips.tangential[stuck[:, None], stuck]
        loads, motions = np.array([missing]), np.ones((1, stuck.size))
        found = _solve(lambda right: np.linalg.solve(matrix, right), slip[stuck], motions, loads)
        if found is None:
            return False
        work.shear[stuck] += found[0]
        work.rigid[3] += found[1][0]
        # D6: shear beyond the friction limit slips; in the slip zone q = b n
        work.return_map()
        return True

    def _on_grid(self, strips: Strips, values: FloatArray) -> DoubleArray:
        field = np.zeros(self._grid.shape)
        field[strips.index, 0] = values
        return field

    def _shear_of(self, work: LineState) -> DoubleArray:
        along_x = self._on_grid(work.strips, work.shear)
        return np.array([along_x, np.zeros_like(along_x)])

    def _solution(self, work: LineState) -> DirectSolution:
        return DirectSolution(self._on_grid(work.strips, work.pressure), self._shear_of(work), work.rigid)


def _is_plane(problem: CoupledProblem, estimate: DirectSolution) -> bool:
    """Return whether a load is imposed along x, and nothing acts or moves along y."""
    control = problem.tangential
    along_y = control.imposed_resultant[1:].any() or control.imposed_displacement[1:].any()
    return 0 in control.forced_index and not (along_y or estimate.shear[1].any() or problem.elastic_slip[1].any())


def _solve(
    solve: LinearSolver, right: DoubleArray, motions: DoubleArray, loads: DoubleArray
) -> tuple[FloatArray, FloatArray] | None:
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
            amplitudes = np.linalg.solve(resultants[:, 1:], loads - resultants[:, 0])
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
    """Return what sets the threads of linear algebra. To find them takes 1 ms, a tenth of a small coarse run."""
    return ThreadpoolController()
