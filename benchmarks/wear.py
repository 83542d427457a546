"""Compare wear with certified values, and show its error against the jumps and its costs.

    python benchmarks/wear.py                             # about 5 minutes
    python benchmarks/wear.py --into docs/verification.md

A rigid sphere of 10 mm on a half-space, nu = 0: contact radius a0 = 0.3 mm, approach d0, V0 = pi a0^4/4R. T counts
cycles: 4 k mu N E* a0/R in partial slip, k P S N/V0 in gross slip with a path of slip S in a cycle.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from marked import parser_of, report

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.result.state import State

RADIUS, MODULUS, A0 = 10.0, 1e5, 0.3
P0, D0, V0 = 4.0 / 3.0 * MODULUS * A0**3 / RADIUS, A0**2 / RADIUS, np.pi * A0**4 / (4.0 * RADIUS)
ALPHA = 1e-7
"""In mm^3/mJ."""

PARTIAL: dict[tuple[str, float], tuple[float, float]] = {
    ("P", 0.1): (0.01182, 1.00321),
    ("P", 1.0): (0.13139, 1.03158),
    ("P", 10.0): (1.834, 1.306),
    ("d", 0.1): (0.01175, 0.99524),
    ("d", 1.0): (0.12334, 0.95361),
    ("d", 10.0): (0.913, 0.7047),
}
"""V/V0, and d/d0 where P is held, P/P0 where d is held, by rings; c/a0 = 0.5."""

PARTIAL_SIZES = {("P", 0.1): 2.6, ("P", 1.0): 2.7, ("P", 10.0): 3.5, ("d", 0.1): 2.6, ("d", 1.0): 2.7, ("d", 10.0): 3.0}
"""Side of the grid over a0."""

GROSS: dict[float, tuple[float, float, float]] = {
    1.0: (1.1538, 1.2135, 0.31907),
    10.0: (1.9799, 1.8385, 1.5010),
    100.0: (5.2272, 3.1804, 4.9587),
}
"""d/d0, a/a0 and the depth in the middle over d0, by rings."""

GROSS_SIZES = {1.0: 2.8, 10.0: 4.1, 100.0: 7.0}


@dataclass(frozen=True)
class Worn:
    """A run with wear: its states, the processor time (s), and the solved cycles that stand for more than themselves."""

    states: list[State]
    seconds: float

    @property
    def last(self) -> State:
        return self.states[-1]

    @property
    def jumps(self) -> int:
        return sum(state.summary.jump > 1.0 for state in self.states)


def solved(case: Case) -> Worn:
    """Run a case with wear."""
    began = time.process_time()
    return Worn(list(run(case)), time.process_time() - began)


def sphere(points: int, size: float, friction: float, stages: list[Any]) -> Case:
    """Return the sphere on a grid of `size` (mm) under a load path."""
    return Case.model_validate(
        {
            "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": size},
            "coupling": "none",
            "friction": friction,
            "wear": {"law": "energy", "alpha": ALPHA},
            "load_path": stages,
            "output": {"every": 10**6, "fields": ["pressure", "wear_depth"]},
        }
    )


def partial_slip(held: str, time_: float, points: int, jumps: int = 0, tolerance: float = 0.01) -> Case:
    """Return partial slip with c/a0 = 0.5 and P or d held; jumps: equal ones, 0 for automatic ones."""
    mu, c = 0.2, 0.5
    cycles = round(time_ / (4.0 * ALPHA * mu**2 * MODULUS * A0 / RADIUS))
    press = {"P": P0} if held == "P" else {"delta_z": D0}
    name, most = ("Qx", mu * P0 * (1.0 - c**3)) if held == "P" else ("delta_x", mu * D0 * (1.0 - c**2))
    return sphere(
        points,
        PARTIAL_SIZES[held, time_] * A0,
        mu,
        [press, {name: most, "increments": 4}, _cycle(name, most, cycles, jumps, tolerance)],
    )


def gross_slip(time_: float, points: int, jumps: int = 0, tolerance: float = 0.01) -> Case:
    """Return gross slip under P; the path of slip in a cycle is 4 (delta_x - mu d0) in the mean."""
    mu, most = 0.01, 0.01
    cycles = round(time_ * V0 / (ALPHA * mu * P0 * 4.0 * most))
    return sphere(
        points,
        GROSS_SIZES[time_] * A0,
        mu,
        [{"P": P0}, {"delta_x": most, "increments": 1}, _cycle("delta_x", most, cycles, jumps, tolerance)],
    )


def _cycle(name: str, most: float, cycles: int, jumps: int, tolerance: float) -> dict[str, Any]:
    stages = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    return {
        "cycle": {
            "represents": cycles,
            "jump": -(-cycles // jumps) if jumps else "auto",
            "tolerance": tolerance,
            "stages": stages,
        }
    }
