"""The surfaces that shear deforms, against the operator's own displacements."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, build

from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.increment.grid_hierarchy import GridLevel
from fretsolve.increment.sheared_surfaces import ShearedSurfaces
from fretsolve.increment.states import WorkingState
from fretsolve.setup.problem_setup import set_up


@pytest.fixture
def level() -> GridLevel:
    setup = set_up(build(bodies=DISSIMILAR, grid={"points": 16, "size": 0.8}, coupling="full"))
    return GridLevel(setup.grid, setup.model, ThreadTeam(), np.float64)


def loaded(level: GridLevel) -> WorkingState:
    random = np.random.default_rng(8)
    pressure = np.zeros(level.grid.shape)
    pressure[5:11, 4:12] = 300.0
    shear = 30.0 * random.normal(size=(2, *level.grid.shape)) * (pressure > 0.0)
    return WorkingState(pressure, shear, np.zeros(6), gap_scale=1e-3)


def displaced(level: GridLevel, shear: np.ndarray) -> np.ndarray:
    uz = np.empty(level.grid.shape)
    level.operator.normal_from_shear(shear, uz)
    return uz


def test_shear_moves_the_surfaces(level):
    work = loaded(level)
    undeformed = np.random.default_rng(1).uniform(0.0, 1e-3, level.grid.shape)
    surfaces, borrowed = ShearedSurfaces(level, undeformed), np.empty(level.grid.shape)
    np.testing.assert_array_equal(surfaces.separation, undeformed)
    surfaces.begin(work, borrowed)
    np.testing.assert_allclose(surfaces.separation, undeformed + displaced(level, work.shear), atol=1e-15)


def test_it_follows_the_shear_and_returns_the_largest_change_in_the_contact(level):
    work = loaded(level)
    surfaces, borrowed = ShearedSurfaces(level, np.zeros(level.grid.shape)), np.empty(level.grid.shape)
    surfaces.begin(work, borrowed)
    before = surfaces.separation.copy()
    work.shear = 1.2 * work.shear
    allowed = 1e-9
    change = surfaces.follow(work, allowed, borrowed)
    expected = displaced(level, work.shear)
    np.testing.assert_allclose(surfaces.separation, expected, atol=allowed)
    assert change == pytest.approx(np.abs(expected - before)[work.pressure > 0.0].max() / 1e-3, rel=1e-3)
    assert surfaces.follow(work, allowed, borrowed) == 0.0


def test_extrapolation_ends_where_it_begins_again(level):
    work = loaded(level)
    surfaces, borrowed = ShearedSurfaces(level, np.zeros(level.grid.shape)), np.empty(level.grid.shape)
    surfaces.begin(work, borrowed)
    assert not surfaces.accelerated
    surfaces.accelerate()
    assert surfaces.accelerated
    surfaces.begin(work, borrowed)
    assert not surfaces.accelerated
    np.testing.assert_allclose(surfaces.separation, displaced(level, work.shear), atol=1e-15)
