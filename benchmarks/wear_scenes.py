"""Scenes with wear whose worn surfaces are known, or certified by rings.

A rigid sphere of 10 mm on a half-space, nu = 0: contact radius a0 = 0.3 mm, approach d0, V0 = pi a0^4/4R. T counts
cycles: 4 k mu N E* a0/R in partial slip, k P S N/V0 in gross slip with a path of slip S in a cycle.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.result.state import State

Shift = tuple[float, float]

RADIUS, MODULUS, A0 = 10.0, 1e5, 0.3
P0, D0, V0 = 4.0 / 3.0 * MODULUS * A0**3 / RADIUS, A0**2 / RADIUS, np.pi * A0**4 / (4.0 * RADIUS)
ALPHA = 1e-7
"""In mm^3/mJ."""

FRICTION = 0.2
"""Of partial slip."""

PARTIAL_SIZES = {("P", 0.1): 2.6, ("P", 1.0): 2.7, ("P", 10.0): 3.5, ("d", 0.1): 2.6, ("d", 1.0): 2.7, ("d", 10.0): 3.0}
"""Side of the grid over a0."""

GROSS_SIZES = {1.0: 2.8, 10.0: 4.1, 100.0: 7.0}

CENTRED: Shift = (0.0, 0.0)
"""The sphere's axis lies where four cells meet, so that by symmetry eight cells go from stick to slip at once."""


@dataclass(frozen=True)
class Worn:
    """A run with wear: its states and its processor time (s)."""

    states: list[State]
    seconds: float

    @property
    def last(self) -> State:
        """The last increment."""
        return self.states[-1]

    @property
    def volume(self) -> float:
        """The worn volume over V0."""
        return self.last.summary.wear_volume / V0

    @property
    def jumps(self) -> int:
        """The number of solved cycles that stand for more than themselves."""
        return sum(state.summary.jump > 1.0 for state in self.states)


def solved(case: Case) -> Worn:
    """Run a case with wear."""
    began = time.process_time()
    return Worn(list(run(case)), time.process_time() - began)


def sphere(points: int, size: float, friction: float, stages: list[Any], shift: Shift = CENTRED) -> Case:
    """Return the sphere on a grid of `size` (mm) with its middle at `shift` (cells) under a load path."""
    center = [part * size / points for part in shift]
    return Case.model_validate(
        {
            "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": size, "center": center},
            "coupling": "none",
            "friction": friction,
            "wear": {"law": "energy", "alpha": ALPHA},
            "load_path": stages,
            "output": {"every": 10**6, "fields": ["pressure", "wear_depth"]},
        }
    )


def partial_slip(held: str, time_: float, points: int, jumps: int = 0, shift: Shift = CENTRED) -> Case:
    """Return partial slip with c/a0 = 0.5 and P or d held; jumps: equal ones, 0 for automatic ones."""
    return slipping_outside(0.5, held, time_, points, PARTIAL_SIZES[held, time_] * A0, jumps, shift)


def slipping_outside(c: float, held: str, time_: float, points: int, size: float, jumps: int, shift: Shift) -> Case:
    """Return partial slip outside of the radius c (over a0), with P or d held, on a grid of `size` (mm)."""
    cycles = round(time_ / (4.0 * ALPHA * FRICTION**2 * MODULUS * A0 / RADIUS))
    press = {"P": P0} if held == "P" else {"delta_z": D0}
    name, most = ("Qx", most_force(c)) if held == "P" else ("delta_x", most_displacement(c))
    path = [press, {name: most, "increments": 4}, _cycle(name, most, cycles, jumps)]
    return sphere(points, size, FRICTION, path, shift)


def most_force(c: float) -> float:
    return FRICTION * P0 * (1.0 - c**3)


def most_displacement(c: float) -> float:
    return FRICTION * D0 * (1.0 - c**2)


def gross_slip(time_: float, points: int) -> Case:
    """Return gross slip under P; the path of slip in a cycle is 4 (delta_x - mu d0) in the mean."""
    mu, most = 0.01, 0.01
    cycles = round(time_ * V0 / (ALPHA * mu * P0 * 4.0 * most))
    return sphere(
        points,
        GROSS_SIZES[time_] * A0,
        mu,
        [{"P": P0}, {"delta_x": most, "increments": 1}, _cycle("delta_x", most, cycles, 0)],
    )


def _cycle(name: str, most: float, cycles: int, jumps: int) -> dict[str, Any]:
    stages = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    return {
        "cycle": {
            "represents": cycles,
            "jump": -(-cycles // jumps) if jumps else "auto",
            "tolerance": 0.01,
            "stages": stages,
        }
    }


def base_case(points: int) -> Worn:
    """Run steel on steel, nu = 0.3, P = 400 N, Q = 36 N, over 75555 cycles."""
    steel = {"young_modulus": 200e3, "poisson_ratio": 0.3}
    cycle = {"represents": 75555, "stages": [{"Qx": -36.0, "increments": 2}, {"Qx": 36.0, "increments": 2}]}
    case = {
        "bodies": [steel, steel],
        "surface": {"sphere": {"radius": RADIUS}},
        "grid": {"points": points, "size": 0.8},
        "friction": 0.1,
        "wear": {"law": "energy", "alpha": ALPHA},
        "load_path": [{"P": 400.0}, {"Qx": 36.0}, {"cycle": cycle}],
        "output": {"every": 10**6},
    }
    return solved(Case.model_validate(case))
