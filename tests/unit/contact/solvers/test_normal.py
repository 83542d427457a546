from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.solvers.incremental_update import SHARE
from fretsolve.contact.solvers.normal import NormalSolver
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

GRID = Grid.from_size((26, 22), (0.8, 0.76))
MATERIAL = Compliances(A=1.82e-5, B=7.8e-6, C=0.0)
SPHERE = (GRID.x[:, None] ** 2 + GRID.y[None, :] ** 2) / 20.0
LOAD = LoadControl((True, False, False), (400.0, 0.0, 0.0))
TOLERANCE = 1e-8


def solver(grid=GRID):
    operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), MATERIAL, Terms(False, False, False))
    return NormalSolver(operator, grid)


def solve(separation=SPHERE, control=LOAD, pressure=None, tolerance=TOLERANCE, most=500, rigid=None):
    one = solver()
    pressure = np.zeros(GRID.shape) if pressure is None else pressure.copy()
    result = one.solve(separation, control, pressure, tolerance, most, np.zeros(3) if rigid is None else rigid)
    uz = np.empty(GRID.shape)
    one.operator.normal(pressure, uz)
    dz, tilt_x, tilt_y = result.rigid
    gap = separation + uz - (dz + tilt_x * GRID.y[None, :] + tilt_y * GRID.x[:, None])
    return result, pressure, gap


def assert_complementary(result, pressure, gap):
    assert result.converged
    assert (pressure >= 0.0).all()
    assert gap.min() >= -(1.0 + SHARE) * TOLERANCE * result.scale
    # What follows the pressure may lose a part of the tolerance in rounding.
    assert np.abs(gap[pressure > 0.0]).max(initial=0.0) <= (1.0 + SHARE) * TOLERANCE * result.scale


@pytest.mark.parametrize("seed", range(3))
def test_any_start_leads_to_the_one_solution(seed):
    """A convex program: random cells pressed at random, or far too hard, make no difference."""
    random = np.random.default_rng(seed)
    start = random.exponential(2000.0, GRID.shape) * (random.random(GRID.shape) < 0.3)
    _, exact, _ = solve()
    result, pressure, gap = solve(pressure=start)
    assert_complementary(result, pressure, gap)
    np.testing.assert_allclose(pressure, exact, atol=1e-4 * exact.max())


def test_where_there_is_no_material_nothing_presses():
    holes = SPHERE.copy()
    holes[10:14, 9:12] = np.inf
    result, pressure, gap = solve(separation=holes)
    assert result.converged
    assert not pressure[10:14, 9:12].any()
    solid = np.isfinite(holes)
    assert gap[solid].min() >= -TOLERANCE * result.scale


def test_single_cell():
    deep = np.full(GRID.shape, 1.0)
    deep[4, 5] = 0.0
    result, pressure, gap = solve(separation=deep)
    assert_complementary(result, pressure, gap)
    assert np.flatnonzero(pressure).tolist() == [4 * 22 + 5]


def test_preconditioned_iterations_are_few():
    """Frictionless Hertz takes about 20 on any grid; the counts grow slowly with the points."""
    grid = Grid.from_size((128, 128), (0.72, 0.72))
    one, pressure = solver(grid), np.zeros(grid.shape)
    sphere = (grid.x[:, None] ** 2 + grid.y[None, :] ** 2) / 20.0
    result = one.solve(sphere, LOAD, pressure, 1e-6, 500, np.zeros(3))
    assert result.converged
    assert result.iterations < 40
