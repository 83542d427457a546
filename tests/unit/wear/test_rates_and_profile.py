"""The law of wear, its rates, and the profile after many cycles."""

from __future__ import annotations

import numpy as np
import pytest
from solving import build

from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import NotConvergedError
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.setup.wear_law import WearLaw
from fretsolve.simulation.simulation import set_up
from fretsolve.wear.profile import ProfileProblem, wear_over_jump

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


class TestProfile:
    """A sphere on a flat; P is imposed, so that a jump wears the compliance times P."""

    LOAD = 400.0

    def problem(self, iterations=500, **more):
        setup = set_up(build(grid={"points": 16, "size": 0.8}, coupling="none", friction=0.0, **more))
        level = GridLevel(setup.grid, setup.model, ThreadTeam(), np.float64)
        control, separation = LoadControl((True, True, True), (self.LOAD, 0.0, 0.0)), setup.separation()
        pressure = np.zeros(setup.grid.shape)
        found = level.normal.solve(separation, control, pressure, 1e-8, 500, np.zeros(3))
        return level, ProfileProblem(separation, control, found.rigid, pressure, 1e-8, iterations)

    @pytest.mark.parametrize("cycles", [1.0, 1e3])
    def test_the_volume_follows_from_the_load(self, cycles):
        level, problem = self.problem()
        found = wear_over_jump(level, problem, np.full(problem.pressure.shape, 1e-9 * cycles), 0.01)
        assert found.depth.sum() * level.grid.cell_area == pytest.approx(1e-9 * cycles * self.LOAD, rel=1e-6)
        assert 0.0 <= found.error <= 0.01
        assert found.depth.min() >= 0.0

    def test_a_problem_that_is_not_solved_says_what_helps(self):
        level, problem = self.problem(iterations=1)
        with pytest.raises(NotConvergedError, match=r"not found after 1 iterations.*raise solver\.max_iterations"):
            wear_over_jump(level, problem, np.full(problem.pressure.shape, 1e-5), 0.01)
