"""The stresses of a cycle, whether it is closed, and averages over a length."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fretsolve.errors import CaseError
from fretsolve.post.fatigue.request import Average, depth_weights
from fretsolve.post.fatigue.stress_cycle import StressCycles, not_closed, opening_of
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.influence import COMPONENTS
from fretsolve.post.stress.stress_file import BodyStress

X, Y, DEPTHS = 0.05 * np.arange(4), 0.04 * np.arange(3), np.array([0.0, 0.05, 0.2])
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


def test_the_opening_of_a_cycle_is_the_largest_change_over_the_largest_range():
    stress = np.zeros((3, 6, 2))
    stress[1, 1, 0], stress[2, 3, 1] = 100.0, -2.0
    assert opening_of(stress) == pytest.approx(0.02)
    assert opening_of(np.zeros((3, 6, 2))) == 0.0
    assert not_closed(0.01) is None
    assert "differs from its first by 2 % of the range (more than 1 %)" in not_closed(0.02)


def test_too_few_states_or_components_are_refused_with_the_file(body):
    with pytest.raises(CaseError, match=r"out\.stress\.h5: the cycle has 2 stored states; 3 or more are needed"):
        StressCycles(body.path, body, (LoadCycle(1, (3, 4), (3, 4)),))
    fewer = BodyStress(body.path, body.steps, body.stages, DEPTHS, X, Y, {}, COMPONENTS[:5], body.group)
    with pytest.raises(CaseError, match="the file lacks the components yz, all six are needed"):
        StressCycles(body.path, fewer, (LoadCycle(1, (2, 3, 4), (2, 3, 4)),))


NODES = np.array([0.0, 0.1, 0.3, 0.4, 1.0])


def test_depth_weights_of_a_kink():
    """The mean of |z - 0.3| over 0 to 0.6 is 0.15."""
    assert depth_weights(NODES, 0.0, 0.6) @ np.abs(NODES - 0.3) == pytest.approx(0.15)


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
