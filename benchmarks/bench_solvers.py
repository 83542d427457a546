"""The two solvers alone, from nothing, on the whole grid; ``python benchmarks/bench_solvers.py`` prints a table.

A sphere of the base case on 0.9 mm: the pressure at 400 N, and the shear at 36 N under that pressure, without window
and coarse grids, so that iterations tell what the preconditioners do as the grid is refined.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from work_unit import kernels_in_use, work_unit

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms
from fretsolve.solvers.normal import NormalSolver
from fretsolve.solvers.tangential import SlipScales, TangentialSolver

STEEL = Compliances(A=1.82e-5, B=7.8e-6, C=0.0)
SOLVERS = ("normal", "tangential")


class Problem:
    """The problems of both solvers on one grid."""

    def __init__(self, points: int):
        grid = Grid.from_size((points, points), (0.9, 0.9))
        team = ThreadTeam(1, kernels_in_use())
        self.operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), STEEL, Terms(True, True, False), team)
        self.separation = (grid.x[:, None] ** 2 + grid.y[None, :] ** 2) / 20.0
        self.normal, self.tangential = NormalSolver(self.operator, grid), TangentialSolver(self.operator, grid)
        self.pressure = np.zeros(grid.shape)
        self.solve_normal(self.pressure)

    def solve_normal(self, pressure: np.ndarray) -> int:
        """Solve the normal problem from `pressure` and return its iterations."""
        control = LoadControl((True, False, False), (400.0, 0.0, 0.0))
        result = self.normal.solve(self.separation, control, pressure, 1e-6, 2000, np.zeros(3))
        assert result.converged
        return result.iterations

    def solve(self, solver: str) -> int:
        """Solve from zero tractions and return the iterations."""
        if solver == "normal":
            return self.solve_normal(np.zeros_like(self.pressure))
        control = LoadControl((True, True, False), (36.0, 0.0, 0.0))
        elastic_slip, shear = (np.zeros((2, *self.pressure.shape)) for _ in range(2))
        self.tangential.slipping[:] = False
        result = self.tangential.solve(elastic_slip, control, 0.1 * self.pressure, shear, 1e-6, 2000, SlipScales())
        assert result.converged
        return result.iterations


def cost(points: int, solver: str) -> tuple[int, int, float]:
    """Return the iterations of a solve, its applications in single and double precision, and its seconds."""
    problem = Problem(points)
    iterations = problem.solve(solver)
    before = problem.operator.total_applications
    problem.solve(solver)
    applications = problem.operator.total_applications - before
    seconds = []
    for _ in range(5):
        began = time.process_time()
        problem.solve(solver)
        seconds.append(time.process_time() - began)
    return iterations, applications, float(np.median(seconds))


def print_table(grids: list[int]) -> None:
    """Print the cost of both solvers on some grids."""
    print(f"pointwise kernels: {'compiled' if kernels_in_use().compiled else 'NumPy'}\n")
    print("| solver | points | iterations | applications | WU | seconds |")
    print("| --- | --- | --- | --- | --- | --- |")
    for solver in SOLVERS:
        for points in grids:
            iterations, applications, seconds = cost(points, solver)
            units = seconds / work_unit(points)
            print(f"| {solver} | {points} | {iterations} | {applications} | {units:.0f} | {seconds:.3g} |", flush=True)


if __name__ == "__main__":
    print_table([int(argument) for argument in sys.argv[1:]] or [64, 128, 256, 512, 1024])
