"""The error of a worn volume by a stick zone that consists of whole cells."""

from __future__ import annotations

from typing import Any

import pytest

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.problem.setup.wear_warnings import error_by_stick_cells
from fretsolve.reference.worn_contact import WornLimit, worn_limit_at_displacement, worn_limit_at_force

RADIUS, MODULUS, A0, FRICTION, ALPHA = 10.0, 1e5, 0.3, 0.2, 1e-7
LOAD, DEPTH = 4.0 / 3.0 * MODULUS * A0**3 / RADIUS, A0**2 / RADIUS


def limit_of(held: str, c: float) -> WornLimit:
    """Return the worn limit with the stick radius c (over a0) under P, or at an approach."""
    if held == "P":
        return worn_limit_at_force(LOAD, FRICTION * LOAD * (1.0 - c**3), FRICTION, RADIUS, MODULUS)
    return worn_limit_at_displacement(DEPTH, FRICTION * DEPTH * (1.0 - c**2), FRICTION, RADIUS, MODULUS, 4.0 / MODULUS)


@pytest.mark.parametrize(
    ("held", "c", "points", "width", "shift"),
    [
        ("P", 0.581, 36, 2.2, (0.0, 0.0)),
        ("P", 0.361, 32, 2.3, (0.194, 0.058)),
        ("delta_z", 0.612, 32, 2.4, (0.396, 0.379)),
        ("delta_z", 0.42, 30, 2.25, (0.0, 0.0)),
    ],
)
def test_the_worn_limit_is_reached_within_the_estimate(held, c, points, width, shift):
    limit = limit_of(held, c)
    side = width * limit.scar_radius / points
    name, most = ("Qx", FRICTION * LOAD * (1.0 - c**3)) if held == "P" else ("delta_x", FRICTION * DEPTH * (1.0 - c**2))
    cycles = round(100.0 / (4.0 * ALPHA * FRICTION**2 * MODULUS * A0 / RADIUS))
    stages: list[Any] = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    case = Case.model_validate(
        {
            "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": points * side, "center": [shift[0] * side, shift[1] * side]},
            "coupling": "none",
            "friction": FRICTION,
            "wear": {"law": "energy", "alpha": ALPHA},
            "load_path": [
                {"P": LOAD} if held == "P" else {"delta_z": DEPTH},
                {name: most, "increments": 2},
                {"cycle": {"represents": cycles, "jump": -(-cycles // 10), "stages": stages}},
            ],
            "output": {"every": 10**6},
        }
    )
    last = [state.summary for state in run(case)][-1]
    error = error_by_stick_cells(limit, last.wear_volume, last.stick_cells, side, load_kept=held == "P")
    assert error is not None
    assert abs(last.wear_volume - limit.volume) < error < 0.15 * limit.volume
