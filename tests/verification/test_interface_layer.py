"""A layer between the bodies against a certified solve, its limits, and contacts without it; errors fall with the grid.

Bodies with nu = 0, for which the axisymmetric solution is exact. D = delta_x E'/(mu p0 a), E' = 2/(1/G1 + 1/G2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from line_cases import FRICTION as LINE_FRICTION
from line_cases import HERTZ as LINE_HERTZ
from line_cases import solve_line
from scipy.optimize import brentq
from solving import DISSIMILAR, FRICTION, LOAD, NO_POISSON, RADIUS, SIMILAR, solve

from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.layered import layered_stick_compliance
from fretsolve.result.state import Summary

MODULUS = 1e5
"""E' and E* (MPa)."""

SPHERE = hertz_sphere(LOAD, RADIUS, MODULUS)
A, P0, LIMIT = SPHERE.contact_radius, SPHERE.max_pressure, FRICTION * LOAD
UNIT = FRICTION * P0 * A / MODULUS
SHARES = (0.5, 0.9)
CERTIFIED = {0.5: ((0.757686, 0.88396), (1.587442, 0.57548)), 1.0: ((0.932632, 0.90423), (1.948503, 0.60871))}
"""D and c/a at SHARES of mu P, by L E'/a."""


def layer(share: float) -> dict[str, float]:
    """Return a layer with this L E'/a."""
    return {"shear_compliance": share * A / MODULUS}


def at_shares(share: float, points: int) -> list[tuple[float, float]]:
    """Return D and c/a at SHARES of mu P."""
    path = [{"P": LOAD}, *({"Qx": part * LIMIT, "increments": 1} for part in SHARES)]
    states = solve(bodies=NO_POISSON, grid={"points": points}, load_path=path, interface=layer(share))
    return [(state.summary.delta_x / UNIT, state.summary.stick_radius / A) for state in states[-2:]]


@pytest.mark.parametrize("share", CERTIFIED)
def test_displacement_and_stick_radius_under_a_force(share: float) -> None:
    """On 128 points 6e-5 and 2.2e-4 off at most; three grids show the orders 2 of D and 1.7 of c/a about."""
    errors = []
    for points in (32, 64, 128):
        found = np.array(at_shares(share, points))
        errors.append(np.abs(found / np.array(CERTIFIED[share]) - 1.0).max(axis=0))
    moved, stick = np.array(errors).T
    assert moved[-1] <= 1e-4 and stick[-1] <= 3e-4
    assert moved[1] <= moved[0] / 2.0 and moved[2] <= moved[0] / 8.0
    assert stick[1] <= stick[0] / 2.0 and stick[2] <= stick[0] / 8.0


def test_force_under_a_displacement() -> None:
    """The force at the certified displacements, and none lost on the way to gross slip."""
    path = [{"P": LOAD}, *({"delta_x": moved * UNIT, "increments": 1} for moved, _ in CERTIFIED[1.0])]
    onset = 0.1875 * 4.0 / MODULUS * LIMIT / A * 1.0 + A / MODULUS * FRICTION * P0
    path += [{"delta_x": 0.9995 * onset, "increments": 1}, {"delta_x": 1.001 * onset, "increments": 1}]
    found = [
        state.summary
        for state in solve(bodies=NO_POISSON, grid={"points": 128}, load_path=path, interface=layer(1.0))[1:]
    ]
    for share, summary in zip(SHARES, found, strict=False):
        assert summary.Qx == pytest.approx(share * LIMIT, rel=1e-4)
    assert 0.0 < found[-2].stick_radius < 0.06 * A
    assert found[-1].stick_cells == 0 and found[-1].Qx == pytest.approx(LIMIT)


def test_the_way_back_is_twice_the_first_loading() -> None:
    path = [{"P": LOAD}, *({"Qx": part * LIMIT, "increments": 1} for part in (0.9, -0.1, -0.9, 0.9))]
    states = solve(bodies=NO_POISSON, grid={"points": 64}, load_path=path, interface=layer(1.0))
    (half, c_half), (most, c_most) = at_shares(1.0, 64)
    moved = [state.summary.delta_x / UNIT for state in states[1:]]
    assert moved == pytest.approx([most, most - 2.0 * half, -most, most], abs=2e-6)
    radii = [state.summary.stick_radius / A for state in states[1:]]
    assert radii == pytest.approx([c_most, c_half, c_most, c_most], rel=1e-4)


def test_just_after_a_reversal_the_contact_sticks_on_the_layer() -> None:
    """All cells stick, whose area is off by 7e-4 on 128 points and by 7e-3 on 64; that is 1.8e-3 without a layer."""
    for share in (0.5, 1.0, 10.0):
        path = [{"P": LOAD}, {"Qx": 0.9 * LIMIT, "increments": 1}, {"Qx": 0.899 * LIMIT, "increments": 1}]
        before, after = (
            state.summary
            for state in solve(bodies=NO_POISSON, grid={"points": 128}, load_path=path, interface=layer(share))[-2:]
        )
        found = (before.delta_x - after.delta_x) / (0.001 * LIMIT)
        assert found == pytest.approx(layered_stick_compliance(A, 4.0 / MODULUS, share * A / MODULUS), rel=2e-3)


