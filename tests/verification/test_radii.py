"""Contact and stick radii within cells: their errors and order, against counted cells."""

from __future__ import annotations

import numpy as np
import pytest
from solving import FRICTION, HERTZ, LOAD, MATERIAL, A, grid_of, solve
from zones import contact_area, stick_area

from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.reference.tangential import cattaneo_mindlin, lubkin
from fretsolve.result.state import Zone

POINTS = (32, 64, 128)
PLACES = [(size, center) for size in (0.68, 0.6993, 0.7226, 0.74, 0.77) for center in ([0.0, 0.0], [0.0037, -0.0021])]
"""Sizes of the grid and its centres. Errors are root mean squares over them: they fluctuate with how the circles cut
the cells."""
SHEAR_FORCE, TORQUE = 36.0, 5.0
MINDLIN = cattaneo_mindlin(HERTZ, FRICTION, SHEAR_FORCE, MATERIAL.tangential)
CERTIFIED_STICK_RADIUS = 0.139761
"""Of mode I with all tangential coefficients, by counting the cells of a 256 x 256 grid."""


def radius(area):
    return np.sqrt(area / np.pi)


def radii(state, before, grid):
    """Contact and stick radius from the fields of one increment, and both by counting cells."""
    fields = state.fields
    slip = fields.slip - before.fields.slip
    contact = contact_area(fields.pressure, fields.gap, grid, MATERIAL)
    limit = FRICTION * fields.pressure
    parts = ZoneFields(fields.pressure, fields.gap, fields.shear, limit, slip, fields.zone, before.fields.slip)
    stick = stick_area(parts, grid, MATERIAL, contact)
    counts = np.count_nonzero(fields.zone != Zone.OPEN), np.count_nonzero(fields.zone == Zone.STICK)
    return radius(np.array([contact, stick, *(count * grid.cell_area for count in counts)]))


def solved_radii(path, **parts):
    """Of the last increment of a load path."""
    *_, before, state = solve(load_path=path, **parts)
    return radii(state, before, grid_of(**parts))


@pytest.fixture(scope="module")
def mode_one():
    """Relative errors (points, 4) of the radii of mode I without cross influence, where the closed forms are exact."""
    path = [{"P": LOAD}, {"Qx": SHEAR_FORCE, "increments": 1}]
    exact = np.array([A, MINDLIN.stick_radius] * 2)
    grids = [[{"points": n, "size": size, "center": center} for size, center in PLACES] for n in POINTS]
    found = [[solved_radii(path, grid=grid, coupling="none") / exact - 1.0 for grid in level] for level in grids]
    return np.sqrt(np.mean(np.square(found), axis=1))


class TestModeOne:
    def test_errors_are_within_bounds(self, mode_one):
        """The bounds are twice what is found."""
        contact, stick = mode_one[:, 0], mode_one[:, 1]
        assert (contact < [4e-4, 1.2e-4, 5e-5]).all()
        assert (stick < [3e-3, 5e-4, 2e-4]).all()

    def test_order_of_convergence(self, mode_one):
        order = -np.polyfit(np.log(POINTS), np.log(mode_one), 1)[0]
        assert (order[:2] > [1.3, 1.7]).all()
        assert (order[:2] > order[2:] + 0.4).all()

    @pytest.mark.parametrize("points", [64, 128])
    def test_certified_radius_with_cross_influence(self, points):
        """A count on the finest grid, which is about a tenth of its cells (0.2 %) too large."""
        path = [{"P": LOAD}, {"Qx": SHEAR_FORCE, "increments": 1}]
        found = solved_radii(path, grid={"points": points, "size": 0.7226}, coupling="tangential")
        assert found[1] == pytest.approx(CERTIFIED_STICK_RADIUS, rel=3e-3)

    @pytest.mark.parametrize("increments", [1, 6])
    @pytest.mark.parametrize("points", [47])
    @pytest.mark.parametrize("force", [16.0, 30.0])
    def test_cycles_between_the_same_forces(self, points, force, increments):
        """The stick zone is the same at each turn, in one increment or several."""
        path = [{"P": LOAD}, *({"Qx": turn, "increments": increments} for turn in (force, -force, force))]
        states = solve(load_path=path, grid={"points": points, "size": 0.74}, coupling="none")
        exact = cattaneo_mindlin(HERTZ, FRICTION, force, MATERIAL.tangential).stick_radius
        found = [state.summary.stick_radius for state in states[increments::increments]]
        assert found == pytest.approx([exact] * 3, abs=0.02 * 0.74 / points)


def test_torsion():
    """Here the front runs along the slip."""
    exact = lubkin(HERTZ, FRICTION, TORQUE, MATERIAL.torsional).stick_radius
    for points in POINTS:
        path = [{"P": LOAD}, {"Mz": TORQUE, "increments": 1}]
        found = solved_radii(path, grid={"points": points, "size": 0.7226})
        assert found[1] == pytest.approx(exact, rel=2e-3)
