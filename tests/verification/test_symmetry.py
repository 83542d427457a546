"""Solutions are the same however a case lies on the grid, in any units, and with either body called the first.

Solutions are compared to what the solver's tolerance leaves open, TOLERANCE times a margin for how residuals
(of gap and slip) turn into tractions, which is largest in the slip zone's outermost cells.
"""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, FRICTION, HERTZ, LOAD, RADIUS, SWAPPED, grid_of, solve, solve_last

TOLERANCE = 1e-9
FIELDS = 1e-5
"""Tractions over the largest pressure."""

BASE = {"bodies": DISSIMILAR, "solver": {"tolerance": TOLERANCE}}
OBLIQUE = [{"P": LOAD, "Mx": 4.0, "My": 9.0, "increments": 2}, {"Qx": 20.0, "Qy": 9.0, "Mz": 1.5, "increments": 2}]
SURFACE = {"ellipsoid": {"radius_x": 9.0, "radius_y": 14.0, "angle": 0.4}}


def close(found, exact, scale=HERTZ.max_pressure, tolerance=FIELDS):
    return float(np.abs(found - exact).max()) <= tolerance * scale


def test_quarter_turn():
    """(x, y) -> (-y, x): Qx, Qy, Mx, My become -Qy, Qx, My, -Mx; rows become columns."""
    turned_path = [
        {"P": LOAD, "Mx": 9.0, "My": -4.0, "increments": 2},
        {"Qx": -9.0, "Qy": 20.0, "Mz": 1.5, "increments": 2},
    ]
    turned_surface = {"ellipsoid": SURFACE["ellipsoid"] | {"angle": 0.4 + np.pi / 2}}
    here = solve_last(**BASE, grid={"points": [40, 36], "size": [0.76, 0.80]}, surface=SURFACE, load_path=OBLIQUE)
    there = solve_last(
        **BASE, grid={"points": [36, 40], "size": [0.80, 0.76]}, surface=turned_surface, load_path=turned_path
    )

    def turned(field):  # value at (x, y) from the one at (-y, x)
        return field[::-1, :].T

    assert close(turned(there.fields.pressure), here.fields.pressure)
    assert close(turned(there.fields.shear[1]), here.fields.shear[0])
    assert close(-turned(there.fields.shear[0]), here.fields.shear[1])
    assert there.summary.delta_y == pytest.approx(here.summary.delta_x, rel=1e-6)
    assert there.summary.phi_z == pytest.approx(here.summary.phi_z, rel=1e-6)


def test_oblique_load_agrees_with_load_along_the_axis():
    """The direction of the load against the grid costs less than the grid itself, and vanishes like it."""
    angle = np.radians(30.0)
    points, differences, across = (16, 32, 64), [], []
    for count in points:
        parts = {"grid": {"points": count, "size": 0.74}, "solver": {"tolerance": 1e-8}}
        straight = solve_last(**parts, load_path=[{"P": LOAD}, {"Qx": 36.0, "increments": 1}])
        force = {"Qx": 36.0 * np.cos(angle), "Qy": 36.0 * np.sin(angle)}
        turned = solve_last(**parts, load_path=[{"P": LOAD}, force | {"increments": 1}])
        dx, dy, reference = turned.summary.delta_x, turned.summary.delta_y, straight.summary.delta_x
        differences.append(abs(np.cos(angle) * dx + np.sin(angle) * dy - reference) / reference)
        across.append(abs(np.cos(angle) * dy - np.sin(angle) * dx) / reference)
        assert turned.summary.stick_area == pytest.approx(
            straight.summary.stick_area, abs=4 * straight.summary.stick_radius * 0.74 / count
        )
        assert turned.summary.work_total == pytest.approx(straight.summary.work_total, rel=20 / count**2)
    assert differences[-1] < 1e-5
    assert across[-1] < 1e-5
    assert -np.polyfit(np.log(points), np.log(np.hypot(differences, across)), 1)[0] > 1.3


