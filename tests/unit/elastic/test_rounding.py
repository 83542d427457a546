from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.rounding import ROUNDING, circle_width, least_slip, named_rounding, slips


@pytest.mark.parametrize(
    ("elastic", "moved", "tolerance", "least"),
    [
        (1e-3, (0.0, 0.0, 0.0), 1e-6, 1e-3 * ROUNDING / 1e-6),
        (1e-3, (1.0, 0.0, 0.0), 1e-6, ROUNDING / 1e-6),
        (1e-3, (0.5, -1.0, 0.01), 1e-6, ROUNDING / 1e-6),
        (1e-3, (0.0, 0.5, -0.1), 1e-6, 2.0 * ROUNDING / 1e-6),  # a turn counts at the farthest cell
        (1e-3, (1e9, 0.0, 0.0), 1e-6, 1e-3),  # never more than the elastic displacement
        (1e-3, (0.0, 0.0, 0.0), 1e-15, 1e-3),
        (0.0, (5.0, 0.0, 0.0), 1e-6, 0.0),
    ],
)
def test_least_slip(elastic, moved, tolerance, least):
    rigid = np.array([7.0, 7.0, 7.0, *moved])
    assert least_slip(elastic, rigid, 20.0, tolerance) == pytest.approx(least, rel=1e-12)


def test_the_longest_length_is_named():
    lengths = {"heights": 1e9, "delta_z": 1.0}
    assert named_rounding(1e-7, lengths) == "1e-07 mm, the rounding of heights (1e+09 mm) in double precision"
    assert named_rounding(1e-3, lengths) == ""
    assert named_rounding(float("nan"), lengths) == ""


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_a_cell_slips_within_the_width_of_the_friction_circle(precision):
    width = circle_width(precision)
    length = np.array([[0.0, 1.0 - 2.0 * width, 1.0 - 0.5 * width, 1.0, 1.1]])
    shear = np.stack([0.6 * length, -0.8 * length])
    assert slips(2.0 * shear, np.full(length.shape, 2.0), width).tolist() == [[False, False, True, True, True]]
