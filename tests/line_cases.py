"""Line contacts, by default the base of docs/verification.md: steel on steel, a cylinder of 10 mm, P = 100 N/mm."""

from __future__ import annotations

import math
from typing import Any

from fretsolve import run
from fretsolve.case.line_case import LineCase
from fretsolve.problem.model.materials import compliances
from fretsolve.reference.hertz import HertzLine, RoundedPunch
from fretsolve.reference.line_slip import LinePartialSlip
from fretsolve.result.state import State

STEEL = {"young_modulus": 200e3, "poisson_ratio": 0.3}
SIMILAR, DISSIMILAR = [STEEL, STEEL], [{**STEEL, "poisson_ratio": 0.06}, {**STEEL, "poisson_ratio": 0.42}]
LOAD, FRICTION = 100.0, 0.3
SHEAR_FORCE = 0.6 * FRICTION * LOAD

LINE = """\
title: line
plane: strain
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
surface: {cylinder: {radius: 10 mm}}
grid: {points: 64, size: 0.28 mm}
friction: 0.3
load_path:
  - {P: 100 N/mm}
  - {Qx: 18 N/mm, increments: 4}
"""
"""The base as a case file."""


def line_case(**keys: Any) -> LineCase:
    """Return a case; bare numbers are in mm, N/mm, MPa."""
    usual = {
        "plane": "strain",
        "bodies": SIMILAR,
        "surface": {"cylinder": {"radius": 10.0}},
        "grid": {"points": 64},
        "friction": FRICTION,
        "load_path": [{"P": LOAD}, {"Qx": SHEAR_FORCE, "increments": 4}],
    }
    return LineCase.model_validate({**usual, **keys})


def solve_line(**keys: Any) -> list[State]:
    """Return the states of all increments of a case."""
    return list(run(line_case(**keys)))


def modulus_of(bodies: list[Any]) -> float:
    """Return E* of a pair of bodies."""
    return compliances(*line_case(bodies=bodies).bodies).contact_modulus


MATERIAL = compliances(*line_case().bodies)
HERTZ = HertzLine(LOAD, 10.0, MATERIAL.contact_modulus)
CATTANEO = LinePartialSlip(HERTZ, FRICTION, SHEAR_FORCE, MATERIAL.A)
A = HERTZ.half_width
PUNCH = RoundedPunch(200.0, 0.5, 100.0, MATERIAL.contact_modulus)


def cells_per_half_width(cells: int, a: float = A, reach: float = 1.3) -> dict[str, Any]:
    """Return a grid with `cells` cells per half-width `a` (mm), one of them in the middle, out to `reach` a."""
    points = 2 * math.ceil(reach * cells) + 1
    return {"points": points, "size": points * a / cells}
