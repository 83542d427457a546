"""Coefficients of stress against quadrature of the point solutions (Johnson 3.19 and 3.75), which use no potentials."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.stress.influence import COMPONENTS, TRACTIONS, is_odd, potential, stress_terms


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


@pytest.mark.parametrize(("component", "loaded"), [("zz", "p"), ("xz", "qx"), ("yz", "qy")])
def test_the_surface_carries_the_tractions(component, loaded):
    """At z = 0 under the cell zz = -p, xz = -qx, yz = -qy, and none of the three beside it."""
    for traction in TRACTIONS:
        for x, inside in ((0.1, True), (0.8, False)):
            found = coefficient(component, traction, (x, 0.2, 0.0), 0.3, (1.0, 1.0))
            expected = -1.0 if inside and loaded == traction else 0.0
            assert found == pytest.approx(expected, abs=1e-15)


def test_equilibrium_below_a_cell():
    """The divergence of the stress by central differences falls sixteenfold with half the step (order 4)."""
    at, nu, cell = (0.4, -0.3, 0.5), 0.28, (1.0, 0.7)

    def divergence(traction, row, step):
        names = {"x": ("xx", "xy", "xz"), "y": ("xy", "yy", "yz"), "z": ("xz", "yz", "zz")}[row]
        total = 0.0
        for axis, name in enumerate(names):
            for shift, weight in ((1, 8.0), (2, -1.0)):
                for sign in (1.0, -1.0):
                    beside = np.array(at) + sign * shift * step * np.eye(3)[axis]
                    total += sign * weight * coefficient(name, traction, beside, nu, cell) / (12.0 * step)
        return abs(total)

    for traction in TRACTIONS:
        for row in "xyz":
            coarse, fine = divergence(traction, row, 0.04), divergence(traction, row, 0.02)
            assert fine < 2e-5
            assert fine < coarse / 14.0 or fine < 1e-10


@pytest.mark.parametrize("name", ["Vz", "Lxx", "Lxy", "Vx", "Vy", "Vxx", "Vyy", "Vxy", "Vxz", "Vyz"])
def test_parity(name):
    x, y = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]), np.array([-1.0, 0.0, 1.0])
    values = potential(name, x, y, 0.4, 1.0, 1.0)
    np.testing.assert_allclose(values[::-1], -values if is_odd(name, "x") else values, rtol=0, atol=1e-14)
    np.testing.assert_allclose(values[:, ::-1], -values if is_odd(name, "y") else values, rtol=0, atol=1e-14)


def test_body_1_is_the_mirror_of_body_2():
    """Under the same pressure both have the same stress but for the sign of xz and yz; shear acts the other way."""
    where = (0.4, -0.3, 0.5), 0.28, (1.0, 0.7)
    for component in COMPONENTS:
        mirrored = -1.0 if component in ("xz", "yz") else 1.0
        for traction in TRACTIONS:
            sign = mirrored if traction == "p" else -mirrored
            found = coefficient(component, traction, *where, body=1)
            assert found == pytest.approx(sign * coefficient(component, traction, *where), abs=1e-16)
