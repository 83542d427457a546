"""The mismatch of the surfaces under bulk stress, as an increment starts with it."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.increment.states import InitialState, with_mismatch
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.grid import Grid

GRID = Grid(12, 10, 0.1, 0.1, 3.0, -2.0)
STRETCH = np.array([2e-4, -1e-4, 5e-5])


def start_under(pressure: np.ndarray) -> InitialState:
    displacement = np.random.default_rng(6).normal(size=(2, *pressure.shape)) * 1e-4
    return InitialState(pressure, np.zeros((2, *pressure.shape)), displacement, np.arange(6) * 1e-3, FrictionLimit(0.5))


@pytest.mark.parametrize("turns", [True, False])
def test_rigid_motion_and_mismatch_together_are_the_stretch(turns: bool) -> None:
    pressure = np.zeros(GRID.shape)
    pressure[3:9, 2:5] = 1.0
    start = start_under(pressure)
    found = with_mismatch(start, STRETCH, GRID, turns=turns)
    delta_x, delta_y, phi_z = (found.rigid - start.rigid)[3:]
    x, y = np.meshgrid(GRID.x, GRID.y, indexing="ij")
    rest = found.mismatch
    assert rest is not None
    whole = [rest[0] + delta_x - phi_z * y, rest[1] + delta_y + phi_z * x]
    xx, yy, xy = STRETCH
    np.testing.assert_allclose(whole, [xx * x + xy * y, xy * x + yy * y], atol=1e-16)
    assert bool(phi_z) is turns
    assert found.rigid[:3].tolist() == start.rigid[:3].tolist()
    np.testing.assert_array_equal(found.displacement, start.displacement - rest)


def test_it_is_0_at_the_middle_of_the_contact() -> None:
    pressure = np.zeros(GRID.shape)
    pressure[3:8, 2:7] = 1.0
    found = with_mismatch(start_under(pressure), STRETCH, GRID)
    assert found.mismatch is not None
    np.testing.assert_allclose(found.mismatch[:, 5, 4], 0.0, atol=1e-18)
    assert found.rigid[5] == 5e-3  # an equally long and wide contact does not turn


def test_without_contact_the_middle_is_that_of_the_grid() -> None:
    found = with_mismatch(start_under(np.zeros(GRID.shape)), STRETCH, GRID)
    assert found.mismatch is not None
    np.testing.assert_allclose(found.mismatch.mean(axis=(1, 2)), 0.0, atol=1e-18)
