"""Increments that are hard to solve: a contact that moves far, and strong friction between unlike bodies."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, RIGID, SIMILAR, build

from fretsolve import run
from fretsolve.errors import NotConvergedError
from fretsolve.simulation.problem_setup import set_up


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
