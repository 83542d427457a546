"""The profile after many cycles of wear, implicit in the pressure at their end.

    dh/dN = r p(h)  with the rate r of each cell (mm/MPa) and the pressure p between the surfaces h

is solved over a jump of D = r dN by the two steps of an L-stable Runge-Kutta method of second order (Alexander, SIAM J.
Numer. Anal. 14, 1977). Each is a normal problem with a compliant layer:

    gap = h + g D p1 + uz(p1) - rigid,                     p1 >= 0, gap >= 0, p1 gap = 0
    gap = h + (1 - g) D p1 + g D p2 + uz(p2) - rigid,      likewise
    h  <-  h + (1 - g) D p1 + g D p2,                      g = 1 - 1/sqrt(2)

So p2 is the pressure on the new profile, all weights are positive, and the profile stays smooth however large the jump
is. An explicit step grows a checkerboard once the depth of a jump exceeds 1.16 p dx/E*.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretsolve.errors import NotConvergedError
from fretsolve.increment.grid_hierarchy import GridLevel
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.normal import NormalSolver
from fretsolve.system.arrays import FloatArray, Vector
from fretsolve.wear.compliant_operator import CompliantOperator

SHARE = 1.0 - 1.0 / math.sqrt(2.0)
"""Share g of the jump that each of the steps takes implicitly."""


@dataclass(frozen=True)
class ProfileProblem:
    """The normal problem of a jump.

    separation: (nx, ny) in mm, deformed by the shear; control: of P|delta_z, Mx|phi_x, My|phi_y; rigid: estimates of
    the normal rigid displacements.
    """

    separation: FloatArray
    control: LoadControl
    rigid: Vector


def wear_over_jump(
    level: GridLevel,
    problem: ProfileProblem,
    compliance: FloatArray,
    pressure: FloatArray,
    tolerance: float,
    max_iterations: int,
) -> FloatArray:
    """Return the depth (mm) worn over a jump of the compliance D = r dN (mm/MPa), (nx, ny).

    pressure: at its start (MPa); tolerance: of the normal problems. Raises NotConvergedError, ContactLostError.
    """
    solver = NormalSolver(CompliantOperator(level.operator, SHARE * compliance), level.grid)

    def pressed(separation: FloatArray, estimate: FloatArray) -> FloatArray:
        found = estimate.copy()
        result = solver.solve(separation, problem.control, found, tolerance, max_iterations, problem.rigid)
        if not result.converged:
            raise NotConvergedError(
                f"the worn profile is not found after {result.iterations} iterations: the largest gap error is"
                f" {result.residual:.2g} of the normal displacement, {tolerance:.2g} is needed; raise"
                " solver.max_iterations, or let a solved cycle stand for fewer"
            )
        return found

    first = pressed(problem.separation, pressure)
    explicit: FloatArray = (1.0 - SHARE) * compliance * first
    second = pressed(problem.separation + explicit, first)
    return explicit + SHARE * compliance * second
