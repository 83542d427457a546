from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fretsolve.contact.increment.active_region import FREE_CELLS, ActiveRegion, region_around


def contact(shape, rows, columns):
    mask = np.zeros(shape, dtype=bool)
    mask[slice(*rows), slice(*columns)] = True
    return mask


@given(st.data())
def test_the_region_holds_the_contact_with_free_cells(data):
    shape = data.draw(st.tuples(st.integers(1, 200), st.integers(1, 200)))
    low, high = (sorted(data.draw(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)))) for n in shape)
    rows, columns = (low[0], low[1] + 1), (high[0], high[1] + 1)
    mask = contact(shape, rows, columns)
    region = region_around(mask)
    assert region.holds(mask)
    for span, extent, points in zip((region.rows, region.columns), (rows, columns), shape, strict=True):
        assert 0 <= span[0] < span[1] <= points
        assert extent[0] - span[0] >= min(FREE_CELLS, extent[0])
        assert span[1] - extent[1] >= min(FREE_CELLS, points - extent[1])


def test_without_contact_and_with_a_large_one_it_is_the_grid():
    assert region_around(np.zeros((40, 30), dtype=bool)) == ActiveRegion((0, 40), (0, 30))
    assert region_around(contact((40, 40), (2, 38), (2, 38))) == ActiveRegion((0, 40), (0, 40))


def test_contact_at_an_inner_edge_is_not_held():
    region = ActiveRegion((10, 30), (0, 20))
    assert region.holds(contact((40, 40), (12, 28), (0, 18)))
    assert not region.holds(contact((40, 40), (10, 28), (0, 18)))
    assert not region.holds(contact((40, 40), (12, 30), (0, 18)))
    assert not region.holds(contact((40, 40), (12, 28), (0, 20)))
    assert region.holds(np.zeros((40, 40), dtype=bool))


@given(st.data())
def test_the_region_of_one_half_begins_in_the_middle(data):
    shape = data.draw(st.tuples(st.integers(1, 200), st.integers(1, 100)))
    low, high = (sorted(data.draw(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)))) for n in shape)
    mask = contact(shape, (low[0], low[1] + 1), (high[0], high[1] + 1))
    region = region_around(mask, mirrored=True)
    assert region.holds(mask)
    assert region.columns[0] == 0
    assert region.columns[1] - high[1] - 1 >= min(FREE_CELLS, shape[1] - high[1] - 1)


def test_a_half_is_cut_where_its_whole_is():
    """40 x 64 points with a small contact, of which the half has 32 columns."""
    whole = region_around(contact((40, 64), (15, 25), (28, 36)))
    half = region_around(contact((40, 32), (15, 25), (0, 4)), mirrored=True)
    assert whole.count < 0.2 * 40 * 64
    assert half.rows == whole.rows
    assert half.count <= whole.count / 2 + 16
