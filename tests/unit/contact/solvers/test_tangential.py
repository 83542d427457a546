from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.solvers.rigid_modes import TangentialModes
from fretsolve.contact.solvers.tangential import SlipScales, TangentialSolver
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

GRID = Grid.from_size((20, 23), (0.7, 0.72))
MATERIAL = Compliances(A=1.82e-5, B=7.8e-6, C=0.0)
RADIUS = 0.3
LIMIT = 210.0 * np.sqrt(np.maximum(1.0 - (GRID.x[:, None] ** 2 + GRID.y[None, :] ** 2) / RADIUS**2, 0.0))
CARRIED = float(LIMIT.sum()) * GRID.cell_area
NOTHING_KNOWN = np.zeros((2, *GRID.shape))
TOLERANCE = 1e-8


def solver(terms=None):
    operator = ElasticOperator(GRID.shape, (GRID.dx, GRID.dy), MATERIAL, terms or Terms(True, True, False))
    return TangentialSolver(operator, GRID)


def forces(qx=0.0, qy=0.0, mz=0.0):
    return LoadControl((True, True, True), (qx, qy, mz))


def solve(control, limit=LIMIT, known=NOTHING_KNOWN, shear=None, most=2000, one=None, motion=0.0):
    one = one or solver()
    shear, displacement = np.zeros((2, *GRID.shape)) if shear is None else shear.copy(), np.empty((2, *GRID.shape))
    one.operator.tangential(shear, displacement)
    elastic_slip = known - displacement
    result = one.solve(elastic_slip, control, limit, shear, TOLERANCE, most, SlipScales(motion))
    dx, dy, turn = result.rigid
    one.operator.tangential(shear, displacement)
    length = max(motion, np.abs(result.rigid).max() * GRID.size[0])
    np.testing.assert_allclose(elastic_slip, known - displacement, rtol=1e-12, atol=TOLERANCE * length)
    slip = known - displacement
    slip[0] += dx - turn * GRID.y[None, :]
    slip[1] += dy + turn * GRID.x[:, None]
    slip *= limit > 0.0
    return result, shear, slip, one


def assert_coulomb(result, shear, slip, one, limit=LIMIT):
    """|q| <= limit; no slip below it, slip along q at it."""
    assert result.converged
    length, distance = np.hypot(*shear), np.hypot(*slip)
    largest = max(distance.max(), np.abs(result.rigid[:2]).max(), 1e-3)
    assert (length <= limit * (1.0 + 1e-9) + 1e-9).all()
    inside = length < limit * (1.0 - 1e-6)
    assert distance[inside].max(initial=0.0) <= 2 * TOLERANCE * largest
    moving = distance > 1e-5 * largest
    dissipated = np.sum(shear * slip, axis=0)
    assert dissipated[moving] == pytest.approx(limit[moving] * distance[moving], rel=1e-5)
    assert not (one.slipping & inside).any()


LOADS = [
    forces(qx=0.9 * CARRIED),
    forces(qx=0.5 * CARRIED, qy=-0.6 * CARRIED),
    forces(mz=0.1 * CARRIED),
    forces(qx=0.4 * CARRIED, mz=0.08 * CARRIED),
    LoadControl((False, False, False), (1e-3, 2e-4, 1e-3)),
    LoadControl((False, True, False), (5e-4, 0.2 * CARRIED, 0.0)),
]


@pytest.mark.parametrize("control", LOADS)
def test_law_of_friction(control):
    result, shear, slip, one = solve(control)
    assert_coulomb(result, shear, slip, one)
    found = TangentialModes(GRID).resultants(shear)
    for mode in control.forced_index:
        assert found[mode] == pytest.approx(control.values[mode], abs=1e-6 * CARRIED)
    for mode in set(range(3)) - set(control.forced_index):
        assert result.rigid[mode] == control.values[mode]


@pytest.mark.parametrize("seed", range(3))
def test_any_start_leads_to_the_one_solution(seed):
    control = LOADS[3]
    _, exact, _, _ = solve(control)
    start = np.random.default_rng(seed).normal(scale=200.0, size=(2, *GRID.shape))
    one = solver()
    one.slipping[:] = np.random.default_rng(seed + 9).random(GRID.shape) < 0.5
    result, shear, slip, one = solve(control, shear=start, one=one)
    assert_coulomb(result, shear, slip, one)
    np.testing.assert_allclose(shear, exact, atol=1e-4 * LIMIT.max())


def test_a_single_cell():
    limit = np.zeros(GRID.shape)
    limit[3, 4] = 100.0
    result, shear, _, _ = solve(LoadControl((True, True, False), (0.5 * 100.0 * GRID.cell_area, 0.0, 0.0)), limit=limit)
    assert result.converged
    assert shear[0, 3, 4] == pytest.approx(50.0)
    assert np.count_nonzero(shear) <= 2
