"""The stresses of a cycle, layer by layer, averages over a length, and the depths that a request needs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from solving import build

from fretsolve.errors import CaseError
from fretsolve.post.fatigue.request import (
    AVERAGE_DEPTHS,
    Average,
    FatigueRequest,
    box_weights,
    depth_weights,
    read_material,
)
from fretsolve.post.fatigue.stress_cycle import StressCycle, cycle_of, elastic_body, not_closed, opening_of
from fretsolve.post.stress.influence import COMPONENTS
from fretsolve.post.stress.stress_file import BodyStress

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


def test_the_opening_of_a_cycle_is_the_largest_change_over_the_largest_range():
    stress = np.zeros((3, 6, 2))
    stress[1, 1, 0], stress[2, 3, 1] = 100.0, -2.0
    assert opening_of(stress) == pytest.approx(0.02)
    assert opening_of(np.zeros((3, 6, 2))) == 0.0
    assert not_closed(0.01) is None
    assert "differs from its first by 2 % of the range (more than 1 %)" in not_closed(0.02)


def test_an_average_has_one_layer_at_its_mean_depth(body):
    cycle = StressCycle(body.path, body, (2, 3, 4), Average("line", 0.1))
    (layer,) = cycle.layers()
    assert layer.shape == (3, 6, 12)
    assert cycle.depths == pytest.approx([np.mean(Average("line", 0.1).depth_range)])


def test_too_few_states_or_components_are_refused_with_the_file(body):
    with pytest.raises(CaseError, match=r"out\.stress\.h5: the cycle has 2 stored states; 3 or more are needed"):
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


NODES = np.array([0.0, 0.1, 0.3, 0.4, 1.0])


@pytest.mark.parametrize(("first", "last"), [(0.0, 1.0), (0.05, 0.35), (0.31, 0.39), (0.2, 0.2), (1.0, 1.0)])
def test_depth_weights_are_exact_for_what_is_linear(first, last):
    weights = depth_weights(NODES, first, last)
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ NODES == pytest.approx(0.5 * (first + last))


def test_depth_weights_of_a_kink():
    """The mean of |z - 0.3| over 0 to 0.6 is 0.15."""
    assert depth_weights(NODES, 0.0, 0.6) @ np.abs(NODES - 0.3) == pytest.approx(0.15)


@pytest.mark.parametrize("cells", [1.0, 1.5, 2.0, 3.0, 4.2])
def test_box_weights_are_those_of_a_window(cells):
    weights = box_weights(cells)
    assert weights.sum() == pytest.approx(1.0)
    middle = len(weights) // 2
    assert weights[middle] == pytest.approx(1.0 / cells)
    assert weights[0] <= weights[middle]
    np.testing.assert_allclose(weights, weights[::-1])


def test_kinds_of_averages():
    x = np.arange(9.0) * 0.1
    stress = np.zeros((2, 5, 9, 7)) + NODES[:, None, None] + 10.0 * x[:, None]
    middle = (0, 4, 3)
    expected = {"point": 0.1, "line": 0.2, "volume": 0.1}
    for kind, depth in expected.items():
        average = Average(kind, 0.2)
        weights = depth_weights(NODES, *average.depth_range)
        assert average.of(stress, weights, (0.1, 0.1))[middle] == pytest.approx(depth + 4.0)


def test_volume_spreads_a_single_cell():
    stress = np.zeros((1, 5, 9, 9))
    stress[:, :, 4, 4] = 1.0
    average = Average("volume", 0.2)
    found = average.of(stress, depth_weights(NODES, *average.depth_range), (0.1, 0.1))
    assert found[0, 4, 4] == pytest.approx(0.25)
    assert found.sum() == pytest.approx(1.0)


def test_lengths_below_a_cell_and_depths_that_do_not_reach_are_refused():
    with pytest.raises(CaseError, match=r"0\.05 mm is below a cell; 0\.1 mm or more is needed"):
        Average("point", 0.05).require_resolved(NODES, (0.1, 0.02))
    with pytest.raises(CaseError, match=r"from 0 to 1\.2 mm, the stresses reach from 0 to 1 mm"):
        Average("line", 0.6).require_resolved(NODES, (0.1, 0.1))
    Average("line", 0.5).require_resolved(NODES, (0.1, 0.1))
