"""The two solvers alone, from nothing, on the whole grid; asv's shape, ``python benchmarks/bench_solvers.py`` prints.

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


class Solvers:
    """Iterations, applications and cost of one solve, by grid and solver."""

    params = ((64, 128, 256, 512, 1024), SOLVERS)
    param_names = ("points", "solver")
    timeout = 600

    def setup(self, points: int, solver: str) -> None:
        """Make the operators, and the pressure for the tangential problem."""
        grid = Grid.from_size((points, points), (0.9, 0.9))
        team = ThreadTeam(1, kernels_in_use())
        self.operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), STEEL, Terms(True, True, False), team)
        self.separation = (grid.x[:, None] ** 2 + grid.y[None, :] ** 2) / 20.0
        self.normal, self.tangential = NormalSolver(self.operator, grid), TangentialSolver(self.operator, grid)
        self.pressure = np.zeros(grid.shape)
        self.solve_normal(self.pressure)
        self.result = self.solve(solver)
        before = self.operator.total_applications
        self.solve(solver)
        self.applications = self.operator.total_applications - before
        seconds = []
        for _ in range(5):
            began = time.process_time()
            self.solve(solver)
            seconds.append(time.process_time() - began)
        self.seconds, self.work_unit = float(np.median(seconds)), work_unit(points)

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

    def time_solve(self, points: int, solver: str) -> None:
        """Solve once from zero tractions."""
        self.solve(solver)

    def peakmem_solve(self, points: int, solver: str) -> None:
        """Solve once from zero tractions."""
        self.solve(solver)

    def track_iterations(self, points: int, solver: str) -> int:
        """Return the iterations of conjugate gradients."""
        return self.result

    def track_applications(self, points: int, solver: str) -> int:
        """Return the applications of the elastic operator, in single and in double precision."""
        return self.applications

    def track_work_units(self, points: int, solver: str) -> float:
        """Return the WU of a solve, both measured here."""
        return self.seconds / self.work_unit


def print_table(grids: list[int]) -> None:
    """Print the cost of both solvers on some grids."""
    print(f"pointwise kernels: {'compiled' if kernels_in_use().compiled else 'NumPy'}\n")
    print("| solver | points | iterations | applications | WU | seconds |")
    print("| --- | --- | --- | --- | --- | --- |")
    for solver in SOLVERS:
        for points in grids:
            bench = Solvers()
            bench.setup(points, solver)
            print(
                f"| {solver} | {points} | {bench.result} | {bench.applications}"
                f" | {bench.track_work_units(points, solver):.0f} | {bench.seconds:.3g} |",
                flush=True,
            )


if __name__ == "__main__":
    print_table([int(argument) for argument in sys.argv[1:]] or list(Solvers.params[0]))
