"""Stresses below a sphere that is pressed on and slides: closed forms, certified values, and how they converge.

The certified values are p = sqrt(1 - r^2), q = mu p along x on body 2, with radius and largest pressure 1, by an
independent evaluation of the exact solution in all digits given. Tractions here are means over cells.
"""

from __future__ import annotations

import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from solving import build

from fretsolve.post.stress.edge import EdgeExtrapolation
from fretsolve.post.stress.influence import point_influence
from fretsolve.post.stress.invariants import von_mises
from fretsolve.post.stress.layers import LayerConvolution
from fretsolve.post.stress.peaks import PeakSearch
from fretsolve.post.stress.request import layers, stress_request
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.model.grid import Grid
from fretsolve.result import HistoryWriter, open_result
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header, solve_missing

POINTS = [
    (0.30, 0.0, (0, 0, 0.48), (-0.19270, -0.19270, -0.81274, 0, 0, 0), 0.62004),
    (0.30, 0.0, (-0.5, 0.25, 0.3), (-0.26315, -0.26107, -0.72471, 0.00139, 0.13385, -0.06693), 0.53028),
    (0.30, 0.1, (-0.5, 0.25, 0.3), (-0.22386, -0.25411, -0.71132, -0.00676, 0.09711, -0.06569), 0.51494),
    (0.30, 0.4, (-0.5, 0.25, 0.3), (-0.10599, -0.23322, -0.67117, -0.03120, -0.01313, -0.06198), 0.52789),
    (0.30, 0.4, (0.6, 0, 0.1), (-0.76726, -0.54532, -0.81332, 0, -0.31145, 0), 0.59381),
    (0.30, 0.4, (-1.1, 0.2, 0.05), (0.33930, -0.05754, 0.00284, -0.05422, -0.02316, 0.00236), 0.38420),
    (0.42, 0.0, (-0.5, 0.25, 0.3), (-0.32573, -0.31377, -0.72471, 0.00797, 0.13385, -0.06693), 0.48112),
    (0.42, 0.1, (-0.5, 0.25, 0.3), (-0.28505, -0.30269, -0.71132, 0.00046, 0.09711, -0.06569), 0.46447),
    (0.42, 0.4, (-0.5, 0.25, 0.3), (-0.16303, -0.26944, -0.67117, -0.02207, -0.01313, -0.06198), 0.47850),
    (0.42, 0.4, (0.6, 0, 0.1), (-0.86802, -0.64081, -0.81332, 0, -0.31145, 0), 0.57723),
    (0.42, 0.4, (-1.1, 0.2, 0.05), (0.29787, 0.01017, 0.00284, -0.03675, -0.02316, 0.00236), 0.30102),
]
TENSION_AT_EDGE = {(0.30, 0.0): 0.13333, (0.30, 0.1): 0.30219, (0.30, 0.4): 0.80878, (0.42, 0.4): 0.74763}


@cache
def mean_pressure(cells):
    """Return the mean pressure in cells, of which the radius has `cells`."""
    half, parts = math.ceil(1.3 * cells), 16
    fine = ((np.arange(2 * half * parts) + 0.5) / parts - half) / cells
    pressure = np.sqrt(np.maximum(0.0, 1.0 - fine[:, None] ** 2 - fine**2))
    return pressure.reshape(2 * half, parts, 2 * half, parts).mean(axis=(1, 3))


def sphere(cells, mu, direction=(1.0, 0.0)):
    """Return a grid with `cells` per radius and mean tractions in its cells."""
    pressure = mean_pressure(cells)
    grid = Grid(*pressure.shape, 1.0 / cells, 1.0 / cells)
    return grid, {"p": pressure, "qx": mu * direction[0] * pressure, "qy": mu * direction[1] * pressure}


def at_point(cells, point, nu, mu):
    grid, tractions = sphere(cells, mu)
    return point_influence(grid, point, nu, 2).stress(tractions)


def layer(grid, tractions, depth, nu, body=2):
    whole = slice(0, grid.nx), slice(0, grid.ny)
    convolution = LayerConvolution((grid.dx, grid.dy), whole, whole)
    kernels = convolution.kernels(convolution.potentials(depth, {body: nu}), depth, nu, body)
    return convolution.stress(kernels, convolution.forward(tractions))


@pytest.mark.parametrize(("nu", "mu", "point", "components", "mises"), POINTS)
def test_certified_points_with_order_two(nu, mu, point, components, mises):
    """On 80 cells per radius all agree to 1e-4 of the largest pressure; the values have five digits."""
    found = {cells: at_point(cells, point, nu, mu) for cells in (10, 20, 40, 80)}
    np.testing.assert_allclose(found[80], components, rtol=0, atol=1.1e-4)
    assert von_mises(found[80][:, None])[0] == pytest.approx(mises, abs=1.1e-4)
    errors = [np.abs(found[cells] - components).max() for cells in (10, 20, 40)]
    assert errors[2] < 6.5e-4
    # The error of a point varies a little with its place in a cell, so that of two halvings is judged.
    assert errors[2] < errors[0] / 10.0


