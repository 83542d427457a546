from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.elastic import influence, thread_team
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.materials import Compliances

INTEGRANDS = {
    "inverse_distance": lambda x, y: 1.0 / np.hypot(x, y),
    "along_x": lambda x, y: x * x / np.hypot(x, y) ** 3,
    "along_y": lambda x, y: y * y / np.hypot(x, y) ** 3,
    "across": lambda x, y: x * y / np.hypot(x, y) ** 3,
    "radial_x": lambda x, y: x / (x * x + y * y),
    "radial_y": lambda x, y: y / (x * x + y * y),
}
NAMES = list(INTEGRANDS)


CELLS = [(1, 0), (0, 1), (3, 2), (13, 5), (29, 29), (0, 40), (350, 200)]


def at(name, x, y, dx, dy):
    return float(getattr(influence, name)(np.array([x]), np.array([y]), dx, dy)[0, 0])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("i", "j", "dx", "dy"),
    [
        *((*cell, 0.01, 0.01) for cell in CELLS),
        *((*cell, 0.02, 0.013) for cell in CELLS),
        *((*cell, 0.1, 0.01) for cell in CELLS[2:]),  # the quadrature below needs more points beside slender cells
    ],
)
def test_integrals_over_cells_beside_the_point(name, i, j, dx, dy):
    """By Gauss quadrature with 40 points per side; every method of integration is met, near and far."""
    x, y = i * dx, j * dy
    nodes, weights = np.polynomial.legendre.leggauss(40)
    values = INTEGRANDS[name](x + 0.5 * dx * nodes[:, None], y + 0.5 * dy * nodes[None, :])
    exact = 0.25 * dx * dy * float(weights @ values @ weights)
    largest = 4e-12 * max(dx, dy) / min(dx, dy) * dx * dy / math.hypot(x, y)
    assert at(name, x, y, dx, dy) == pytest.approx(exact, rel=0.0, abs=largest)


def test_the_cell_itself():
    """4 h ln(1 + sqrt 2) for a square of side h; the odd integrals vanish."""
    h = 0.37
    assert at("inverse_distance", 0.0, 0.0, h, h) == pytest.approx(4 * h * math.log(1 + math.sqrt(2)), rel=1e-14)
    assert at("along_x", 0.0, 0.0, h, h) == pytest.approx(2 * h * math.log(1 + math.sqrt(2)), rel=1e-14)
    for name in ("across", "radial_x", "radial_y"):
        assert at(name, 0.0, 0.0, h, h) == pytest.approx(0.0, abs=1e-15)


def test_far_away_nothing_is_lost():
    """Corner differences would have lost six digits here."""
    far = np.array([1000.0])
    assert at("inverse_distance", 1000.0, 0.0, 1.0, 1.0) == pytest.approx(1e-3 * (1 + 1 / 24e6), rel=1e-12)
    assert influence.inverse_distance(far, far, 1.0, 1.0)[0, 0] == pytest.approx(1e-3 / math.sqrt(2), rel=1e-7)


@pytest.mark.parametrize("name", ["zz", "yy", "xz", "yz"])
def test_parts_of_large_grids_are_those_of_the_whole(name, monkeypatch):
    """Corners between two parts are rounded on either side, which moves near coefficients by a few roundings."""
    problem = (name, (90, 40), (0.01, 0.013), Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6))
    whole = influence.influence_coefficients(*problem)
    monkeypatch.setattr(thread_team, "parts_of", lambda shape: [(0, 7), (7, 50), (50, 90)])
    in_parts = [influence.influence_coefficients(*problem, ThreadTeam(count)) for count in (1, 2)]
    np.testing.assert_array_equal(*in_parts)
    np.testing.assert_allclose(in_parts[0], whole, rtol=1e-11)
