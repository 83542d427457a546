"""Coefficients of stress against quadrature of the point solutions, and layers by convolution against direct sums."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from command_line import result_of
from small_cases import LOOP, write_case

from fretsolve import open_result
from fretsolve.errors import CaseError
from fretsolve.post.stress import request as requests
from fretsolve.post.stress.influence import COMPONENTS, TRACTIONS, point_influence, potential, stress_terms
from fretsolve.post.stress.layers import LayerConvolution
from fretsolve.post.stress.request import disk_problem, layers, memory_problem, stress_request
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.model.grid import Grid


def coefficient(component, traction, at, nu, cell, body=2):
    x, y, z = at
    terms = stress_terms(component, traction, z, nu, body)
    offsets = np.array([x]), np.array([y])
    return sum(factor * potential(name, *offsets, z, *cell)[0, 0] for name, factor in terms.items())


def normal_force(component, x, y, z, nu):
    """Boussinesq: a unit force along +z at the origin."""
    rho, r2, e = np.sqrt(x * x + y * y + z * z), x * x + y * y, 1 - 2 * nu
    values = {
        "xx": e / r2 * ((1 - z / rho) * (x * x - y * y) / r2 + z * y * y / rho**3) - 3 * z * x * x / rho**5,
        "yy": e / r2 * ((1 - z / rho) * (y * y - x * x) / r2 + z * x * x / rho**3) - 3 * z * y * y / rho**5,
        "zz": -3 * z**3 / rho**5,
        "xy": e / r2 * ((1 - z / rho) * 2 * x * y / r2 - x * y * z / rho**3) - 3 * x * y * z / rho**5,
        "xz": -3 * x * z**2 / rho**5,
        "yz": -3 * y * z**2 / rho**5,
    }
    return values[component] / (2 * math.pi)


def tangential_force(component, x, y, z, nu):
    """Cerruti: a unit force along +x at the origin."""
    rho, e = np.sqrt(x * x + y * y + z * z), 1 - 2 * nu
    s = rho + z
    values = {
        "xx": -3 * x**3 / rho**5
        + e * (x / rho**3 - 3 * x / (rho * s**2) + x**3 / (rho**3 * s**2) + 2 * x**3 / (rho**2 * s**3)),
        "yy": -3 * x * y**2 / rho**5
        + e * (x / rho**3 - x / (rho * s**2) + x * y**2 / (rho**3 * s**2) + 2 * x * y**2 / (rho**2 * s**3)),
        "zz": -3 * x * z**2 / rho**5,
        "xy": -3 * x**2 * y / rho**5
        + e * (-y / (rho * s**2) + x**2 * y / (rho**3 * s**2) + 2 * x**2 * y / (rho**2 * s**3)),
        "xz": -3 * x**2 * z / rho**5,
        "yz": -3 * x * y * z / rho**5,
    }
    return values[component] / (2 * math.pi)


def point_solution(component, traction, x, y, z, nu):
    if traction == "p":
        return normal_force(component, x, y, z, nu)
    if traction == "qx":
        return tangential_force(component, x, y, z, nu)
    swapped = {"xx": "yy", "yy": "xx", "xz": "yz", "yz": "xz"}.get(component, component)
    return tangential_force(swapped, y, x, z, nu)


@pytest.mark.parametrize("traction", TRACTIONS)
@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize(("dx", "dy"), [(0.01, 0.01), (0.02, 0.013)])
def test_coefficients_are_the_integrals_of_the_point_solutions(component, traction, dx, dy):
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for nu in (0.0, 0.3, 0.5):
        for x, y, z in [(0.031, -0.017, 0.02), (-0.021, 0.05, 0.0), (0.003, 0.002, 0.03), (0.3, 0.2, 0.1)]:
            x, y, z = x * dx / 0.01, y * dx / 0.01, z * dx / 0.01
            from_x, from_y = x - 0.5 * dx * nodes[:, None], y - 0.5 * dy * nodes[None, :]
            values = point_solution(component, traction, from_x, from_y, z, nu)
            exact = 0.25 * dx * dy * float(weights @ values @ weights)
            scale = dx * dy / (x * x + y * y + z * z)
            assert coefficient(component, traction, (x, y, z), nu, (dx, dy)) == pytest.approx(exact, abs=3e-12 * scale)


GRID = Grid(13, 10, 0.02, 0.03, 0.01, -0.02)
WHOLE = slice(0, 13), slice(0, 10)
WINDOWS = [(WHOLE, WHOLE), ((slice(3, 9), slice(2, 7)), WHOLE), (WHOLE, (slice(4, 13), slice(6, 7)))]
WINDOWS.append(((slice(8, 12), slice(1, 4)), (slice(0, 3), slice(5, 10))))


def random_tractions(source, seed=1):
    values = np.random.default_rng(seed).normal(size=(3, *GRID.shape))
    inside = np.zeros(GRID.shape)
    inside[source] = 1.0
    return dict(zip(("p", "qx", "qy"), values * inside, strict=True))


@pytest.mark.parametrize(("source", "target"), WINDOWS)
@pytest.mark.parametrize("depth", [0.0, 0.01, 0.2])
@pytest.mark.parametrize("body", [1, 2])
def test_convolution_is_the_direct_sum(source, target, depth, body):
    """To rounding, for all cells of several windows."""
    tractions, nu = random_tractions(source), 0.27
    layer = LayerConvolution((GRID.dx, GRID.dy), source, target)
    kernels = layer.kernels(layer.potentials(depth, {body: nu}), depth, nu, body)
    found = layer.stress(kernels, layer.forward({name: field[source] for name, field in tractions.items()}))
    cells = [(i, j) for i in range(*target[0].indices(99)) for j in range(*target[1].indices(99))]
    for i, j in cells[:: max(1, len(cells) // 12)]:
        exact = point_influence(GRID, (GRID.x[i], GRID.y[j], depth), nu, body).stress(tractions)
        np.testing.assert_allclose(found[:, i - target[0].start, j - target[1].start], exact, rtol=0, atol=1e-13)


def test_groups_of_increments_give_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the spectra of all increments do not fit, they are computed in groups."""
    with open_result(result_of(write_case(tmp_path, LOOP))) as result:
        tractions = TractionHistory(result)
        request = stress_request(tractions, result.steps, bodies=(1, 2), depths=(0.0, 0.05))
        assert request.group == len(result.steps)
        whole = {(one.body, one.depth_index, one.step_index): one.stress for one in layers(tractions, request)}
        monkeypatch.setattr(requests, "SPECTRA_BYTES", 1)
        assert request.group == 1
        parts = {(one.body, one.depth_index, one.step_index): one.stress for one in layers(tractions, request)}
        assert whole.keys() == parts.keys()
        for key, stress in whole.items():
            np.testing.assert_array_equal(parts[key], stress)
        assert "fewer depths or increments" in str(disk_problem(request, 100))
        assert disk_problem(request, None) is None
        assert memory_problem(request, 1) is None
        with pytest.raises(CaseError, match="the depth -1 mm is not one"):
            stress_request(tractions, result.steps, depths=(-1.0,))