@pytest.mark.parametrize(("nu", "of_yy"), [(0.3, 3.0e-3), (0.42, 4.2e-3)])
def test_closed_forms_on_the_surface(nu, of_yy):
    """Hertz and full sliding at r < 0.9 on 40 cells per radius, where errors are largest near the edge.

    Certified there for nu = 0.3: 8.6e-3, 2.6e-3, 3.6e-4, 4.4e-3, 1.4e-4, 0, for another place of the grid.
    """
    mu = 0.4
    grid, tractions = sphere(40, mu)
    x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
    r2 = x * x + y * y
    inside = r2 < 0.9**2
    x, y, r2 = x[inside], y[inside], r2[inside]
    w = np.sqrt(1.0 - r2)
    radial = (1.0 - 2.0 * nu) / 3.0 / r2 * (1.0 - w**3)
    rr, tt = radial - w, -radial - 2.0 * nu * w
    share = -math.pi * mu / 8.0
    exact = [
        (rr * x * x + tt * y * y) / r2 + share * (4.0 + nu) * x,
        (rr * y * y + tt * x * x) / r2 + share * 3.0 * nu * x,
        -w,
        (rr - tt) * x * y / r2 + share * (2.0 - nu) * y,
        -mu * w,
        np.zeros_like(w),
    ]
    found = layer(grid, tractions, 0.0, nu)[:, inside]
    worst = np.abs(found - exact).max(axis=1)
    assert (worst < [9.5e-3, of_yy, 3.8e-4, 4.6e-3, 1.5e-4, 1e-14]).all()


@pytest.mark.parametrize("cells", [20, 40, pytest.param(80, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("nu", "mu"), TENSION_AT_EDGE)
def test_tension_at_the_trailing_edge(nu, mu, cells):
    """The largest tension of cells is far too small; the extrapolated one is within its error bar."""
    grid, tractions = sphere(cells, mu)
    whole = slice(0, grid.nx), slice(0, grid.ny)
    extrapolation = EdgeExtrapolation(grid, whole, whole, {2: nu}, ("p", "qx") if mu else ("p",))
    found = extrapolation.estimates(tractions, {2: np.zeros(3)})[2, "tension"]
    exact = TENSION_AT_EDGE[nu, mu]
    assert abs(found.value - exact) < found.error
    assert found.error < 0.12 * exact
    if cells >= 40 and mu == 0.4:
        assert found.value == pytest.approx(exact, rel=1e-2)


def test_tension_of_body_1_lies_at_the_other_edge():
    """Body 1 slides along +x: the tension of body 2 is behind it, its own in front. Tractions are continuous."""
    grid, tractions = sphere(20, 0.4)
    first, second = (layer(grid, tractions, 0.0, 0.3, body) for body in (1, 2))
    np.testing.assert_allclose(first[0], second[0][::-1], rtol=0, atol=1e-13)
    assert grid.x[second[0].max(axis=1).argmax()] == pytest.approx(-1.0, abs=0.06)
    np.testing.assert_allclose(first[[2, 4, 5]], second[[2, 4, 5]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(second[4], -tractions["qx"], rtol=0, atol=1e-14)


@pytest.mark.parametrize("points", [48, pytest.param(64, marks=pytest.mark.slow)])
def test_largest_stresses_of_a_solved_contact_are_within_their_error_bars(tmp_path, points):
    """A sphere about to slide, mu = 0.4: tension 0.80878 p0 and von Mises 0.80479 p0 at the trailing edge."""
    case = build(
        grid={"points": points, "size": 0.9},
        friction=0.4,
        coupling="none",
        load_path=[{"P": 400.0}, {"Qx": 159.9, "increments": 1}],
    )
    setup = set_up(case)
    out = tmp_path / "case.h5"
    with HistoryWriter.open(out, run_header(setup, 1, ())) as writer:
        solve_missing(setup, writer, SimpleNamespace(requested=False))
    with open_result(out) as result:
        tractions = TractionHistory(result)
        request = stress_request(tractions, [1], bodies=(1, 2))
        search = PeakSearch(tractions, request)
        for one in layers(tractions, request):
            search.add(one)
        p0 = float(result.history["max_pressure"][1])
        for (body, name), (peak,) in search.peaks().items():
            if name in ("tension", "mises"):
                exact = 0.80878 if name == "tension" else 0.80479
                assert peak.at_edge
                # The value is off by up to 9 %, by how the grid cuts the edge, so that no bar of a tenth would do. Its
                # factor is the one with which bars hold on varied contacts (docs/verification.md): found 20 and 21 %.
                assert abs(peak.value - exact * p0) < peak.error < 0.22 * exact * p0
                assert peak.x == pytest.approx(0.3 if body == 1 else -0.3, abs=0.03)
