"""Measure what line contacts cost: processor time of a cycle of Q and bulk stress in phase, without compiled kernels.

FRETSOLVE_NUMBA=0 python benchmarks/line_cost.py
"""

from __future__ import annotations

import time

from fretsolve import run
from fretsolve.case.line_case import LineCase
from fretsolve.setup.problem_setup import set_up

STEEL = {"young_modulus": 200e3, "poisson_ratio": 0.3}
SIZES = ((256, 40), (4096, 200))
"""Cells and increments."""


def case(points: int, increments: int) -> LineCase:
    """Return a cylinder under P, then Q and bulk stress in phase, forth and back."""
    peak = {"Qx": 18.0, "bulk_2": {"xx": 140.0}, "increments": increments // 2}
    valley = {"Qx": -18.0, "bulk_2": {"xx": -140.0}, "increments": increments - 1 - increments // 2}
    return LineCase.model_validate(
        {
            "plane": "strain",
            "bodies": [STEEL, STEEL],
            "surface": {"cylinder": {"radius": 10.0}},
            "grid": {"points": points, "size": 0.28},
            "friction": 0.3,
            "load_path": [{"P": 100.0, "increments": 1}, peak, valley],
        }
    )


def seconds(points: int, increments: int) -> float:
    """Return the processor time of a run without its set-up."""
    setup = set_up(case(points, increments))
    begun = time.process_time()
    states = sum(1 for _ in run(setup))
    assert states == increments
    return time.process_time() - begun


if __name__ == "__main__":
    print("| cells | increments | processor time, s |\n| --- | --- | --- |")
    for points, increments in SIZES:
        least = min(seconds(points, increments) for _ in range(3))
        print(f"| {points} | {increments} | {least:.2f} |")
