"""The law of wear."""

import numpy as np
import pytest

from fretsolve.wear.law import WearLaw

PRESSURE, PATH, FRICTION = np.array([0.0, 100.0, 400.0]), np.array([1e-3, 2e-3, 0.0]), 0.6


def test_energy_and_archard_agree_where_k_is_alpha_times_the_friction():
    energy = FRICTION * PRESSURE * PATH
    by_energy = WearLaw("energy", alpha=1e-7).depth(energy, PATH, PRESSURE)
    by_pressure = WearLaw("archard", k=FRICTION * 1e-7).depth(energy, PATH, PRESSURE)
    np.testing.assert_allclose(by_energy, by_pressure, rtol=1e-14)
    assert by_energy[1] == pytest.approx(1e-7 * 0.6 * 100.0 * 2e-3)


def test_depth_grows_with_a_power_of_the_pressure():
    depth = WearLaw("archard", k=1e-9, exponent=2.0).depth(np.zeros(3), np.full(3, 1e-3), PRESSURE)
    np.testing.assert_allclose(depth, [0.0, 1e-8, 1.6e-7])
    less = WearLaw("archard", k=1e-9, exponent=0.5, reference_pressure=100.0)
    np.testing.assert_allclose(less.depth(np.zeros(3), np.full(3, 1e-3), PRESSURE), [0.0, 1e-10, 2e-10])


def test_the_bodies_share_the_depth():
    first, second = WearLaw("energy", alpha=1e-7, share=(0.25, 0.75)).of_bodies(np.array([4.0]))
    assert (first[0], second[0]) == (1.0, 3.0)
