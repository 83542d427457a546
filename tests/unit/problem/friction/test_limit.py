"""The friction limit of each cell by its pressure."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.problem.friction.limit import MOST_GROWTH, FrictionLimit

PRESSURE = np.array([[0.0, 1e-9, 50.0], [100.0, 1000.0, 2000.0]])


def test_one_coefficient_is_a_product_into_a_given_array():
    out = np.full(PRESSURE.shape, np.nan)
    assert FrictionLimit(0.3).limit(PRESSURE, out=out) is out
    assert (out == 0.3 * PRESSURE).all()
    assert FrictionLimit(0.3).slope(PRESSURE) == 0.3


def test_shear_limit_cuts_it_off():
    bound = FrictionLimit(0.3, shear_limit=100.0)
    assert bound.limit(PRESSURE).tolist() == [[0.0, 0.3e-9, 15.0], [30.0, 100.0, 100.0]]
    assert bound.slope(PRESSURE).tolist() == [[0.3, 0.3, 0.3], [0.3, 0.0, 0.0]]


@pytest.mark.parametrize("exponent", [0.5, 2.0 / 3.0, 1.4])
def test_power_of_the_pressure(exponent):
    bound = FrictionLimit(0.3, exponent=exponent, reference_pressure=100.0)
    assert bound.limit(PRESSURE)[1, 0] == pytest.approx(30.0)
    assert bound.limit(PRESSURE)[1, 1] == pytest.approx(0.3 * 100.0 * 10.0**exponent)
    # no coefficient is larger than ten times that at the reference pressure
    assert (bound.coefficient_at(PRESSURE) <= 0.3 * MOST_GROWTH).all()
    assert bound.limit(PRESSURE)[0, 0] == 0.0
    step = 1e-6 * PRESSURE[1]
    slope = (bound.limit(PRESSURE[1] + step) - bound.limit(PRESSURE[1] - step)) / (2.0 * step)
    assert bound.slope(PRESSURE[1]) == pytest.approx(slope)
