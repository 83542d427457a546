from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretsolve.problem.model.grid import Grid, HalfGrid

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


def test_single_cell_lies_at_the_centre():
    grid = Grid.from_size((1, 1), (0.3, 0.7), (2.0, 3.0))
    assert grid.x.tolist() == [2.0] and grid.y.tolist() == [3.0]
    assert grid.cell_area == pytest.approx(0.21)


def test_grid_and_its_arrays_cannot_be_changed():
    grid = Grid.from_size((4, 4), (1.0, 1.0))
    with pytest.raises(ValueError, match="read-only"):
        grid.x[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        grid.nx = 5  # type: ignore[misc]
    assert grid == Grid(4, 4, 0.25, 0.25)


@pytest.mark.parametrize(
    ("points", "size"), [((0, 4), (1.0, 1.0)), ((4, 4), (0.0, 1.0)), ((4, 4), (1.0, float("inf")))]
)
def test_empty_or_degenerate_grid_is_refused(points, size):
    with pytest.raises(ValueError, match=r"grid needs|cell sides"):
        Grid.from_size(points, size)


def test_farthest_coordinate():
    assert Grid(4, 2, 1.0, 1.0).farthest == 1.5
    assert Grid(4, 2, 1.0, 1.0, 3.0, -7.0).farthest == 7.5


@given(st.integers(1, 100), st.integers(1, 100), lengths, lengths)
def test_one_half_of_a_grid(nx, columns, width, height):
    whole = Grid.from_size((nx, 2 * columns), (width, height), (0.1, 0.0))
    half = HalfGrid.of(whole)
    assert half.shape == (nx, columns)
    assert half.whole_shape == whole.whole_shape == whole.shape
    assert half.size == pytest.approx(whole.size)
    assert np.array_equal(half.x, whole.x)
    assert half.y == pytest.approx(whole.y[columns:], rel=1e-14)
    assert half.cell_area == 2.0 * whole.cell_area
    assert half.farthest == pytest.approx(whole.farthest)
    part = half.part(1, max(columns // 2, 1), (half.dx, half.dy), (0.0, 0.0))
    assert np.array_equal(part.y, half.y[: part.ny])
