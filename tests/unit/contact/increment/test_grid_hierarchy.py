from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.increment.grid_hierarchy import FEWEST_COARSE_POINTS, GridTransfer
from fretsolve.problem.model.grid import Grid, HalfGrid

SHAPES = [(128, 128), (129, 98), (101, 62), (40, 180)]


def transfer_of(shape, center=(0.1, -0.2)):
    return GridTransfer(Grid.from_size(shape, (1.0, 0.9), center))


@pytest.mark.parametrize("shape", SHAPES)
def test_coarse_cells_cover_the_fine_ones(shape):
    transfer = transfer_of(shape)
    fine, coarse = transfer.fine, transfer.coarse
    for count, halved in zip(shape, coarse.shape, strict=True):
        assert halved == (-(-count // 2) if count >= 2 * FEWEST_COARSE_POINTS else count)
    assert coarse.x[0] - coarse.dx / 2 == pytest.approx(fine.x[0] - fine.dx / 2, abs=1e-15)
    assert coarse.y[0] - coarse.dy / 2 == pytest.approx(fine.y[0] - fine.dy / 2, abs=1e-15)


def test_small_grids_are_not_halved():
    assert transfer_of((2 * FEWEST_COARSE_POINTS - 1, 30)).coarse is None


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


@pytest.mark.parametrize("shape", [(128, 128), (129, 100), (60, 202), (120, 40)], ids=str)
def test_on_one_half_fields_change_as_on_the_whole_grid(shape):
    whole = Grid.from_size(shape, (1.0, 0.9))
    transfer, of_half = GridTransfer(whole), GridTransfer(HalfGrid.of(whole))
    columns = shape[1] // 2
    coarse_columns = of_half.coarse.ny
    half = np.random.default_rng(0).random((shape[0], columns))
    fields = np.concatenate([half[:, ::-1], half], axis=-1)
    coarse = of_half.restrict(half)
    if shape[1] % 4 == 0 or transfer.factors[1] == 1:  # else a cell of the coarse grid lies across y = 0
        wanted = transfer.restrict(fields)
        assert coarse == pytest.approx(wanted[..., -coarse_columns:], abs=1e-15)
        fine = transfer.prolong(wanted)[..., columns:]
        assert of_half.prolong(coarse) == pytest.approx(fine, abs=1e-15)
    assert of_half.coarse.y[:coarse_columns] == pytest.approx((np.arange(coarse_columns) + 0.5) * of_half.coarse.dy)
    assert coarse.sum() * of_half.coarse.cell_area == pytest.approx(half.sum() * of_half.fine.cell_area)
