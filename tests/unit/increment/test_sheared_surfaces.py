"""The surfaces that shear deforms, against the operator's own displacements."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, build

from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.friction.limit import FrictionLimit
from fretsolve.increment.grid_hierarchy import GridLevel
from fretsolve.increment.sheared_surfaces import ShearedSurfaces
from fretsolve.increment.working_state import InitialState, WorkingState
from fretsolve.setup.problem_setup import set_up


@pytest.fixture
def level() -> GridLevel:
    setup = set_up(build(bodies=DISSIMILAR, grid={"points": 16, "size": 0.8}, coupling="full"))
    return GridLevel(setup.grid, setup.model, ThreadTeam(), np.float64)


def states(level: GridLevel) -> tuple[InitialState, WorkingState]:
    random = np.random.default_rng(8)
    pressure = np.zeros(level.grid.shape)
    pressure[5:11, 4:12] = 300.0
    shear = 30.0 * random.normal(size=(2, *level.grid.shape)) * (pressure > 0.0)
    start = InitialState(pressure, np.zeros_like(shear), np.zeros_like(shear), np.zeros(6), FrictionLimit(0.5))
    return start, WorkingState(pressure, shear, np.zeros(6), gap_scale=1e-3)


def displaced(level: GridLevel, shear: np.ndarray) -> np.ndarray:
    uz = np.empty(level.grid.shape)
    level.operator.normal_from_shear(shear, uz)
    return uz


def test_shear_moves_the_surfaces(level):
    start, work = states(level)
    undeformed = np.random.default_rng(1).uniform(0.0, 1e-3, level.grid.shape)
    surfaces, borrowed = ShearedSurfaces(level, undeformed), np.empty(level.grid.shape)
    np.testing.assert_array_equal(surfaces.separation, undeformed)
    surfaces.begin(start, work, 1e-6, borrowed)
    np.testing.assert_allclose(surfaces.separation, undeformed + displaced(level, work.shear), atol=1e-15)


def test_it_follows_the_shear_and_returns_the_largest_change_in_the_contact(level):
    start, work = states(level)
    surfaces, borrowed = ShearedSurfaces(level, np.zeros(level.grid.shape)), np.empty(level.grid.shape)
    surfaces.begin(start, work, 1e-6, borrowed)
    before = surfaces.separation.copy()
    work.shear = 1.2 * work.shear
    allowed = 1e-9
    change = surfaces.follow(work, allowed, borrowed)
    expected = displaced(level, work.shear)
    np.testing.assert_allclose(surfaces.separation, expected, atol=allowed)
    assert change == pytest.approx(np.abs(expected - before)[work.pressure > 0.0].max() / 1e-3, rel=1e-3)
    assert surfaces.follow(work, allowed, borrowed) == 0.0


def test_extrapolation_ends_where_it_begins_again(level):
    start, work = states(level)
    surfaces, borrowed = ShearedSurfaces(level, np.zeros(level.grid.shape)), np.empty(level.grid.shape)
    surfaces.begin(start, work, 1e-6, borrowed)
    assert not surfaces.accelerated
    surfaces.accelerate()
    assert surfaces.accelerated
    surfaces.begin_again(work, borrowed)
    assert not surfaces.accelerated
    np.testing.assert_allclose(surfaces.separation, displaced(level, work.shear), atol=1e-15)


def test_a_gap_at_the_start_tells_the_displacement(level):
    """The gap of start and solver, uz = gap + rigid - undeformed, gives the same surfaces as the shear itself."""
    start, work = states(level)
    undeformed, rigid = np.full(level.grid.shape, 2e-4), np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0])
    both = displaced(level, work.shear)
    by_pressure = np.empty(level.grid.shape)
    level.operator.normal(start.pressure, by_pressure)
    gap = undeformed + by_pressure + both - rigid[0]
    known = InitialState(start.pressure, work.shear, start.displacement, rigid, start.friction, gap=gap)
    surfaces, borrowed = ShearedSurfaces(level, undeformed), np.empty(level.grid.shape)
    surfaces.begin(known, work, 1e-6, borrowed)
    np.testing.assert_allclose(surfaces.separation, undeformed, atol=1e-15)
    np.testing.assert_allclose(level.normal.uz[0], by_pressure + both, atol=1e-15)
    assert surfaces.largest_uz(known) == pytest.approx((by_pressure + both)[start.pressure > 0.0].max())
