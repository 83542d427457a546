from __future__ import annotations

import numpy as np
import pytest
from solving import RIGID, build

from fretsolve.contact.increment.sheared_surfaces import AndersonAcceleration
from fretsolve.errors import NotConvergedError
from fretsolve.simulation.simulation import run


@pytest.mark.parametrize("growth", [0.5, 3.0])
def test_linear_fixed_points_are_found(growth):
    """Also where the plain iteration turns and grows without end: as many iterates as there are unknowns."""
    matrix = growth * np.array([[0.0, 1.0, 0.2], [-1.0, 0.0, 0.0], [0.0, 0.1, -0.7]])
    right = np.array([1.0, -2.0, 0.5])
    acceleration, iterate = AndersonAcceleration(), np.zeros(3)
    for _ in range(6):
        iterate = acceleration.next(iterate, matrix @ iterate + right, np.ones(3))
    np.testing.assert_allclose(iterate, np.linalg.solve(np.eye(3) - matrix, right), rtol=1e-8)


def test_what_has_no_weight_does_not_count():
    acceleration, iterate = AndersonAcceleration(), np.zeros(2)
    for step in range(8):
        image = np.array([0.5 * iterate[0] + 1.0, float(step % 2)])
        iterate = acceleration.next(iterate, image, np.array([1.0, 0.0]))
    assert iterate[0] == pytest.approx(2.0, rel=1e-9)


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
