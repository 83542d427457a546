"""The elastic operator against the floor, in asv's shape; ``python benchmarks/bench_operator.py`` prints a table."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from work_unit import kernels_in_use, work_unit

import fretsolve
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.model.required_terms import Terms
from fretsolve.setup.problem_setup import set_up

CASE = Path(__file__).resolve().parent.parent / "cases" / "mode1_dissimilar.yaml"
PARTS = ("normal", "tangential", "all", "tangential, single", "preconditioner")
"""The last two are what an inner iteration applies to a shear, in single precision."""


class Operator:
    """Seconds and WU of an application, by grid and part of the operator."""

    params = ((64, 128, 256, 512, 1024), PARTS)
    param_names = ("points", "part")

    def setup(self, points: int, part: str) -> None:
        """Make the operator and arrays for its arguments."""
        material = set_up(fretsolve.load_case(CASE)).model.compliances
        terms, team = Terms(True, True, True), ThreadTeam(1, kernels_in_use())
        self.operator = ElasticOperator((points, points), (0.01, 0.01), material, terms, team)
        random = np.random.default_rng(0)
        pressure, shear = random.random((points, points)), random.random((2, points, points))
        inner = self.operator.inner
        single, result = shear.astype(inner.dtype), np.empty(shear.shape, inner.dtype)
        uz, displacement = np.empty_like(pressure), np.empty_like(shear)
        self.apply = {
            "normal": lambda: self.operator.normal(pressure, uz),
            "tangential": lambda: self.operator.tangential(shear, displacement),
            "all": lambda: self.operator.all(pressure, shear, uz, displacement),
            "tangential, single": lambda: inner.tangential(single, result),
            "preconditioner": lambda: self.operator.preconditioner.tangential(single, result),
        }[part]
        self.apply()

    def time_application(self, points: int, part: str) -> None:
        """Apply the operator once."""
        self.apply()

    def track_work_units(self, points: int, part: str) -> float:
        """Return the WU of an application, both measured here."""
        seconds = []
        for _ in range(15):
            began = time.process_time()
            self.apply()
            seconds.append(time.process_time() - began)
        return float(np.median(seconds)) / work_unit(points)


def print_table(grids: list[int]) -> None:
    """Print the cost of all parts on some grids."""
    print("| points | WU, ms |", " | ".join(f"{part}, WU" for part in PARTS), "|")
    print("| --- " * (2 + len(PARTS)) + "|")
    for points in grids:
        costs = []
        for part in PARTS:
            bench = Operator()
            bench.setup(points, part)
            costs.append(f"{bench.track_work_units(points, part):.2f}")
        print(f"| {points} | {1e3 * work_unit(points):.3g} |", " | ".join(costs), "|", flush=True)


if __name__ == "__main__":
    print_table([int(argument) for argument in sys.argv[1:]] or list(Operator.params[0]))
