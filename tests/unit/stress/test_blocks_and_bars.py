"""Fields averaged over blocks of cells, and the bounds of the largest stress on them."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.stress.edge import in_blocks, merged
from fretsolve.stress.peaks import SurfaceBounds


def test_blocks_that_fit() -> None:
    field = np.arange(24.0).reshape(4, 6)
    means = in_blocks(field, (2, 3), (0, 0), (2, 2))
    assert means.tolist() == [[4.0, 7.0], [16.0, 19.0]]


def test_cells_past_the_field_count_as_zero() -> None:
    means = in_blocks(np.ones((3, 2)), (2, 2), (1, 0), (2, 1))
    assert means.tolist() == [[0.5], [1.0]]


@pytest.mark.parametrize("shift", [(0, 0), (1, 2)])
def test_the_sum_is_kept(shift) -> None:
    field = np.random.default_rng(5).normal(size=(5, 7))
    assert in_blocks(field, (3, 4), shift, (3, 3)).sum() * 12 == pytest.approx(field.sum())


def test_blocks_of_a_window_cover_it() -> None:
    assert merged((slice(3, 8), slice(0, 5)), (2, 5)) == (slice(1, 4), slice(0, 1))


def test_largest_bound_away_from_a_place() -> None:
    bounds = SurfaceBounds(np.array([9.0, 7.0, 5.0]), np.array([[0.0, 2.0, 9.0], [0.0, 0.0, 3.0]]), 0.5)
    here = np.array([0.0, 0.0])
    assert bounds.most() == 9.0
    assert [bounds.most(here, distance) for distance in (1.0, 2.0, 9.0)] == [7.0, 5.0, -np.inf]
