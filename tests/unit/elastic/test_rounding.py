from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.rounding import ROUNDING, least_slip, named_rounding


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
