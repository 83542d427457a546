from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.contact.solvers.rigid_modes import TangentialModes, load_factor
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl

GRID = Grid.from_size((60, 64), (2.2, 2.2))
MODES = TangentialModes(GRID)
HERTZ = np.sqrt(np.maximum(1.0 - GRID.x[:, None] ** 2 - GRID.y[None, :] ** 2, 0.0))
CARRIED = float(HERTZ.sum()) * GRID.cell_area


def factor(qx=0.0, qy=0.0, mz=0.0, limit=HERTZ, modes=MODES):
    return load_factor(limit, LoadControl((True, True, True), (qx, qy, mz)), modes)


def test_no_load_never_slides():
    assert factor() == math.inf
    assert load_factor(HERTZ, LoadControl((False, False, False), (1.0, 1.0, 1.0)), MODES) == math.inf


def test_a_force_slides_at_the_friction_of_the_load():
    assert load_factor(HERTZ, LoadControl((True, True, False), (3.0, 4.0, 0.0)), MODES) == pytest.approx(CARRIED / 5.0)
    assert factor(qx=3.0, qy=-4.0) == pytest.approx(CARRIED / 5.0, rel=1e-3)


def test_a_torque_slides_at_that_of_gross_slip():
    """(3 pi/16) mu P a for Hertz's pressure."""
    assert factor(mz=-1.0) == pytest.approx(3.0 * math.pi / 16.0 * CARRIED, rel=2e-3)


@pytest.mark.parametrize("loads", [(1.0, 0.5, 0.3), (0.2, 0.0, 1.0), (-1.0, 1.0, -0.6)])
def test_no_motion_dissipates_less(loads):
    """The kinematic theorem, with random motions; and the nearest of them comes near."""
    found, random = factor(*loads), np.random.default_rng(0)
    motion, least = np.empty((2, *GRID.shape)), math.inf
    for rigid in random.normal(size=(3000, 3)):
        work = float(rigid @ np.array(loads))
        if work > 0.0:
            MODES.displacement(rigid / work, motion)
            least = min(least, float(np.vdot(HERTZ, np.hypot(*motion))) * GRID.cell_area)
    assert found <= least * (1.0 + 1e-9)
    assert found == pytest.approx(least, rel=0.02)


def test_force_and_torque_together_carry_less_than_alone():
    together, torque = factor(qx=1.0, mz=0.4), factor(mz=0.4)
    assert together < min(torque, CARRIED)
    assert together > 1.0 / (1.0 / torque + 1.0 / CARRIED)


@pytest.mark.parametrize("scale", [1e-7, 1e5])
def test_lengths_do_not_count(scale):
    grid = Grid.from_size(GRID.shape, (2.2 * scale, 2.2 * scale))
    small = factor(1.0, 0.5, 0.3 * scale, modes=TangentialModes(grid)) / scale**2
    assert small == pytest.approx(factor(1.0, 0.5, 0.3), rel=1e-9)


class TestSingleCell:
    LIMIT = np.zeros(GRID.shape)
    LIMIT[10, 20] = 2.0
    FORCE = 2.0 * GRID.cell_area

    def test_it_carries_a_force_through_itself(self):
        assert factor(qx=1.0, mz=-MODES.y[20], limit=self.LIMIT) == pytest.approx(self.FORCE)

    def test_it_carries_no_torque_about_itself(self):
        assert factor(mz=1.0, limit=self.LIMIT) == 0.0
        assert factor(qx=1.0, limit=self.LIMIT) == 0.0  # off the line of action

    def test_it_resists_turning_about_the_origin(self):
        arm = math.hypot(MODES.x[10], MODES.y[20])
        found = load_factor(self.LIMIT, LoadControl((False, False, True), (0.0, 0.0, 1.0)), MODES)
        assert found == pytest.approx(self.FORCE * arm)

    def test_no_contact_carries_nothing(self):
        assert factor(qx=1.0, limit=np.zeros(GRID.shape)) == 0.0
        assert factor(mz=1.0, limit=np.zeros(GRID.shape)) == 0.0
