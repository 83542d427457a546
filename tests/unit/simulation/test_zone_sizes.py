"""Areas, widths and middles of contact and stick zone within cells: against exact fronts, and where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solving import FRICTION, HERTZ, LOAD, MATERIAL, A, grid_of, solve_last
from zones import contact_area, contact_size, stick_area

from fretsolve.contact.zones.area_contact import Extent, ZoneSize
from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.materials import Compliances
from fretsolve.reference.hertz import hertz_elliptic
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.result.state import Zone

UNIT = Compliances(A=2.0, B=0.0, C=0.0)
"""A contact modulus of 1."""


def contact_of(state, grid, materials=MATERIAL):
    return contact_area(state.fields.pressure, state.fields.gap, grid, materials)


def counted(cells, grid):
    return np.count_nonzero(cells) * grid.cell_area


def line_contact(half_width, cell, offset):
    """Pressure and gap (n,) of a cylinder of radius 1 on a half-plane, E* = 1, under Hertz's load for `half_width`.

    Constant pressure per cell and gap at its centre, as in the solver; the cells in contact are found by trial.
    """
    cells = int(np.ceil(1.4 * half_width / cell))
    x = (np.arange(-cells, cells + 1) + offset) * cell
    apart = x[:, None] - x
    ends = apart - 0.5 * cell, apart + 0.5 * cell
    below, above = (end * np.log(np.abs(end)) - end for end in ends)
    influence = 2.0 / np.pi * (below - above)
    active, before = np.abs(x) < half_width, np.zeros(x.size, dtype=bool)
    while (active != before).any():
        system = np.zeros((x.size + 1, x.size + 1))
        system[:-1, :-1] = np.where(active[:, None], influence, np.eye(x.size))
        system[:-1, -1], system[-1, :-1] = -1.0 * active, cell
        load = 0.25 * np.pi * half_width**2
        *pressure, approach = np.linalg.solve(system, np.append(np.where(active, -0.5 * x**2, 0.0), load))
        gap = 0.5 * x**2 + influence @ pressure - approach
        before, active = active, np.where(active, np.array(pressure) > 0.0, gap < -1e-13)
    return np.array(pressure), np.where(active, 0.0, gap)


SHEARED = [{"P": LOAD}, {"Qx": 25.0, "increments": 1}]
C = cattaneo_mindlin(HERTZ, FRICTION, 25.0, MATERIAL.tangential).stick_radius


def extents(summary, zone):
    return np.array([getattr(summary, f"{zone}_{name}") for name in Extent._fields])


@pytest.mark.parametrize("axis", [0, 1])
def test_area_of_a_straight_front(axis):
    """Over all places of the front within a cell. What it has of the border is counted, and taken out here."""
    cell = 1.0 / 40
    for place in np.linspace(0.0, 0.95, 6):
        exact = 1.0 + place * cell
        fields = line_contact(exact, cell, offset=0.37)
        areas = []
        for length in (10, 20):
            pressure, gap = (np.repeat(field[:, None], length, axis=1) for field in fields)
            if axis == 1:
                pressure, gap = pressure.T.copy(), gap.T.copy()
            areas.append(contact_area(pressure, gap, Grid(*pressure.shape, cell, cell), UNIT))
        half_width = (areas[1] - areas[0]) / (10 * cell) / 2.0
        assert half_width == pytest.approx(exact, abs=5e-3 * cell)


@pytest.mark.parametrize("radii", [(20.0, 10.0), (40.0, 8.0), (100.0, 6.0)])
@pytest.mark.parametrize("angle", [0.0, 0.3, 0.8])
def test_areas_of_ellipses(radii, angle):
    a, b = hertz_elliptic(LOAD, *radii, MATERIAL.contact_modulus).semi_axes
    surface = {"ellipsoid": {"radius_x": radii[0], "radius_y": radii[1], "angle": angle}}
    parts = {"surface": surface, "grid": {"points": 64, "size": 2.3 * a}}
    state, grid = solve_last(**parts, load_path=[{"P": LOAD}]), grid_of(**parts)
    found = contact_of(state, grid)
    assert found == pytest.approx(np.pi * a * b, rel=1.2e-2 * grid.dx / b)  # b is 4.5 to 17.5 cells
    assert counted(state.fields.pressure, grid) > found


def test_area_of_a_ring(tmp_path):
    """A torus on a flat: the ring has two fronts, one of them turning the other way."""
    areas = []
    for points in (64, 128):
        side = (np.arange(points + 2) - (points + 1) / 2) * 1.2 / points
        np.save(tmp_path / "map.npy", 0.05 * (np.hypot(side[:, None], side) - 0.4) ** 2)
        surface = {"heights": {"file": str(tmp_path / "map.npy"), "spacing": 1.2 / points}}
        parts = {"surface": surface, "grid": {"points": points, "size": 1.2}}
        state, grid = solve_last(**parts, load_path=[{"P": LOAD}]), grid_of(**parts)
        areas.append((contact_of(state, grid), counted(state.fields.pressure, grid)))
    assert areas[0][0] == pytest.approx(areas[1][0], rel=1e-3)
    assert areas[0][1] > 1.01 * areas[0][0]


@pytest.mark.parametrize("punch", [{"radius": 0.2}, {"half_width": 0.2}])
def test_a_sharp_edge_is_where_the_cells_are(punch):
    parts = {"surface": {"punch": punch}, "grid": {"points": 40, "size": 0.6}}
    state, grid = solve_last(**parts), grid_of(**parts)
    assert contact_of(state, grid) == pytest.approx(counted(state.fields.pressure, grid), rel=1e-12)
    if "half_width" in punch:
        assert extents(state.summary, "contact") == pytest.approx([0.195, 0.195, 0.0, 0.0], abs=1e-9)


@given(data=st.data())
@settings(max_examples=60, deadline=None)
def test_whatever_the_fields(data):
    """Finite areas, the stick zone's no larger than the contact's, and that no larger than the grid."""
    shape = data.draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    random = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    pressure = np.maximum(random.standard_normal(shape) + data.draw(st.floats(-1.0, 2.0)), 0.0)
    gap = np.where(pressure > 0.0, 0.0, random.choice([0.0, 1e-9, 1e-3, np.inf], shape))
    zone = np.where(pressure > 0.0, random.integers(1, 3, shape), 0).astype(np.uint8)
    bound = FRICTION * pressure
    shear = np.where(zone == Zone.SLIP, 1.0, random.random(shape)) * np.stack([bound, 0.0 * bound])
    slip = random.choice([0.0, 1e-9, 1e-5, 1.0], (2, *shape)) * (zone == Zone.SLIP)
    before = random.choice([-1.0, -0.8, -0.5, 0.0, 1.0], (2, *shape)) * slip
    before += random.choice([0.0, 1e-9, 1e-5], (2, *shape))
    grid = Grid(*shape, 0.1, 0.1 * data.draw(st.floats(0.1, 10.0)))
    contact = contact_area(pressure, gap, grid, MATERIAL)
    stick = stick_area(ZoneFields(pressure, gap, shear, bound, slip, zone, before), grid, MATERIAL, contact)
    assert 0.0 <= stick <= contact <= grid.nx * grid.ny * grid.cell_area * (1.0 + 1e-12)
    assert (contact > 0.0) == pressure.any()


@pytest.mark.parametrize(("points", "center"), [(16, (0.001, 0.0063)), (32, (0.0037, -0.0021)), (64, (0.0, 0.0))])
def test_circles_to_a_thirtieth_of_a_cell(points, center):
    grid = {"points": points, "size": 0.7226, "center": list(center)}
    summary = solve_last(grid=grid, coupling="none", load_path=SHEARED).summary
    for zone, radius in (("contact", A), ("stick", C)):
        assert extents(summary, zone) == pytest.approx([radius, radius, 0.0, 0.0], abs=0.7226 / points / 30.0)


def test_an_ellipse_off_the_origin():
    surface = {"ellipsoid": {"radius_x": 20.0, "radius_y": 10.0, "center": [0.05, -0.02]}}
    parts = {"surface": surface, "grid": {"points": 64, "size": 1.0}}
    semi_axes = hertz_elliptic(LOAD, 20.0, 10.0, MATERIAL.contact_modulus).semi_axes
    found = extents(solve_last(**parts).summary, "contact")
    assert found == pytest.approx([*semi_axes, 0.05, -0.02], abs=0.02 * grid_of(**parts).dx)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("rows", [1, 12])
def test_rows_of_cells(axis, rows):
    """A line contact on any number of rows: its edge is where it is on many; across, the rows are counted."""
    cell = 1.0 / 40
    for place in np.linspace(0.0, 0.95, 5):
        exact = 1.0 + place * cell
        fields = [np.repeat(field[:, None], rows, axis=1) for field in line_contact(exact, cell, offset=0.37)]
        grid = Grid(len(fields[0]), rows, cell, 0.1, 0.37 * cell, 0.5)
        if axis == 1:
            fields, grid = [field.T.copy() for field in fields], Grid(rows, grid.nx, 0.1, cell, 0.5, 0.37 * cell)
        half_x, half_y, x, y = contact_size(*fields, grid, UNIT).extent
        along, across = ((half_x, x), (half_y, y)) if axis == 0 else ((half_y, y), (half_x, x))
        assert along == pytest.approx((exact, 0.0), abs=5e-3 * cell)
        assert across == pytest.approx((0.05 * rows, 0.5))


def test_a_zone_that_does_not_exist():
    slipping = solve_last(grid={"points": 16}, load_path=[{"P": LOAD}, {"delta_x": 0.01, "increments": 1}]).summary
    assert slipping.contact_half_width_x > 0.0
    assert (slipping.stick_half_width_x, slipping.stick_half_width_y) == (0.0, 0.0)
    assert np.isnan([slipping.stick_center_x, slipping.stick_center_y]).all()
    grid, nothing = Grid(6, 5, 0.1, 0.1), np.zeros((6, 5))
    assert contact_size(nothing, nothing + 1.0, grid, MATERIAL) == ZoneSize()
