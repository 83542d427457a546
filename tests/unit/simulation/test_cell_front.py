"""The cells around a zone and the links that its edge crosses."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.model.grid import Grid, LineGrid
from fretsolve.simulation.zones.cell_front import MARGIN_CELLS, CellPart, Front

GRID = Grid(12, 10, 0.1, 0.2, 1.0, -2.0)


def zone_of(rows: slice, columns: slice, grid: Grid = GRID) -> np.ndarray:
    zone = np.zeros(grid.shape, bool)
    zone[rows, columns] = True
    return zone


def test_a_zone_in_the_middle():
    grid = Grid(30, 20, 0.1, 0.2)
    part = CellPart.around(zone_of(slice(10, 14), slice(8, 11), grid), grid)
    assert part.width == 3 + 2 * MARGIN_CELLS
    assert part.inside.size == (4 + 2 * MARGIN_CELLS) * part.width
    assert part.corner == pytest.approx((grid.x[10 - MARGIN_CELLS], grid.y[8 - MARGIN_CELLS]))
    assert (part.inside.sum(), part.deep.sum()) == (12, 2)
    assert not part.is_row


def test_past_the_border_of_the_grid_cells_have_another_value():
    part = CellPart.around(zone_of(slice(0, 3), slice(8, 10)), GRID)
    assert part.missing == ((MARGIN_CELLS, 0), (0, MARGIN_CELLS))
    assert part.corner == pytest.approx((GRID.x[0] - MARGIN_CELLS * 0.1, GRID.y[8 - MARGIN_CELLS]))
    field = np.arange(120.0).reshape(GRID.shape)
    cut = part.cut(field, -1.0).reshape(-1, part.width)
    assert (cut[:MARGIN_CELLS] == -1.0).all() and (cut[:, -MARGIN_CELLS:] == -1.0).all()
    assert cut[MARGIN_CELLS, :-MARGIN_CELLS].tolist() == field[0, 8 - MARGIN_CELLS :].tolist()


def test_a_rectangle_crosses_a_link_per_cell_of_its_sides():
    part = CellPart.around(zone_of(slice(4, 9), slice(3, 6)), GRID)
    front = Front.of(part)
    # each link across the edge belongs to two squares
    assert (front.links.inner.size, front.links.along_y.sum()) == (2 * 2 * (5 + 3), 2 * 2 * 5)
    assert part.inside[front.links.inner].all() and not part.inside[front.links.outer].any()
    assert np.unique(front.links.length[front.links.along_y]).tolist() == [0.2]
    assert sorted(front.count.tolist()) == [1] * 4 + [2] * (2 * (4 + 2))
    assert front.whole == 4 * 2
    assert not front.opposite.any()


def test_two_cells_that_touch_at_a_corner():
    zone = zone_of(slice(5, 6), slice(4, 5)) | zone_of(slice(6, 7), slice(5, 6))
    front = Front.of(CellPart.around(zone, GRID))
    assert front.count[front.opposite].tolist() == [2]
    assert front.whole == 0


def test_shares_replace_those_of_crossed_links():
    front = Front.of(CellPart.around(zone_of(slice(4, 9), slice(3, 6)), GRID))
    shares = front.shares(np.full(front.count.size, 0.5), lambda lever: lever / 2.0)
    assert np.unique(shares).tolist() == [0.0, 0.25, 1.0]
    assert (shares == 0.25).sum() == front.links.inner.size


def test_a_line_has_neighbours_along_x_alone():
    grid = LineGrid.of_length(9, 9.0, 0.0)
    part = CellPart.around(zone_of(slice(3, 6), slice(0, 1), grid), grid)
    assert part.is_row
    assert part.deep.sum() == 1
