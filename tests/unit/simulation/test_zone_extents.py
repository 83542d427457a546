"""Widths and middles of contact and stick zone: circles, ellipses, one row of cells, and where no smooth edge is."""

from __future__ import annotations

import numpy as np
import pytest
from solving import FRICTION, HERTZ, LOAD, MATERIAL, A, grid_of, solve, solve_last
from test_zone_areas import UNIT, line_contact
from zones import contact_size

from fretsolve.contact.zones.area_contact import Extent, ZoneSize, _farthest, zone_sizes
from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.problem.model.grid import Grid
from fretsolve.reference.hertz import hertz_elliptic
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.result.state import Zone

SHEARED = [{"P": LOAD}, {"Qx": 25.0, "increments": 1}]
C = cattaneo_mindlin(HERTZ, FRICTION, 25.0, MATERIAL.tangential).stick_radius


def extents(summary, zone):
    return np.array([getattr(summary, f"{zone}_{name}") for name in Extent._fields])


@pytest.mark.parametrize("points", [16, 32, 64])
@pytest.mark.parametrize("center", [(0.0, 0.0), (0.0037, -0.0021), (0.001, 0.0063)])
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
    for place in np.linspace(0.0, 0.95, 10):
        exact = 1.0 + place * cell
        fields = [np.repeat(field[:, None], rows, axis=1) for field in line_contact(exact, cell, offset=0.37)]
        grid = Grid(len(fields[0]), rows, cell, 0.1, 0.37 * cell, 0.5)
        if axis == 1:
            fields, grid = [field.T.copy() for field in fields], Grid(rows, grid.nx, 0.1, cell, 0.5, 0.37 * cell)
        half_x, half_y, x, y = contact_size(*fields, grid, UNIT).extent
        along, across = ((half_x, x), (half_y, y)) if axis == 0 else ((half_y, y), (half_x, x))
        assert along == pytest.approx((exact, 0.0), abs=5e-3 * cell)
        assert across == pytest.approx((0.05 * rows, 0.5))


def test_sharp_edges_are_where_the_cells_end():
    parts = {"surface": {"punch": {"half_width": 0.2}}, "grid": {"points": 40, "size": 0.6}}
    found = extents(solve_last(**parts).summary, "contact")
    assert found == pytest.approx([0.195, 0.195, 0.0, 0.0], abs=1e-9)


def test_a_zone_that_does_not_exist():
    slipping = solve_last(grid={"points": 16}, load_path=[{"P": LOAD}, {"delta_x": 0.01, "increments": 1}]).summary
    assert slipping.contact_half_width_x > 0.0
    assert (slipping.stick_half_width_x, slipping.stick_half_width_y) == (0.0, 0.0)
    assert np.isnan([slipping.stick_center_x, slipping.stick_center_y]).all()
    grid, nothing = Grid(6, 5, 0.1, 0.1), np.zeros((6, 5))
    assert contact_size(nothing, nothing + 1.0, grid, MATERIAL) == ZoneSize()


def test_mirrored_fields_have_mirrored_extents():
    parts = {"grid": {"points": [32, 40], "size": 0.76, "center": [0.013, -0.007]}}
    *_, start, state = solve(**parts, load_path=[{"P": LOAD}, {"Qx": 20.0, "My": 12.0, "increments": 1}])
    fields, grid = state.fields, grid_of(**parts)
    slip = fields.slip - start.fields.slip
    arrays = fields.pressure, fields.gap, fields.shear, FRICTION * fields.pressure, slip, fields.zone, start.fields.slip
    assert (fields.zone == Zone.SLIP).any()

    def extent(arrays, grid):
        return zone_sizes(ZoneFields(*arrays), grid, MATERIAL)[1].extent

    half_x, half_y, x, y = extent(arrays, grid)
    mirrored = Grid(grid.nx, grid.ny, grid.dx, grid.dy, -grid.x0, grid.y0)
    flipped = [np.flip(array, -2) for array in arrays]
    assert extent(flipped, mirrored) == pytest.approx((half_x, half_y, -x, y), rel=1e-9)
    turned = [np.swapaxes(array[::-1] if array.ndim == 3 else array, -1, -2) for array in arrays]
    swapped = Grid(grid.ny, grid.nx, grid.dy, grid.dx, grid.y0, grid.x0)
    assert extent(turned, swapped) == pytest.approx((half_y, half_x, y, x), rel=1e-9)


def test_rounding_does_not_decide_between_rows_that_end_alike():
    ends = np.full((4, 9), -np.inf)
    ends[:, 2:7] = 0.2, 0.5, 0.3, 0.5, 0.45
    ends[1, 3] += 1e-15
    ends[2, 5] += 1e-15
    vertex = 0.5 + 0.15**2 / (8 * 0.25)  # that of the second one is farther
    np.testing.assert_allclose(_farthest(ends), vertex, rtol=1e-12)
