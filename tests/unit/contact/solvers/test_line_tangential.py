"""Zones of a line contact found one rigid motion after another, where the Newton method has given up."""

from __future__ import annotations

import numpy as np
import pytest
from line_cases import FRICTION, HERTZ, LOAD, MATERIAL

from fretsolve.contact.solvers.line_tangential import LineTangentialSolver
from fretsolve.contact.solvers.normal import SolverResult
from fretsolve.contact.solvers.tangential import SlipScales, TangentialSolver
from fretsolve.elastic.operator_on_grid import LineOperator
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.required_terms import Terms

GRID = LineGrid.of_length(60, 2.5 * HERTZ.half_width, 0.0)
LIMIT = FRICTION * np.asarray(HERTZ.pressure(GRID.x))[:, None]
CARRIED = float(LIMIT.sum()) * GRID.cell_area


@pytest.fixture
def solver(monkeypatch: pytest.MonkeyPatch) -> LineTangentialSolver:
    """A solver whose Newton method gives up at its first call."""
    solver = LineTangentialSolver(LineOperator(GRID, MATERIAL, Terms(True, False, False)), GRID)
    calls, solve = [], TangentialSolver.solve

    def reluctant(self, *arguments):
        calls.append(arguments)
        return solve(self, *arguments) if len(calls) > 1 else SolverResult(np.zeros(3), 0, 1.0, 1.0, False)

    monkeypatch.setattr(TangentialSolver, "solve", reluctant)
    return solver


@pytest.mark.parametrize("share", [0.2, 0.6, 0.99])
@pytest.mark.parametrize("stretch", [0.0, 2e-4])
def test_stick_and_slip_obey_coulombs_law(solver, share, stretch):
    slip = np.zeros((2, GRID.nx, 1))
    slip[0, :, 0] = stretch * GRID.x  # as by bulk stress
    shear, free = np.zeros_like(slip), slip.copy()
    force = share * CARRIED
    control = LoadControl((True, True, False), (force, 0.0, 0.0))
    found = solver.solve(slip, control, LIMIT, shear, 1e-8, 50, SlipScales(motion=1e-4))
    assert found.converged
    assert shear[0].sum() * GRID.cell_area == pytest.approx(force, rel=1e-8)
    moved = np.empty_like(shear)
    solver.operator.tangential(shear, moved)
    np.testing.assert_allclose(slip, free - moved, atol=1e-12)
    relative, contact = (slip[0] + found.rigid[0]) / 1e-4, LIMIT > 0.0
    sliding = contact & solver.slipping
    assert (np.abs(shear[0]) <= LIMIT * (1.0 + 1e-6)).all()
    assert np.abs(relative[contact & ~sliding]).max(initial=0.0) < 1e-6
    assert (relative[sliding] * shear[0][sliding] >= -1e-6 * LIMIT.max()).all()
    assert sliding.any()


def test_by_a_force_alone_the_stick_zone_is_cattaneos(solver):
    slip, shear = np.zeros((2, GRID.nx, 1)), np.zeros((2, GRID.nx, 1))
    control = LoadControl((True, True, False), (0.64 * CARRIED, 0.0, 0.0))
    assert solver.solve(slip, control, LIMIT, shear, 1e-8, 50, SlipScales(motion=1e-4)).converged
    sticking = (LIMIT > 0.0) & ~solver.slipping
    assert sticking.sum() * GRID.dx == pytest.approx(2.0 * 0.6 * HERTZ.half_width, abs=2.0 * GRID.dx)
    assert pytest.approx(FRICTION * LOAD, rel=1e-2) == CARRIED


def test_an_estimate_is_left_to_the_newton_method(solver):
    slip, shear = np.zeros((2, GRID.nx, 1)), np.zeros((2, GRID.nx, 1))
    control = LoadControl((True, True, False), (0.5 * CARRIED, 0.0, 0.0))
    assert not solver.solve(slip, control, LIMIT, shear, 1e-2, 50, SlipScales(motion=1e-4)).converged
    assert not shear.any()
