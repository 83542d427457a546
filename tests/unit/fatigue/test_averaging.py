"""Averages of stresses over a length."""

import numpy as np
import pytest

from fretsolve.errors import CaseError
from fretsolve.fatigue.averaging import Average, box_weights, depth_weights

DEPTHS = np.array([0.0, 0.1, 0.3, 0.4, 1.0])


@pytest.mark.parametrize(("first", "last"), [(0.0, 1.0), (0.05, 0.35), (0.31, 0.39), (0.2, 0.2), (1.0, 1.0)])
def test_depth_weights_are_exact_for_what_is_linear(first, last):
    weights = depth_weights(DEPTHS, first, last)
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ DEPTHS == pytest.approx(0.5 * (first + last))


def test_depth_weights_of_a_kink():
    """The mean of |z - 0.3| over 0 to 0.6 is 0.15."""
    assert depth_weights(DEPTHS, 0.0, 0.6) @ np.abs(DEPTHS - 0.3) == pytest.approx(0.15)


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
    stress = np.zeros((2, 5, 9, 7)) + DEPTHS[:, None, None] + 10.0 * x[:, None]
    middle = (0, 4, 3)
    expected = {"point": 0.1, "line": 0.2, "volume": 0.1}
    for kind, depth in expected.items():
        average = Average(kind, 0.2)
        weights = depth_weights(DEPTHS, *average.depth_range)
        assert average.of(stress, weights, (0.1, 0.1))[middle] == pytest.approx(depth + 4.0)


def test_volume_spreads_a_single_cell():
    stress = np.zeros((1, 5, 9, 9))
    stress[:, :, 4, 4] = 1.0
    average = Average("volume", 0.2)
    found = average.of(stress, depth_weights(DEPTHS, *average.depth_range), (0.1, 0.1))
    assert found[0, 4, 4] == pytest.approx(0.25)
    assert found.sum() == pytest.approx(1.0)


def test_length_below_a_cell_is_refused():
    with pytest.raises(CaseError, match=r"0\.05 mm is below a cell; 0\.1 mm or more is needed"):
        Average("point", 0.05).require_resolved(DEPTHS, (0.1, 0.02))


def test_depths_that_do_not_reach_are_refused():
    with pytest.raises(CaseError, match=r"from 0 to 1\.2 mm, the stresses reach from 0 to 1 mm"):
        Average("line", 0.6).require_resolved(DEPTHS, (0.1, 0.1))
    Average("line", 0.5).require_resolved(DEPTHS, (0.1, 0.1))
