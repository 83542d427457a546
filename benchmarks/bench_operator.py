"""The elastic operator against the floor; ``python benchmarks/bench_operator.py`` prints a table."""

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


def work_units(points: int, part: str) -> float:
    """Return the WU of an application on `points` per side, both measured here."""
    material = set_up(fretsolve.load_case(CASE)).model.compliances
    terms, team = Terms(True, True, True), ThreadTeam(1, kernels_in_use())
    operator = ElasticOperator((points, points), (0.01, 0.01), material, terms, team)
    random = np.random.default_rng(0)
    pressure, shear = random.random((points, points)), random.random((2, points, points))
    inner = operator.inner
    single, result = shear.astype(inner.dtype), np.empty(shear.shape, inner.dtype)
    uz, displacement = np.empty_like(pressure), np.empty_like(shear)
    apply = {
        "normal": lambda: operator.normal(pressure, uz),
        "tangential": lambda: operator.tangential(shear, displacement),
        "all": lambda: operator.all(pressure, shear, uz, displacement),
        "tangential, single": lambda: inner.tangential(single, result),
        "preconditioner": lambda: operator.preconditioner.tangential(single, result),
    }[part]
    apply()
    seconds = []
    for _ in range(15):
        began = time.process_time()
        apply()
        seconds.append(time.process_time() - began)
    return float(np.median(seconds)) / work_unit(points)


def print_table(grids: list[int]) -> None:
    """Print the cost of all parts on some grids."""
    print("| points | WU, ms |", " | ".join(f"{part}, WU" for part in PARTS), "|")
    print("| --- " * (2 + len(PARTS)) + "|")
    for points in grids:
        costs = [f"{work_units(points, part):.2f}" for part in PARTS]
        print(f"| {points} | {1e3 * work_unit(points):.3g} |", " | ".join(costs), "|", flush=True)


if __name__ == "__main__":
    print_table([int(argument) for argument in sys.argv[1:]] or [64, 128, 256, 512, 1024])
