"""The law of wear, its rates, and the profile after many cycles."""

from __future__ import annotations

import numpy as np
import pytest
from solving import build

from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import NotConvergedError
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms
from fretsolve.problem.setup.wear_law import LEAST_PRESSURE, MOST_RATE, WearLaw, owed, rate_over_jump, rates_of
from fretsolve.result.state import WearState
from fretsolve.simulation.simulation import set_up
from fretsolve.wear.profile import CompliantOperator, ProfileProblem, wear_over_jump

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


ENERGY, ARCHARD = WearLaw("energy", alpha=1e-7), WearLaw("archard", k=2e-8)
SHAPE = (6, 5)


def state_of(depth, path, mark=0.0, rate=0.0, used=0.0):
    """The state of wear where a cycle ends, with uniform rates."""
    mark, rate, used = (np.full_like(depth, one) for one in (mark, rate, used))
    return WearState(depth, np.zeros_like(depth), mark, path, rate, used)


class TestRates:
    pressure = np.array([[100.0, 50.0], [2.0, 0.0]])
    path = np.array([[1e-3, 2e-3], [3e-3, 4e-3]])

    def test_cells_that_touch_wear_by_what_they_have_worn(self):
        """With Archard's law the depth per pressure is k times the path, touching or not."""
        state = state_of(ARCHARD.k * self.pressure * self.path, self.path)
        rates = rates_of(ARCHARD, FrictionLimit(0.4), self.pressure, state)
        np.testing.assert_allclose(rates.rate, ARCHARD.k * self.path, rtol=1e-12)
        np.testing.assert_allclose(rates.rest, 0.0, atol=1e-20)
        np.testing.assert_allclose(rates.energy, 0.4 / ARCHARD.k, rtol=1e-12)

    def test_a_large_rate_is_limited_and_the_rest_worn_at_any_pressure(self):
        of_path = 0.4 * ENERGY.alpha * self.path
        worn = np.where(self.pressure > 0.0, 10.0 * of_path * self.pressure, 0.0)
        rates = rates_of(ENERGY, FrictionLimit(0.4), self.pressure, state_of(worn, self.path))
        touching = self.pressure > 0.0
        np.testing.assert_allclose(rates.rate, np.where(touching, MOST_RATE, 1.0) * of_path, rtol=1e-12)
        np.testing.assert_allclose(rates.rest, np.where(touching, 10.0 - MOST_RATE, 0.0) * of_path * self.pressure)

    def test_a_power_of_the_pressure_has_a_least_one(self):
        law = WearLaw("archard", k=1e-8, exponent=2.0, reference_pressure=10.0)
        rates = rates_of(law, FrictionLimit(0.4), self.pressure, state_of(np.zeros((2, 2)), self.path))
        mean = self.pressure.sum() / 3
        assert rates.rate[1, 1] == pytest.approx(1e-8 * LEAST_PRESSURE * mean / 10.0 * self.path[1, 1])

    def test_what_a_jump_took_too_little(self):
        state = state_of(np.zeros((2, 2)), self.path, rate=2e-9, used=1.5e-9)
        np.testing.assert_allclose(owed(np.full((2, 2), 3e-9), 100.0, state), 100.0 * 1e-9)

    def test_the_rate_goes_on_changing_to_the_middle_of_a_jump(self):
        state = state_of(np.zeros((2, 2)), self.path, rate=2e-9)
        now = np.full((2, 2), 3e-9)
        np.testing.assert_allclose(rate_over_jump(now, 50.0, state, 100.0), 3.25e-9)
        np.testing.assert_allclose(rate_over_jump(now, 1e4, state, 100.0), 4.5e-9)  # by half of it at most
        np.testing.assert_allclose(rate_over_jump(now, 1e4, state_of(now, now, rate=9e-9), 100.0), 1.5e-9)


def test_a_compliant_layer_adds_to_the_diagonal():
    elastic = ElasticOperator(SHAPE, (0.1, 0.12), Compliances(1.1e-5, 3.4e-6, 0.0), Terms(False, False, False))
    compliance = np.random.default_rng(3).uniform(0.0, 2.0, SHAPE) * 1e-6
    operator, size = CompliantOperator(elastic, compliance), compliance.size
    dense = np.empty((size, size))
    for cell, unit in enumerate(np.eye(size)):
        uz = np.empty(SHAPE)
        elastic.normal(unit.reshape(SHAPE), uz)
        dense[:, cell] = uz.ravel()
    dense += np.diag(compliance.ravel())
    pressure, uz = np.random.default_rng(4).normal(size=SHAPE), np.empty(SHAPE)
    operator.normal(pressure, uz)
    np.testing.assert_allclose(uz.ravel(), dense @ pressure.ravel(), rtol=1e-10)
    single = np.empty(SHAPE, np.float32)
    operator.inner.normal(pressure.astype(np.float32), single)
    np.testing.assert_allclose(single * operator.unit, uz, rtol=2e-5, atol=2e-6 * np.abs(uz).max())
    assert (operator.unit, operator.dtype, operator.team) == (elastic.unit, elastic.dtype, elastic.team)


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

    def test_a_small_jump_wears_by_the_pressure_at_its_start(self):
        level, problem = self.problem()
        found = wear_over_jump(level, problem, np.full(problem.pressure.shape, 1e-12), 0.01)
        np.testing.assert_allclose(
            found.depth, 1e-12 * problem.pressure, rtol=1e-3, atol=1e-15 * problem.pressure.max()
        )

    def test_a_problem_that_is_not_solved_says_what_helps(self):
        level, problem = self.problem(iterations=1)
        with pytest.raises(NotConvergedError, match=r"not found after 1 iterations.*raise solver\.max_iterations"):
            wear_over_jump(level, problem, np.full(problem.pressure.shape, 1e-5), 0.01)