class TestSwappedBodies:
    """The coupling C changes sign: p(C, q) = p(-C, -q), so turning all shears round undoes the swap."""

    def test_indentation(self):
        """Mode II: the same pressure and a shear that points the other way, inward on the flat where C > 0."""
        parts = {"grid": {"points": 40}, "load_path": [{"P": LOAD, "increments": 4}], "solver": BASE["solver"]}
        here, there = solve_last(bodies=DISSIMILAR, **parts), solve_last(bodies=SWAPPED, **parts)
        assert close(there.fields.pressure, here.fields.pressure)
        assert close(there.fields.shear, -here.fields.shear)
        grid = grid_of(**parts)
        outward = here.fields.shear[0] * grid.x[:, None] + here.fields.shear[1] * grid.y[None, :]
        assert outward.sum() < 0.0
        assert outward.max() <= 1e-6 * np.abs(outward).max()


class TestMovedAside:
    CELL = 0.02
    PARTS = {"grid": {"points": 48, "size": 0.96}, "solver": {"tolerance": 1e-10}}  # noqa: RUF012

    def test_both_moments(self):
        arms = np.array([2, -4]) * self.CELL
        central = solve_last(**self.PARTS)
        moments = {"My": LOAD * arms[0], "Mx": LOAD * arms[1]}
        tilted = solve_last(**self.PARTS, load_path=[{"P": LOAD, **moments}])
        assert close(np.roll(central.fields.pressure, (2, -4), axis=(0, 1)), tilted.fields.pressure, tolerance=1e-7)
        assert (tilted.summary.phi_y, tilted.summary.phi_x) == pytest.approx(tuple(arms / RADIUS), rel=1e-8)

    def test_surface_and_grid_moved_together(self):
        here = solve_last(**self.PARTS, load_path=[{"P": LOAD}, {"Mz": 3.0, "increments": 1}])
        there = solve_last(
            surface={"sphere": {"radius": RADIUS, "center": [0.5, -0.3]}},
            grid={"points": 48, "size": 0.96, "center": [0.5, -0.3]},
            solver=self.PARTS["solver"],
            load_path=[{"P": LOAD, "phi_x": 0.0}, {"Mz": 3.0, "Qx": 0.0, "Qy": 0.0, "increments": 1}],
        )
        assert close(there.fields.pressure, here.fields.pressure, tolerance=1e-7)
        assert close(there.fields.shear, here.fields.shear, tolerance=1e-6)
        assert there.summary.phi_z == pytest.approx(here.summary.phi_z, rel=1e-8)
        # the turn is about the origin: what it moves at the contact's centre, delta_x and delta_y take back
        assert there.summary.delta_x == pytest.approx(-0.3 * here.summary.phi_z, rel=1e-6)
        assert there.summary.delta_y == pytest.approx(-0.5 * here.summary.phi_z, rel=1e-6)


def test_force_and_displacement_control_find_the_same_state():
    """The displacements that a path of forces gives, imposed instead, give its forces back."""
    parts = BASE | {"grid": {"points": 32, "size": 0.78}}
    path = [{"P": LOAD, "My": 6.0, "increments": 2}, {"Qx": 20.0, "Qy": -8.0, "Mz": 2.0, "increments": 2}]
    forced = solve(**parts, load_path=path)
    names = ("delta_z", "phi_x", "phi_y", "delta_x", "delta_y", "phi_z")
    moves = [{name: getattr(state.summary, name) for name in names} | {"increments": 1} for state in forced]
    moved = solve(**parts, load_path=moves)
    for here, there in zip(forced, moved, strict=True):
        assert close(there.fields.pressure, here.fields.pressure)
        assert close(there.fields.shear, here.fields.shear)
        for load, scale in (("P", LOAD), ("Qx", FRICTION * LOAD), ("Qy", FRICTION * LOAD), ("Mz", 7.0), ("My", 6.0)):
            assert getattr(there.summary, load) == pytest.approx(getattr(here.summary, load), abs=1e-5 * scale)
