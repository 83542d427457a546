from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretsolve.problem.model.grid import Grid

counts = st.integers(1, 300)
lengths = st.floats(1e-6, 1e3)


def test_cells_fill_the_area():
    grid = Grid.from_size((4, 3), (2.0, 6.0), (1.0, -1.0))
    assert grid.shape == (4, 3)
    assert (grid.dx, grid.dy) == (0.5, 2.0)
    assert grid.cell_area == 1.0
    assert grid.size == (2.0, 6.0)
    assert grid.center == (1.0, -1.0)
    np.testing.assert_allclose(grid.x, [0.25, 0.75, 1.25, 1.75])
    np.testing.assert_allclose(grid.y, [-3.0, -1.0, 1.0])


@given(counts, counts, lengths, lengths)
def test_centres_about_the_origin_are_antisymmetric_to_the_last_bit(nx, ny, lx, ly):
    grid = Grid.from_size((nx, ny), (lx, ly))
    assert grid.x.shape == (nx,) and grid.y.shape == (ny,)
    np.testing.assert_array_equal(grid.x, -grid.x[::-1])
    np.testing.assert_array_equal(grid.y, -grid.y[::-1])
    assert np.all(np.diff(grid.x) > 0)


@pytest.mark.parametrize(
    ("points", "size"), [((0, 4), (1.0, 1.0)), ((4, 4), (0.0, 1.0)), ((4, 4), (1.0, float("inf")))]
)
def test_empty_or_degenerate_grid_is_refused(points, size):
    with pytest.raises(ValueError, match=r"grid needs|cell sides"):
        Grid.from_size(points, size)