def test_a_very_compliant_layer_is_a_bed_of_springs() -> None:
    """Q/(mu P) = (3 k - k^3)/2 and c/a = sqrt(1 - k^2) with k = delta_x/(L mu p0); the bodies add 1e-4."""
    for (moved, stick), part in zip(at_shares(1e4, 128), SHARES, strict=True):
        k = brentq(lambda k, part=part: (3.0 * k - k**3) / 2.0 - part, 0.0, 1.0)
        assert moved == pytest.approx(1e4 * k, rel=5e-4)
        assert stick == pytest.approx(math.sqrt(1.0 - k * k), rel=2e-4)


def test_a_bed_of_springs_under_a_cylinder() -> None:
    """q = mu p0 min(sqrt(1 - x^2/a^2), k), k = sqrt(1 - c^2/a^2)."""
    limit = LINE_FRICTION * LINE_HERTZ.load
    path = [{"P": LINE_HERTZ.load}, *({"Qx": part * limit, "increments": 1} for part in SHARES)]
    states = solve_line(grid={"points": 257}, load_path=path, interface={"shear_compliance": 1e-2})
    for state, part in zip(states[-2:], SHARES, strict=True):

        def excess(c: float, part: float = part) -> float:
            k = math.sqrt(1.0 - c * c)
            return (k * c + math.asin(k)) * 2.0 / math.pi - part

        c = brentq(excess, 0.0, 1.0)
        assert state.summary.stick_radius / LINE_HERTZ.half_width == pytest.approx(c, rel=3e-4)


def pressed(points: int, compliance: float) -> Summary:
    """Return a sphere pressed on a layer with this normal compliance (mm/MPa), 0 for none."""
    more: dict[str, Any] = {"interface": {"normal_compliance": compliance}} if compliance else {}
    return solve(bodies=NO_POISSON, grid={"points": points, "size": 0.8}, **more)[-1].summary


def test_a_thin_layer_lets_the_bodies_approach_by_half_its_largest_compression() -> None:
    """The layer has the energy L int p^2/2 = pi L a^2 p0^2/4, whose derivative by P is L p0/2; line: 2 L p0/pi."""
    compliance = 1e-2 * A / MODULUS
    change = pressed(128, compliance).delta_z - pressed(128, 0.0).delta_z
    assert change == pytest.approx(compliance * P0 / 2.0, rel=0.01)
    compliance = 2e-3 * LINE_HERTZ.half_width / 1.1e5
    plain, layered = (
        solve_line(grid={"points": 257, "size": 0.3}, reference_depth=10.0, load_path=[{"P": LINE_HERTZ.load}], **more)
        for more in ({}, {"interface": {"normal_compliance": compliance}})
    )
    change = layered[-1].summary.delta_z - plain[-1].summary.delta_z
    assert change == pytest.approx(2.0 * compliance * LINE_HERTZ.max_pressure / math.pi, rel=0.02)


@pytest.mark.parametrize("share", [1.0, 1e4])
def test_pressure_on_a_layer_converges_with_the_grid(share: float) -> None:
    """At L = 1e4 a/E* a bed of springs: pi R d^2 = P L, p0 = d/L, and the bodies add 1e-3 of d."""
    compliance, found = share * A / MODULUS, []
    for points in (32, 64, 128):
        summary = solve(bodies=NO_POISSON, grid={"points": points}, interface={"normal_compliance": compliance})[-1]
        found.append([getattr(summary.summary, name) for name in ("delta_z", "contact_radius", "max_pressure")])
    coarse, middle, fine = np.array(found)
    assert (np.abs(middle / fine - 1.0) <= [2e-4, 6e-4, 2.5e-3]).all()
    assert (np.abs(fine - middle) <= 0.5 * np.abs(fine - coarse)).all()
    if share == 1e4:
        d = math.sqrt(LOAD * compliance / (math.pi * RADIUS))
        assert fine == pytest.approx([d, math.sqrt(2.0 * RADIUS * d), d / compliance], rel=1.2e-3)


@pytest.mark.parametrize(
    ("bodies", "stage"),
    [
        (SIMILAR, {"Qx": 0.8 * LIMIT}),
        (DISSIMILAR, {"Qx": 0.6 * LIMIT}),
        (DISSIMILAR, {"P": 2.0 * LOAD}),
        (DISSIMILAR, {"Mz": 4.0}),
    ],
    ids=["mode I", "mode I of unlike bodies", "mode II", "mode III"],
)
def test_a_layer_makes_no_solution_dearer(bodies: Any, stage: dict[str, float]) -> None:
    """From a hundredth of the bodies' compliance to a million times as much."""
    path = [{"P": LOAD, "increments": 2}, {**stage, "increments": 3}]
    common: dict[str, Any] = {"bodies": bodies, "grid": {"points": 32}, "load_path": path}

    def applications(**more: Any) -> int:
        return sum(state.summary.operator_applications for state in solve(**common, **more))

    bare = applications()
    for share in (1e-2, 1.0, 1e2, 1e6):
        assert applications(interface=layer(share)) <= 1.02 * bare
    both = {**layer(1e2), "normal_compliance": 1e3 * A / MODULUS}
    assert applications(interface=both) <= 1.02 * bare
