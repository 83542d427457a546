"""The layout table against the state it stores, and the units against what reads them."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pint
import pytest

from fretsolve.result.layout import (
    BULK_HISTORY,
    CHUNK_BYTES,
    DERIVED_FIELDS,
    DISPLACEMENT,
    FIELDS,
    HISTORY,
    RESTART,
    SPOT_HISTORY,
    STEP,
    WEAR_HISTORY,
    X,
    chunk_shape,
    create_column,
    create_columns,
    stored_fields,
)
from fretsolve.result.state import Fields, Summary


def test_history_has_the_columns_of_a_summary_in_order() -> None:
    columns = (STEP, *HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY)
    assert [column.name for column in columns] == [field.name for field in fields(Summary)]
    counts = {"step", "stage", "contact_cells", "stick_cells", "alternations", "operator_applications"}
    counts |= {"iterations_normal", "iterations_tangential", "spots", "small_spots"}
    assert {column.name for column in columns if column.dtype == "int64"} == counts
    assert {column.name: column.units for column in columns if column.name in ("work", "residual_slip", "Mz")} == {
        "Mz": "N mm",
        "work": "mJ",
        "residual_slip": "rad",
    }


def test_restart_has_all_arrays_of_a_state() -> None:
    arrays = {quantity.array for quantity in RESTART}
    derived = {quantity.array for quantity in DERIVED_FIELDS}
    assert arrays | derived == {field.name for field in fields(Fields)} | {"displacement"}


@pytest.mark.parametrize(
    "quantity",
    [*HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *FIELDS, *DERIVED_FIELDS, *DISPLACEMENT, X],
    ids=lambda quantity: quantity.name,
)
def test_units_are_understood(quantity: object) -> None:
    pint.UnitRegistry().Unit(quantity.units)  # raises where it does not parse
    assert quantity.long_name


def test_selected_fields_come_in_file_order() -> None:
    names = [quantity.name for quantity in stored_fields(["zone", "shear"])]
    assert names == ["shear_x", "shear_y", "zone"]
    with pytest.raises(ValueError, match="no such field: heat"):
        stored_fields(["heat"])


@pytest.mark.parametrize(("shape", "chunk"), [((6, 5), (6, 5)), ((512, 512), (256, 512)), ((1000, 1000), (125, 1000))])
def test_chunks_are_whole_rows_of_about_a_megabyte(shape: tuple[int, int], chunk: tuple[int, int]) -> None:
    assert chunk_shape(*shape) == chunk
    assert 8 * chunk[0] * chunk[1] <= CHUNK_BYTES


def described_as(column: Any) -> tuple[Any, ...]:
    """Return all that a reader may ask of a column."""
    filters = column.chunks, column.compression, column.compression_opts, column.fletcher32, column.shuffle
    texts = {name: (column.attrs[name], str(column.attrs.get_id(name).dtype)) for name in ("units", "long_name")}
    scales = [scale.name.rpartition("/")[2] for scale in column.dims[0].values()]
    return column.dtype, column[:].tolist(), filters, texts, scales, column.is_scale


@pytest.mark.parametrize("increments", [0, 1, 7])
def test_columns_written_together_are_those_written_one_by_one(tmp_path: Path, increments: int) -> None:
    rng = np.random.default_rng(1)
    columns = [(STEP, np.arange(increments)), *((one, 1e3 * rng.normal(size=increments)) for one in HISTORY)]
    with h5py.File(tmp_path / "columns.h5", "x") as file:
        one_by_one, together = file.create_group("one by one"), file.create_group("together")
        scale = None
        for quantity, values in columns:
            column = create_column(one_by_one, quantity, values, scale)
            scale = scale or column
        create_columns(together, columns)
        assert list(together) == list(one_by_one)
        for name in one_by_one:
            assert described_as(together[name]) == described_as(one_by_one[name])
