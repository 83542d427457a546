"""Least errors of single quantities; `tests/verification/test_bars_hold.py` compares bars with true errors."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.simulation.error_bars.least_errors import _drop_beside_peak

PEAK = np.array([[1.0, 2.0, 1.0], [4.0, 6.0, 5.0], [0.0, 3.0, 0.0]])


@pytest.mark.parametrize(
    ("pressure", "drop"),
    [
        (PEAK, (2 * 6 - 2 - 3) + (2 * 6 - 4 - 5)),
        (PEAK[1:], (2 * 6 - 0 - 3) + (2 * 6 - 4 - 5)),  # at the border, beyond which nothing presses
        (PEAK[:, 1:2], 2 * 6 - 2 - 3),  # a line contact has one cell across
    ],
)
def test_the_pressure_drops_beside_its_peak(pressure, drop):
    assert _drop_beside_peak(pressure) == drop
