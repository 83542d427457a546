"""One increment solved by the coupled Newton method, where staggered iterations do not converge."""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.rounding import LEAST_MOTION, circle_width, slips
from fretsolve.increment.grid_hierarchy import GridLevel
from fretsolve.increment.working_state import FIRST_TOLERANCE, InitialState, WorkingState
from fretsolve.model.load_path import Increment
from fretsolve.result.state import nothing
from fretsolve.solvers.coupled_newton import CoupledNewton, CoupledProblem, CoupledState
from fretsolve.system.arrays import FloatArray


class CoupledStep:
    """Solves an increment for pressure and shear together.

    separation: (nx, ny), undeformed; work: the state that the staggered iterations start with; least_slip: least scale
    of slips (mm); possible: False where there is no shear, or a torque about an origin too far away.
    """

    def __init__(
        self,
        level: GridLevel,
        separation: FloatArray,
        friction: float,
        increment: Increment,
        start: InitialState,
        work: WorkingState,
        least_slip: float,
        max_iterations: int,
        possible: bool,
    ):
        self._level, self._start, self._max_iterations, self._possible = level, start, max_iterations, possible
        if not possible:
            return
        # The problem refers to tractions whose elastic slip since the start is known. In double precision these are
        # none, with the start's displacement. In single precision, where the difference of two displacements would
        # lose the slip, they are those that the staggered iterations start with.
        pressure, shear, elastic_slip = start.pressure, start.shear, nothing(start.shear.shape)
        if level.operator.dtype is np.float64:
            pressure, shear, elastic_slip = nothing(pressure.shape), elastic_slip, start.displacement
        elif start.elastic_slip is not None:
            pressure, shear, elastic_slip = work.pressure.copy(), work.shear.copy(), start.elastic_slip
        self._problem = CoupledProblem(
            separation=separation,
            pressure=pressure,
            shear=shear,
            elastic_slip=elastic_slip,
            before=start.rigid[:3],
            friction=friction,
            normal=increment.normal,
            tangential=increment.tangential.relative_to(start.rigid[3:]),
            motion=max(LEAST_MOTION * start.largest_displacement, least_slip),
            least_slip=least_slip,
        )

    def solve(self, work: WorkingState, target: float) -> bool:
        """Solve to the tolerance `target`; return whether that succeeded, else `work` keeps its tractions.

        The arrays of the method exist only during this call, since few increments need it.
        """
        if not self._possible:
            return False
        level, start = self._level, self._start
        newton = CoupledNewton(level.operator, level.grid, level.tangential.workspace)
        found = newton.solve(self._problem, self._first(), target, self._max_iterations)
        work.iterations_normal += newton.iterations
        work.iterations_tangential += newton.iterations
        if found is None:
            work.gap_scale = 0.0  # the normal solver may hold the displacement of the first state
            return False
        work.pressure[:], work.shear[:] = found.pressure, found.shear
        work.rigid[:3], work.rigid[3:] = found.rigid[:3], start.rigid[3:] + found.rigid[3:]
        work.staggered_iterations += 1
        work.coupled_step = True
        return True

    def _first(self) -> CoupledState:
        """Return the increment's start, or without contact there the frictionless contact at its end."""
        problem, start = self._problem, self._start
        pressure, rigid = np.array(start.pressure, np.float64), np.concatenate([start.rigid[:3], np.zeros(3)])
        if not pressure.any():
            found = self._level.normal.solve(
                problem.separation, problem.normal, pressure, FIRST_TOLERANCE, self._max_iterations, rigid[:3]
            )
            rigid[:3] = found.rigid
        shear, within = np.array(start.shear, np.float64), circle_width(self._level.operator.dtype)
        slipping = slips(shear, problem.friction * pressure, within) & shear.any(axis=0)
        return CoupledState(pressure, shear, slipping, np.zeros_like(shear), rigid)
