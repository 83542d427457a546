"""An increment given to `coupled_newton`: where its passes do not settle, pressure and shear are found together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.elastic.rounding import LEAST_MOTION, circle_width
from fretsolve.increment.grid_hierarchy import Level
from fretsolve.increment.working_state import FIRST_TOLERANCE, Iterate, Start
from fretsolve.model.load_path import Increment
from fretsolve.result.state import nothing
from fretsolve.solvers.coupled_newton import Estimate, JointSolver, Problem, solve_jointly
from fretsolve.system.arrays import FloatArray

if TYPE_CHECKING:
    from fretsolve.model.required_terms import Model



@dataclass(frozen=True)
class Reference:
    """Tractions whose elastic slip since the increment's start is known: pressure (nx, ny); shear and slip (2, nx, ny).

    In double precision these are none, and the start's displacement; in single precision, where the difference of two
    displacements would lose the slip, those that the passes begin with.
    """

    pressure: FloatArray
    shear: FloatArray
    elastic_slip: FloatArray

    @classmethod
    def of(cls, start: Start, work: Iterate, precision: type[np.floating]) -> Reference:
        """That of passes that begin with the tractions of `work`, whose arrays are not kept."""
        unsheared = nothing(start.shear.shape)
        if precision is np.float64:
            return cls(nothing(start.pressure.shape), unsheared, start.displacement)
        if start.elastic_slip is None:
            return cls(start.pressure, start.shear, unsheared)
        return cls(work.pressure.copy(), work.shear.copy(), start.elastic_slip)


class JointPass:
    """Solves for pressure and shear at once, on the grid of `level` between surfaces of `separation` (nx, ny).

    Its arrays are there only while it works, since few increments need it.
    """

    def __init__(self, level: Level, separation: FloatArray, model: Model, max_iterations: int):
        self._level, self._separation, self._model = level, separation, model
        self._max_iterations = max_iterations

    def solve(
        self,
        increment: Increment,
        start: Start,
        work: Iterate,
        reference: Reference,
        target: float,
        least_slip: float,
    ) -> bool:
        """Solve to the tolerance `target`; whether that succeeded, else tractions and displacements of `work` stay.

        least_slip: length that slips are measured against at least (mm).
        """
        level = self._level
        solver = JointSolver(level.operator, level.grid, level.tangential.room)
        problem = self._problem(increment, start, reference, least_slip)
        found = solve_jointly(solver, problem, self._first(increment, start), target, self._max_iterations)
        work.iterations_normal += solver.iterations
        work.iterations_tangential += solver.iterations
        if found is None:
            work.approach = 0.0  # the normal solver's uz may be that of the joint start
            return False
        work.pressure[:], work.shear[:] = found.pressure, found.shear
        work.rigid[:3], work.rigid[3:] = found.rigid[:3], start.rigid[3:] + found.rigid[3:]
        work.alternations += 1
        work.jointly = True
        return True

    def _problem(self, increment: Increment, start: Start, reference: Reference, least_slip: float) -> Problem:
        return Problem(
            separation=self._separation,
            pressure=reference.pressure,
            shear=reference.shear,
            elastic_slip=reference.elastic_slip,
            before=start.rigid[:3],
            friction=self._model.friction,
            normal=increment.normal,
            tangential=increment.tangential.relative_to(start.rigid[3:]),
            motion=max(LEAST_MOTION * start.elastic, least_slip),
            least_slip=least_slip,
        )

    def _first(self, increment: Increment, start: Start) -> Estimate:
        """The increment's start, or without contact there the frictionless contact at its end."""
        pressure, rigid = np.array(start.pressure, np.float64), np.concatenate([start.rigid[:3], np.zeros(3)])
        if not pressure.any():
            found = self._level.normal.solve(
                self._separation, increment.normal, pressure, FIRST_TOLERANCE, self._max_iterations, rigid[:3]
            )
            rigid[:3] = found.rigid
        shear = np.array(start.shear, np.float64)
        bound = self._model.friction * (1.0 - circle_width(self._level.operator.dtype)) * pressure
        slipping = (np.hypot(shear[0], shear[1]) >= bound) & shear.any(axis=0)
        return Estimate(pressure, shear, slipping, np.zeros_like(shear), rigid)
