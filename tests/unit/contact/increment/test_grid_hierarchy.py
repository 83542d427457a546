from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.increment.grid_hierarchy import GridTransfer
from fretsolve.problem.model.grid import Grid

SHAPES = [(129, 98), (40, 180)]


def transfer_of(shape, center=(0.1, -0.2)):
    return GridTransfer(Grid.from_size(shape, (1.0, 0.9), center))


@pytest.mark.parametrize("shape", SHAPES)
def test_restriction_keeps_the_load(shape):
    transfer = transfer_of(shape)
    field = np.random.default_rng(0).random((2, *shape))
    coarse = transfer.restrict(field)
    assert coarse.shape == (2, *transfer.coarse.shape)
    fine_load, coarse_load = field.sum() * transfer.fine.cell_area, coarse.sum() * transfer.coarse.cell_area
    assert coarse_load == pytest.approx(fine_load)


@pytest.mark.parametrize("shape", SHAPES)
def test_linear_fields_are_restored_inside(shape):
    transfer = transfer_of(shape)
    fine, coarse = transfer.fine, transfer.coarse
    linear = 1.0 + 2.0 * coarse.x[:, None] - 3.0 * coarse.y[None, :]
    found = transfer.prolong(linear)
    exact = 1.0 + 2.0 * fine.x[:, None] - 3.0 * fine.y[None, :]
    np.testing.assert_allclose(found[2:-2, 2:-2], exact[2:-2, 2:-2], atol=1e-13)
    assert found.shape == shape
