"""Increments that are hard to solve: a contact that moves far, and strong friction between unlike bodies."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, RIGID, SIMILAR, build

from fretsolve import run
from fretsolve.contact.increment.increment import IncrementSolver
from fretsolve.contact.increment.states import Prediction
from fretsolve.errors import NotConvergedError
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import increment_solver, states_of


@pytest.mark.parametrize("points", [47, 48])
def test_a_contact_that_moves_by_more_than_its_size(points):
    """Pressed in the middle, then by a moment that shifts it past its edge: solved as if nothing had touched before."""
    parts = {"surface": {"sphere": {"radius": 12.0}}, "bodies": SIMILAR, "friction": 0.7}
    path = [{"P": 200.0, "increments": 1}, {"Mx": 100.0, "increments": 1}]
    *_, last = run(build(**parts, grid={"points": points}, load_path=path))
    assert last.summary.residual_gap <= 1e-6
    columns = np.flatnonzero(last.fields.pressure.any(axis=0))
    y = set_up(build(**parts, grid={"points": points}, load_path=path)).grid.y
    assert 0.5 * (y[columns[0]] + y[columns[-1]]) == pytest.approx(0.5, abs=y[1] - y[0])
    assert last.summary.Mx == pytest.approx(100.0, rel=1e-6)


def test_a_contact_that_grows_beyond_the_cells_around_the_last_one():
    grid = {"points": 96, "size": 1.0}
    *_, grown = run(
        build(bodies=DISSIMILAR, grid=grid, load_path=[{"P": load, "increments": 1} for load in (0.1, 400.0)])
    )
    (at_once,) = run(build(bodies=DISSIMILAR, grid=grid, load_path=[{"P": 400.0, "increments": 1}]))
    peak = at_once.summary.max_pressure
    np.testing.assert_allclose(grown.fields.pressure, at_once.fields.pressure, atol=2e-3 * peak)
    assert grown.summary.residual_gap <= 1e-6


def test_strong_friction_and_coupling():
    """Pressure and shear would throw each other back and forth without end."""
    path = [{"P": 400, "increments": 2}, {"Qx": 1000, "increments": 2}]
    parts = {"bodies": RIGID, "friction": 5, "grid": {"points": 32, "size": 2.0}, "load_path": path}
    states = list(run(build(**parts)))
    assert max(state.summary.alternations for state in states) < 60
    assert states[-1].summary.Qx == pytest.approx(1000.0)
    assert states[-1].summary.residual_gap < 1e-6


def test_what_does_not_converge_is_said(monkeypatch):
    """With fewer iterations than it needs, since no case is known that needs more than there are."""
    monkeypatch.setattr("fretsolve.contact.increment.staggered_iteration.MOST_STAGGERED_ITERATIONS", 3)
    path = [{"P": 400, "increments": 5}]
    with pytest.raises(NotConvergedError, match="still change each other after 3 staggered iterations"):
        list(run(build(bodies=RIGID, friction=1e6, grid={"points": 32}, load_path=path)))


PULLED = [{"P": 400.0, "increments": 1}, {"Qx": 30.0, "increments": 4}]


def applications_of(case):
    """Return the states of a run, with the applications of its solver."""
    setup = set_up(case)
    solver = increment_solver(setup, setup.separation(), 1)
    return list(states_of(setup, solver=lambda: solver)), solver.applications


@pytest.mark.parametrize("factor", [1.0, 1e3, -1e6])
def test_a_prediction_that_misleads_changes_nothing_but_the_cost(monkeypatch, factor):
    case = build(bodies=DISSIMILAR, grid={"points": [32, 33]}, load_path=PULLED)
    expected = list(run(case))[-1]
    random = np.random.default_rng(1)

    def misleading(self, work):
        work.shear += factor * random.normal(size=work.shear.shape)
        work.elastic_slip = None

    monkeypatch.setattr(Prediction, "apply", misleading)
    states = list(run(case))
    assert states[-1].summary.worst_residual <= 1e-6
    scale = np.abs(expected.fields.shear).max()
    np.testing.assert_allclose(states[-1].fields.shear, expected.fields.shear, atol=1e-4 * scale)


def test_a_failure_from_a_prediction_is_not_the_last_word(monkeypatch):
    case = build(bodies=DISSIMILAR, grid={"points": [32, 33]}, load_path=PULLED)
    expected, solve, failed = list(run(case)), IncrementSolver._solve, []

    def failing(self, increment, start, before, afresh=False):
        found = solve(self, increment, start, before, afresh)
        if start.prediction is not None:
            failed.append(increment)
            raise NotConvergedError("not from here")
        return found

    monkeypatch.setattr(IncrementSolver, "_solve", failing)
    found, spent = applications_of(case)
    recorded = sum(state.summary.operator_applications for state in found)
    assert spent <= recorded <= spent + len(found)  # of both attempts, rounded up
    assert len(failed) == 3  # of four increments, the first has none before it
    assert found[-1].summary.Qx == pytest.approx(30.0)
    assert found[-1].summary.work_total == pytest.approx(expected[-1].summary.work_total, rel=1e-5)


def test_a_prediction_earns_its_cost_where_friction_runs_in(monkeypatch):
    """The prediction alone is never taken for the solution, though it may balance the loads."""
    friction = {"initial": 0.05, "final": 0.9, "energy": 1e-5}
    path = [
        {"P": 400.0, "increments": 1},
        {"Qx": 15.0, "increments": 10},
        {"P": 380.0, "increments": 3},
        {"Qx": 18.0, "increments": 40, "spacing": "graded"},
    ]
    case = build(bodies=SIMILAR, friction=friction, grid={"points": [48, 49], "size": 1.0}, load_path=path)
    _, predicted = applications_of(case)
    monkeypatch.setattr(Prediction, "apply", lambda self, work: None)
    _, plain = applications_of(case)
    assert predicted < plain
