"""The profile after many cycles of wear, implicit in the pressure at their end.

    dh/dN = r p(h)  with the rate r of each cell (mm/MPa) and the pressure p between the surfaces h

is solved over a jump of D = r dN by an L-stable Runge-Kutta method of second order (Alexander, SIAM J. Numer. Anal. 14,
1977). Each of its two stages is a normal problem with a compliant layer:

    gap = h + g D p1 + uz(p1) - rigid,                     p1 >= 0, gap >= 0, p1 gap = 0
    gap = h + (1 - g) D p1 + g D p2 + uz(p2) - rigid,      likewise
    h  <-  h + (1 - g) D p1 + g D p2,                      g = 1 - 1/sqrt(2)

So p2 is the pressure on the new profile, all weights are positive, and the profile stays smooth however large the jump
is. An explicit step grows a checkerboard once the depth of a jump exceeds 1.16 p dx/E*. The jump is cut into equal
parts, twice as many each time, until the depths of both agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.contact.solvers.normal import NormalSolver
from fretsolve.elastic.operator import INNER_PRECISION, ElasticOperator, Preconditioner
from fretsolve.errors import NotConvergedError
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import DoubleArray, FloatArray, Vector

SHARE = 1.0 - 1.0 / math.sqrt(2.0)
"""Share g of the jump that each of the stages takes implicitly."""


@dataclass(frozen=True)
class ProfileProblem:
    """The normal problem of a jump.

    separation: (nx, ny) in mm, deformed by the shear; control: of P|delta_z, Mx|phi_x, My|phi_y; rigid: estimates of
    the normal rigid displacements; pressure: at its start (MPa); tolerance, max_iterations: of each problem.
    """

    separation: DoubleArray
    control: LoadControl
    rigid: Vector
    pressure: DoubleArray
    tolerance: float
    max_iterations: int


@dataclass(frozen=True)
class WornDepth:
    """Depth that is worn over a jump (mm), (nx, ny), and its estimated error, in the mean over what is worn."""

    depth: DoubleArray
    error: float


def wear_over_jump(level: GridLevel, problem: ProfileProblem, compliance: DoubleArray, allowed: float) -> WornDepth:
    """Return the depth that is worn over a jump of the compliance D = r dN (mm/MPa), (nx, ny).

    allowed: mean error over the mean depth. Raises NotConvergedError, ContactLostError.
    """
    parts, before = 1, _in_parts(level, problem, compliance, 1)
    while True:
        parts *= 2
        depth = _in_parts(level, problem, compliance, parts)
        worn = float(depth.sum())
        # the difference between a second-order result and one of half its steps is three times the error of the latter
        error = float(abs(depth - before).sum()) / 3.0
        if error <= allowed * worn or parts == 64:
            return WornDepth(depth, error / worn if worn > 0.0 else 0.0)
        before = depth


def _in_parts(level: GridLevel, problem: ProfileProblem, compliance: DoubleArray, parts: int) -> DoubleArray:
    solver = NormalSolver(CompliantOperator(level.operator, SHARE / parts * compliance), level.grid)
    # The depth is summed up by itself: past the edge of a punch there is no material, and the separation is infinite.
    pressure, depth = problem.pressure, np.zeros_like(problem.pressure)

    def pressed(between: DoubleArray, estimate: DoubleArray) -> DoubleArray:
        found = estimate.copy()
        arguments = problem.tolerance, problem.max_iterations, problem.rigid
        result = solver.solve(between, problem.control, found, *arguments)
        if not result.converged:
            raise NotConvergedError(
                f"the worn profile is not found after {result.iterations} iterations: the largest gap error is"
                f" {result.residual:.2g} of the normal displacement, {problem.tolerance:.2g} is needed; raise"
                " solver.max_iterations, or let a solved cycle stand for fewer"
            )
        return found

    for _ in range(parts):
        first = pressed(problem.separation + depth, pressure)
        depth += (1.0 - SHARE) / parts * compliance * first
        pressure = pressed(problem.separation + depth, first)
        depth += SHARE / parts * compliance * pressure
    return depth


class CompliantOperator(ElasticOperator):
    """Computes uz = (A + D) p with the elastic operator A and a compliance D >= 0 of each cell (mm/MPa), (nx, ny).

    It serves normal problems alone.
    """

    def __init__(self, elastic: ElasticOperator, compliance: FloatArray):
        self._elastic, self._compliance = elastic, compliance
        self.terms, self.dtype, self.shape, self.team = elastic.terms, elastic.dtype, elastic.shape, elastic.team

    @property
    def preconditioner(self) -> Preconditioner:
        return self._elastic.preconditioner

    @cached_property
    def unit(self) -> float:
        return self._elastic.unit

    @cached_property
    def inner(self) -> CompliantOperator:
        return CompliantOperator(self._elastic.inner, (self._compliance / self.unit).astype(INNER_PRECISION))

    def normal(self, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute ``uz`` from pressure."""
        yielded = np.multiply(self._compliance, pressure, dtype=self.dtype)
        self._elastic.normal(pressure, uz)
        uz += yielded
