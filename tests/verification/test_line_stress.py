"""Stresses below a line contact in plane strain: closed forms of McEwen and of full sliding, with a = p0 = 1."""

from __future__ import annotations

import math

import numpy as np
import pytest
from command_line import invoke

from fretsolve.post.stress.edge import EdgeExtrapolation
from fretsolve.post.stress.influence import point_influence
from fretsolve.post.stress.layers import LayerConvolution
from fretsolve.post.stress.stress_file import read_peaks
from fretsolve.problem.model.grid import Grid

CERTIFIED = [
    ((-0.5, 0.3), (-0.451585, -0.809578, 0.140230), (0.537391, 0.140230, -0.451585)),
    ((0.9, 0.1), (-0.364448, -0.404131, -0.155080), (-1.273242, -0.155080, -0.364448)),
]
"""(x, z); xx, zz, xz from p = sqrt(1 - x^2); the same from q = sqrt(1 - x^2)."""

NU = 0.3


def cylinder(cells, mu, margin=1.5):
    half = math.ceil(margin * cells)
    edges = np.clip((np.arange(2 * half + 1) - half) / cells, -1.0, 1.0)
    pressure = np.diff(0.5 * (edges * np.sqrt(1.0 - edges**2) + np.arcsin(edges))) * cells
    grid = Grid(2 * half, 1, 1.0 / cells, 1.0 / cells)
    return grid, {"p": pressure[:, None], "qx": mu * pressure[:, None], "qy": 0.2 * mu * pressure[:, None]}


def layer(grid, tractions, depth, body=2):
    whole = slice(0, grid.nx), slice(0, 1)
    convolution = LayerConvolution((grid.dx, grid.dy), whole, whole, plane_strain=True)
    kernels = convolution.kernels(convolution.potentials(depth, {body: NU}), depth, NU, body)
    return convolution.stress(kernels, convolution.forward(tractions))


def at_point(cells, point, pressed, mu):
    grid, tractions = cylinder(cells, 1.0)
    tractions = {"p": pressed * tractions["p"], "qx": mu * tractions["qx"], "qy": 0.0 * tractions["qy"]}
    return point_influence(grid, (point[0], 0.0, point[1]), NU, 2, plane_strain=True).stress(tractions)


@pytest.mark.parametrize(("point", "from_p", "from_q"), CERTIFIED)
def test_certified_points_with_order_two(point, from_p, from_q):
    for pressed, mu, exact in ((1.0, 0.0, from_p), (0.0, 1.0, from_q)):
        errors = []
        for cells in (20, 40, 80, 160):
            stress = at_point(cells, point, pressed, mu)
            errors.append(np.abs(stress[[0, 2, 4]] - exact).max())
            assert stress[1] == pytest.approx(NU * (stress[0] + stress[2]), rel=1e-12)  # plane strain
        assert errors[-1] < 5e-5
        assert errors[-1] < errors[0] / 40.0


def test_full_sliding_on_the_surface():
    """xx = -p - 2 mu x inside, and the tension 2 mu p0 at the trailing edge by extrapolation."""
    mu = 0.4
    grid, tractions = cylinder(160, mu)
    found, x = layer(grid, tractions, 0.0)[:, :, 0], grid.x
    inside = np.abs(x) < 0.9
    exact = -np.sqrt(1.0 - x[inside] ** 2) - 2.0 * mu * x[inside]
    np.testing.assert_allclose(found[0][inside], exact, rtol=0, atol=3e-3)  # largest near the edge
    np.testing.assert_allclose(found[2], -tractions["p"][:, 0], atol=1e-14)
    np.testing.assert_allclose(found[4], -tractions["qx"][:, 0], atol=1e-14)
    np.testing.assert_allclose(found[5], -tractions["qy"][:, 0], atol=1e-14)
    for cells in (20, 40, 80):
        grid, tractions = cylinder(cells, mu)
        whole = slice(0, grid.nx), slice(0, 1)
        extrapolation = EdgeExtrapolation(grid, whole, whole, {2: NU}, ("p", "qx"), plane_strain=True)
        tractions["qy"][:] = 0.0
        found = extrapolation.estimates(tractions, {2: np.zeros(3)})[2, "tension"]
        assert abs(found.value - 2.0 * mu) < found.error
        assert found.value == pytest.approx(2.0 * mu, rel=6e-2)


@pytest.mark.parametrize("body", [1, 2])
@pytest.mark.parametrize("depth", [0.0, 0.3])
def test_convolution_is_the_direct_sum(depth, body):
    grid, tractions = cylinder(8, 0.4)
    found = layer(grid, tractions, depth, body)
    for i in range(0, grid.nx, 5):
        exact = point_influence(grid, (grid.x[i], 0.0, depth), NU, body, plane_strain=True).stress(tractions)
        np.testing.assert_allclose(found[:, i, 0], exact, rtol=0, atol=1e-13)


def test_a_long_row_of_rectangles_is_a_strip():
    """The coefficients of a strip are those of a cell that is 1e4 times as long as wide."""
    x = np.array([-1.0, 0.0, 1.0, 2.0])
    for depth in (0.0, 0.4):
        for traction in ("p", "qx", "qy"):
            field = {"p": np.zeros((4, 1)), "qx": np.zeros((4, 1)), "qy": np.zeros((4, 1))}
            field[traction][1] = 1.0
            strip = Grid(4, 1, 1.0, 1.0, 0.5)
            long = Grid(4, 1, 1.0, 1e4, 0.5)
            for at in x:
                exact = point_influence(long, (at, 0.0, depth), NU, 2).stress(field)
                found = point_influence(strip, (at, 0.0, depth), NU, 2, plane_strain=True).stress(field)
                np.testing.assert_allclose(found, exact, rtol=0, atol=2e-4)


@pytest.mark.parametrize("points", [48, 64, pytest.param(128, marks=pytest.mark.slow)])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_largest_tension_of_a_solved_contact_under_bulk_stress(tmp_path, sign, points):
    """At the trailing edge, also where bulk stress compresses it; exact by Hills and Nowell's eccentric stick zone."""
    case = tmp_path / "case.yaml"
    steel = "{young_modulus: 200 GPa, poisson_ratio: 0.3}"
    case.write_text(
        f"plane: strain\nbodies: [{steel}, {steel}]\nsurface: {{cylinder: {{radius: 10 mm}}}}\n"
        f"grid: {{points: {points}}}\nfriction: 0.3\noutput: {{stress: {{depths: [0 mm]}}}}\n"
        f"load_path: [{{P: 100}}, {{Qx: {sign * 18}, bulk_2: {{xx: {sign * 141.944}}}, increments: 4}}]\n"
    )
    assert invoke("run", case, "-q").exit_code == 0
    value, error = read_peaks(tmp_path / "case.stress.h5")["max_tension"][4]
    # In half-widths: stick zone of half-width c about e = 0.2, at a distance of X from the trailing edge.
    c, X = math.sqrt(0.4), 1.0 + sign * 0.2
    exact = 2.0 * 0.3 * 591.4314 * (1.0 - X + math.sqrt(X * X - c * c)) + sign * 141.944
    assert abs(value - exact) < error < 0.6 * exact + 40.0
