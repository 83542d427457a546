"""Pressure and shear solved together, against the two in turns."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, build

import fretsolve.alternation
from fretsolve import run
from fretsolve.errors import NotConvergedError
from fretsolve.krylov import gmres

RIGID = ("rigid", {"young_modulus": 100e3, "poisson_ratio": 0.0})
PATH = [{"P": LOAD, "increments": 2}, {"Qx": 20.0, "Mz": 1.0, "increments": 2}, {"delta_y": 1e-4, "increments": 1}]


def solve_at_once(monkeypatch, **parts):
    """All increments solved together from the first pass on."""
    monkeypatch.setattr(fretsolve.alternation, "ENOUGH_ALTERNATIONS", 1)
    return list(run(build(**parts)))


@pytest.mark.parametrize("size", [1, 5, 40])
def test_gmres(size):
    random = np.random.default_rng(size)
    matrix = np.eye(size) + 0.3 * random.standard_normal((size, size)) / np.sqrt(size)
    right = random.standard_normal((size, 1))
    found, iterations = gmres(lambda x, out: np.matmul(matrix, x, out=out), right, 1e-10, size)
    assert np.abs(found - np.linalg.solve(matrix, right)).max() < 1e-9
    assert 1 <= iterations <= size


def test_gmres_of_nothing():
    found, iterations = gmres(lambda x, out: np.copyto(out, x), np.zeros(3), 0.0, 5)
    assert (found.tolist(), iterations) == ([0.0, 0.0, 0.0], 0)


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
        assert other.summary.delta_x == pytest.approx(one.summary.delta_x, rel=1e-4, abs=1e-10)


def test_strong_friction_needs_it(monkeypatch):
    """Sliding with friction times Dundurs' constant of 5, which taking turns drives apart."""
    parts = {
        "bodies": RIGID,
        "friction": 10.0,
        "grid": {"points": 24, "size": 3.0},
        "load_path": [{"P": LOAD, "increments": 2}, {"delta_x": 1.0, "increments": 1}],
    }
    last = list(run(build(**parts)))[-1]
    assert last.summary.Qx == pytest.approx(10.0 * LOAD, rel=1e-5)
    assert last.summary.worst_residual <= 1e-6
    monkeypatch.setattr(fretsolve.alternation, "solve_jointly", lambda *arguments: None)
    with pytest.raises(NotConvergedError, match=r"Dundurs' constant is 10 x 0\.5"):
        list(run(build(**parts)))
