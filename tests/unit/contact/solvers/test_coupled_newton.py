"""Pressure and shear solved together, against staggered iteration."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, RIGID, build, grid_of, solve_last

import fretsolve.contact.increment.staggered_iteration
from fretsolve import run
from fretsolve.contact.solvers.coupled_equations import gmres
from fretsolve.contact.solvers.coupled_newton import CoupledNewton
from fretsolve.contact.solvers.rigid_modes import TangentialModes, load_factor
from fretsolve.errors import NotConvergedError
from fretsolve.problem.model.load_control import LoadControl

PATH = [{"P": LOAD, "increments": 2}, {"Qx": 20.0, "Mz": 1.0, "increments": 2}, {"delta_y": 1e-4, "increments": 1}]


def solve_at_once(monkeypatch, **parts):
    """All increments solved together from the first pass on."""
    monkeypatch.setattr(fretsolve.contact.increment.staggered_iteration, "ENOUGH_ITERATIONS", 1)
    return list(run(build(**parts)))


@pytest.mark.parametrize("size", [1, 40])
def test_gmres(size):
    random = np.random.default_rng(size)
    matrix = np.eye(size) + 0.3 * random.standard_normal((size, size)) / np.sqrt(size)
    right = random.standard_normal((size, 1))
    found, iterations = gmres(lambda x: matrix @ x, right, 1e-10, size)
    assert np.abs(found - np.linalg.solve(matrix, right)).max() < 1e-9
    assert 1 <= iterations <= size


@pytest.mark.parametrize("bodies", [DISSIMILAR, RIGID])
def test_together_as_in_turns(monkeypatch, bodies):
    parts = {"bodies": bodies, "friction": 0.2, "grid": {"points": 24, "size": 0.8}, "load_path": PATH}
    in_turns = list(run(build(**parts)))
    together = solve_at_once(monkeypatch, **parts)
    for one, other in zip(in_turns, together, strict=True):
        peak = one.summary.max_pressure
        assert other.summary.alternations != one.summary.alternations
        assert np.abs(one.fields.pressure - other.fields.pressure).max() < 1e-5 * peak
        assert np.abs(one.fields.shear - other.fields.shear).max() < 1e-5 * peak
        # 1e-7 of delta_z: while the bodies are pressed, delta_x is what the tolerance of 1e-6 leaves
        assert other.summary.delta_x == pytest.approx(one.summary.delta_x, rel=1e-4, abs=1e-9)


def test_strong_friction_needs_it(monkeypatch):
    """Gross slip with friction times Dundurs' constant of 5, where staggered iteration diverges."""
    parts = {
        "bodies": RIGID,
        "friction": 10.0,
        "grid": {"points": 32, "size": 3.0},
        "load_path": [{"P": LOAD, "increments": 2}, {"delta_x": 1.0, "increments": 1}],
    }
    last = list(run(build(**parts)))[-1]
    assert last.summary.Qx == pytest.approx(10.0 * LOAD, rel=1e-5)
    assert last.summary.worst_residual <= 1e-6
    monkeypatch.setattr(CoupledNewton, "solve", lambda *arguments: None)
    with pytest.raises(NotConvergedError, match=r"Dundurs' constant is 10 x 0\.5"):
        list(run(build(**parts)))


def test_small_motions_in_single_precision(monkeypatch):
    """Slips of 1e-3 of the elastic displacements, which the difference of two of them would lose."""
    parts = {
        "bodies": RIGID,
        "friction": 0.2,
        "grid": {"points": 24, "size": 0.8},
        "load_path": [{"P": LOAD, "increments": 2}, {"delta_x": 1e-5, "increments": 2}],
    }
    exact = list(run(build(**parts)))[-1].summary
    found = solve_at_once(monkeypatch, **parts, solver={"precision": "single", "tolerance": 1e-5})[-1].summary
    assert found.Qx == pytest.approx(exact.Qx, rel=1e-3)
    assert found.worst_residual <= 1e-5
    assert found.alternations <= 3  # one staggered, as asked for, and one coupled, or two where rounding has it so


def test_tangential_problem_whose_zones_go_round():
    """Force and torque within 1e-6 of the limit load: only a step that keeps the friction limit solves it."""
    pressed = solve_last(friction=0.0, grid={"points": 32})
    limit = 0.1 * pressed.fields.pressure
    loads = np.array([19.2, 14.4, 7.275])
    modes = TangentialModes(grid_of(friction=0.0, grid={"points": 32}))
    loads *= (1.0 - 1e-6) * load_factor(limit, LoadControl((True, True, True), tuple(loads)), modes)
    stage = dict(zip(("Qx", "Qy", "Mz"), map(float, loads), strict=True))
    path = [{"P": LOAD}, {name: 0.99 * load for name, load in stage.items()}, stage | {"increments": 1}]
    last = solve_last(grid={"points": 32}, load_path=path).summary
    assert last.worst_residual <= 1e-6
    assert (last.Qx, last.Mz) == pytest.approx((loads[0], loads[2]), rel=1e-9)
