"""Cases built from Python and solved, for the tests of the solver: by default the contact of the paper's cases.

A sphere of 10 mm on a flat, P = 400 N, friction 0.1 (mm, N, MPa, rad throughout).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import quad

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.problem.model.materials import compliances
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.result.state import State
from fretsolve.simulation.problem_setup import set_up

SIMILAR = ({"young_modulus": 200e3, "poisson_ratio": 0.3},) * 2
DISSIMILAR = ({"young_modulus": 200e3, "poisson_ratio": 0.06}, {"young_modulus": 200e3, "poisson_ratio": 0.42})
SWAPPED = DISSIMILAR[::-1]
NO_POISSON = ({"young_modulus": 200e3, "poisson_ratio": 0.0},) * 2
RIGID = ("rigid", {"young_modulus": 100e3, "poisson_ratio": 0.0})
LOADS = ("P", "Mx", "My", "Qx", "Qy", "Mz")
MOTIONS = ("delta_z", "phi_x", "phi_y", "delta_x", "delta_y", "phi_z")
SPHERE = {"sphere": {"radius": 10.0}}
FRICTION, LOAD, RADIUS = 0.1, 400.0, 10.0


def build(**parts: Any) -> Case:
    """A case of keyword `parts` as a case file has them."""
    whole: dict[str, Any] = {"bodies": SIMILAR, "surface": SPHERE, "friction": FRICTION, "load_path": [{"P": LOAD}]}
    return Case.model_validate(whole | parts)


def setup_of(points: int = 16, **parts: Any) -> ProblemSetup:
    """The setup of ``build(**parts)`` on as many points per side."""
    return set_up(build(grid={"points": points}, **parts))


def solve(**parts: Any) -> list[State]:
    """The states of all increments of ``build(**parts)``."""
    return list(run(build(**parts)))


def solve_last(**parts: Any) -> State:
    """The last of them."""
    return solve(**parts)[-1]


def grid_of(**parts: Any) -> Any:
    """The grid of ``build(**parts)``."""
    return set_up(build(**parts)).grid


MATERIAL = compliances(*build(grid={"points": 2}).bodies)  # type: ignore[arg-type]
"""Of the similar bodies."""
HERTZ = hertz_sphere(LOAD, RADIUS, MATERIAL.contact_modulus)
A = HERTZ.contact_radius


def integral_over_disc(profile: Any, radius: float, *breaks: float) -> float:
    """Return the integral of a radial profile over the disc, by substituting r = radius sin(t) (edge singularities)."""
    points = [math.asin(b / radius) for b in breaks]

    def integrand(t: float) -> float:
        return math.pi * radius**2 * math.sin(2 * t) * float(profile(np.array(radius * math.sin(t))))

    return quad(integrand, 0.0, math.pi / 2, points=points or None, epsabs=0.0, epsrel=1e-10, limit=200)[0]
