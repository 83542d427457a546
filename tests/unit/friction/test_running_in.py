"""Cycles over which friction that runs in stays nearly the same."""

import math

import numpy as np
import pytest

from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.friction.weakening import cycles_of_little_change
from fretsolve.result.state import Fields, nothing


def fields(slip_path: float = 0.0, work_density: float = 0.0) -> Fields:
    none, vector = nothing((2, 2)), nothing((2, 2, 2))
    zone = np.zeros((2, 2), np.uint8)
    return Fields(none, vector, vector, np.full((2, 2), slip_path), np.full((2, 2), work_density), zone, none)


ENERGY, PATH = np.array([[0.0, 0.1], [0.2, 0.1]]), np.array([[0.0, 1e-3], [2e-3, 1e-3]])
RUNNING_IN = {"initial": 0.2, "final": 0.7}


@pytest.mark.parametrize(
    ("friction", "cycles", "state", "expected"),
    [
        (0.1, 5.0, {}, math.inf),
        ({**RUNNING_IN, "slip": 5.0}, 1.0, {}, 0.05 * 0.7 / (0.5 * 2e-3 / 5.0)),
        ({**RUNNING_IN, "slip": 5.0}, 1.0, {"slip_path": 5.0}, 0.035 * math.e / (0.5 * 2e-3 / 5.0)),
        ({**RUNNING_IN, "energy": 10.0}, 1.0, {}, 0.05 * 0.7 / (0.5 * 0.2 / 10.0)),
        ({**RUNNING_IN, "energy": 0.1}, 1.0, {}, 1.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 40.0, {}, 60.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 100.0, {}, 100.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 1050.0, {}, 50.0),
        ({"cycles": [[100, 0.1], [1100, 0.1], [1200, 0.2]]}, 300.0, {}, 800.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 1100.0, {}, math.inf),
    ],
)
def test_a_solved_cycle_stands_for_as_many_as_change_the_coefficient_by_5_percent(friction, cycles, state, expected):
    spec = FrictionSpec.model_validate(friction)
    assert cycles_of_little_change(spec, cycles, fields(**state), ENERGY, PATH) == pytest.approx(expected)


def test_a_cell_that_has_just_come_into_contact_counts_by_what_it_dissipates():
    spec = FrictionSpec.model_validate({**RUNNING_IN, "slip": 1.0})
    state = fields(slip_path=100.0)
    state.slip_path[0, 0] = 0.0
    path, energy = np.full((2, 2), 0.1), np.array([[0.01, 1.0], [1.0, 1.0]])
    assert cycles_of_little_change(spec, 1.0, state, energy, path) == pytest.approx(0.05 * 0.7 / (0.01 * 0.5 * 0.1))
