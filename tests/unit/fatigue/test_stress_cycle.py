"""The stresses of a cycle, layer by layer, and the depths and states that a request needs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from solving import build

from fretsolve.errors import CaseError
from fretsolve.fatigue.averaging import Average
from fretsolve.fatigue.request import AVERAGE_DEPTHS, FatigueRequest, read_material
from fretsolve.fatigue.stress_cycle import StressCycle, cycle_of, elastic_body, opening_of
from fretsolve.stress.influence import COMPONENTS
from fretsolve.stress.stress_file import BodyStress

X, Y, DEPTHS = 0.05 * np.arange(4), 0.04 * np.arange(3), np.array([0.0, 0.05, 0.2])
CYCLE = {"cycle": {"times": 2, "stages": [{"Qx": -20.0}, {"Qx": 20.0}]}}
STAGES = np.array([1, 2, 3, 4, 5])


@pytest.fixture
def body(tmp_path: Path) -> Any:
    """Stresses at the ends of five stages, which follow from their place."""
    path = tmp_path / "out.stress.h5"
    with h5py.File(path, "w") as file:
        for number, name in enumerate(COMPONENTS):
            values = np.arange(5 * 3 * 4 * 3, dtype=np.float32).reshape(5, 3, 4, 3) + 1000 * number
            file.create_dataset(name, data=values)
        yield BodyStress(path, np.arange(5), STAGES, DEPTHS, X, Y, {}, COMPONENTS, file)


def attributes_of(**parts: object) -> dict[str, str]:
    case = build(grid={"points": 8}, load_path=[{"P": 400.0}, CYCLE], **parts)
    return {"effective_case": json.dumps(case.effective())}


def test_layers(body):
    cycle = StressCycle(body.path, body, (2, 3, 4))
    assert cycle.cell == pytest.approx((0.05, 0.04))
    assert cycle.shape == (4, 3)
    layers = list(cycle.layers())
    assert [layer.shape for layer in layers] == [(3, 6, 12)] * 3
    assert layers[1][0, 2, 0] == 2000 + (2 * 3 + 1) * 12
    assert opening_of(layers[0]) == 1.0


def test_an_average_has_one_layer_at_its_mean_depth(body):
    cycle = StressCycle(body.path, body, (2, 3, 4), Average("line", 0.1))
    (layer,) = cycle.layers()
    assert layer.shape == (3, 6, 12)
    assert cycle.depths == pytest.approx([np.mean(Average("line", 0.1).depth_range)])


def test_too_few_states_or_components_are_refused_with_the_file(body):
    with pytest.raises(CaseError, match=r"out\.stress\.h5: "):
        StressCycle(body.path, body, (3, 4))
    fewer = BodyStress(body.path, body.steps, body.stages, DEPTHS, X, Y, {}, COMPONENTS[:5], body.group)
    with pytest.raises(CaseError, match="the file lacks the components yz, all six are needed"):
        StressCycle(body.path, fewer, (2, 3, 4))


def test_the_last_cycle_and_the_state_before_it(body):
    assert cycle_of(body, attributes_of()) == (2, 3, 4)


def test_without_a_known_cycle_all_states_count(body):
    assert cycle_of(body, {}) == (0, 1, 2, 3, 4)
    assert cycle_of(body, {"effective_case": "{}"}) == (0, 1, 2, 3, 4)


def test_constants_of_a_body(body):
    attributes = attributes_of(bodies=("rigid", {"young_modulus": 70e3, "poisson_ratio": 0.33}))
    assert elastic_body(attributes, 2)["young_modulus"] == 70e3
    assert elastic_body(attributes, 1) == elastic_body({}, 2) == {}


def test_depths_of_a_request():
    material = read_material("tension_limit=300 MPa,torsion_limit=190 MPa")
    assert FatigueRequest(material, ("crossland",), depths=(0.1,)).stress_depths(0.01) == (0.1,)
    point = FatigueRequest(material, ("crossland",), Average("point", 0.1))
    assert point.stress_depths(0.01) == (0.05,)
    graded = FatigueRequest(material, ("crossland",), Average("line", 0.1)).stress_depths(0.0)
    assert (len(graded), graded[0], graded[-1]) == (AVERAGE_DEPTHS, 0.0, pytest.approx(0.2))
    coarse = FatigueRequest(material, ("crossland",), Average("line", 0.1)).stress_depths(0.05)
    assert coarse == (0.0, *(depth for depth in graded if depth >= 0.05))
