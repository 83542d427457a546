"""One increment solved as a whole: directly where few strips of a line contact touch, and by the coupled Newton method
where staggered iterations do not converge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.contact.increment.states import FIRST_TOLERANCE, InitialState, WorkingState
from fretsolve.contact.solvers.coupled_newton import CoupledNewton, CoupledProblem, CoupledState
from fretsolve.elastic.rounding import LEAST_MOTION, circle_width, slips
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import Increment
from fretsolve.result.state import broadcast_zeros
from fretsolve.system.arrays import FloatArray

if TYPE_CHECKING:
    from fretsolve.contact.solvers.line_direct import LineDirectSolver


def coupled_problem(
    separation: FloatArray,
    increment: Increment,
    tangential: LoadControl,
    start: InitialState,
    work: WorkingState,
    least_slip: float,
    precision: type[np.floating],
) -> CoupledProblem:
    """Return an increment as a problem of pressure and shear together.

    separation: (nx, ny), undeformed; tangential: what is imposed, displacements as increments; work: the state that the
    staggered iterations start with; least_slip: least scale of slips (mm); precision: of the elastic operator.
    """
    # tractions whose elastic slip since the start is known: none in double precision; in single precision, where the
    # difference of two displacements would lose the slip, the tractions at the start of the staggered iterations
    pressure, shear, elastic_slip = (
        broadcast_zeros(start.pressure.shape),
        broadcast_zeros(start.shear.shape),
        start.displacement,
    )
    if precision is np.float32 and work.elastic_slip is not None:
        pressure, shear, elastic_slip = work.pressure.copy(), work.shear.copy(), work.elastic_slip
    return CoupledProblem(
        separation=separation,
        pressure=pressure,
        shear=shear,
        elastic_slip=elastic_slip,
        before=start.rigid[:3],
        friction=start.friction,
        normal=increment.normal,
        tangential=tangential,
        motion=max(LEAST_MOTION * start.largest_displacement, start.largest_mismatch(work.pressure), least_slip),
        least_slip=least_slip,
        coupling=increment.coupling,
    )


def solve_coupled(
    level: GridLevel, problem: CoupledProblem, start: InitialState, work: WorkingState, target: float, most: int
) -> bool:
    """Solve to the tolerance `target` and return True, or leave the tractions of `work` and return False.

    most: iterations of each attempt.
    """
    # first state: the increment's start, or without contact there the frictionless contact at its end
    pressure, rigid = np.array(start.pressure, np.float64), np.concatenate([start.rigid[:3], np.zeros(3)])
    if not pressure.any():
        found = level.normal.solve(problem.separation, problem.normal, pressure, FIRST_TOLERANCE, most, rigid[:3])
        rigid[:3] = found.rigid
    shear, within = np.array(start.shear, np.float64), circle_width(level.operator.dtype)
    slipping = slips(shear, problem.friction.limit(pressure), within) & shear.any(axis=0)
    first = CoupledState(pressure, shear, slipping, np.zeros_like(shear), rigid)
    newton = CoupledNewton(level.operator, level.grid)  # its arrays exist only here, since few increments need it
    end = newton.solve(problem, first, target, most)
    work.iterations_normal += newton.iterations
    work.iterations_tangential += newton.iterations
    if end is None:
        work.gap_scale = 0.0  # the normal solver may hold the displacement of the first state
        return False
    work.pressure[:], work.shear[:] = end.pressure, end.shear
    work.rigid[:3], work.rigid[3:] = end.rigid[:3], start.rigid[3:] + end.rigid[3:]
    work.staggered_iterations += 1
    work.coupled_step = True
    return True


def solve_directly(
    solver: LineDirectSolver,
    problem: CoupledProblem,
    start: InitialState,
    work: WorkingState,
    target: float,
    *,
    presses: bool,
    slides: bool,
) -> bool:
    """Solve to the tolerance `target` and return True, or leave `work` and return False.

    presses, slides: which of pressure and shear there is to solve for.
    """
    from fretsolve.contact.solvers.line_direct import DirectSolution, on_one_thread  # contacts on areas do not need it

    rigid = np.concatenate([work.rigid[:3], np.zeros(3)])
    estimate = DirectSolution(work.pressure, work.shear, rigid)
    with on_one_thread():
        found = solver.solve(problem, estimate, target, presses=presses, slides=slides)
    work.iterations_normal += solver.pressings
    work.iterations_tangential += solver.slidings
    if found is None:
        return False
    work.pressure[:], work.rigid[:3] = found.pressure, found.rigid[:3]
    if slides:
        work.shear[:], work.rigid[3:] = found.shear, start.rigid[3:] + found.rigid[3:]
    work.staggered_iterations += 1
    return True
