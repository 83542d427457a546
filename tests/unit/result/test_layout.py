"""The layout table against the state it stores, and the units against what reads them."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import h5py
import numpy as np
import pint
import pytest

from fretsolve.result.layout import (
    BULK_HISTORY,
    DERIVED_FIELDS,
    FIELDS,
    HISTORY,
    SPOT_HISTORY,
    STEP,
    WEAR_HISTORY,
    X,
    chunk_shape,
    create_column,
    stored_fields,
)
from fretsolve.result.state import ZONE_NAMES, Fields, Summary, Zone


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


def test_all_arrays_of_a_state_can_be_stored() -> None:
    assert {quantity.array for quantity in (*FIELDS, *DERIVED_FIELDS)} == {field.name for field in fields(Fields)}


@pytest.mark.parametrize(
    "quantity",
    [*HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *FIELDS, *DERIVED_FIELDS, X],
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


@pytest.mark.parametrize(("zone", "name"), [(Zone.OPEN, "open"), (Zone.STICK, "stick"), (Zone.SLIP, "slip")])
def test_zones_are_plain_integers(zone: int, name: str) -> None:
    """NumPy would call Python for members of an enumeration, and lose an interrupt that comes meanwhile."""
    assert type(zone) is int
    assert ZONE_NAMES[zone] == name


@pytest.mark.parametrize("increments", [0, 1, 20_000])
def test_columns_of_any_length_have_units_and_a_scale(tmp_path: Path, increments: int) -> None:
    with h5py.File(tmp_path / "columns.h5", "w") as file:
        step = create_column(file, STEP, np.arange(increments))
        column = create_column(file, HISTORY[1], np.linspace(1.0, 2.0, increments), step)
        assert column[:].tolist() == np.linspace(1.0, 2.0, increments).tolist()
        assert (column.attrs["units"], column.dims[0][0].name) == (HISTORY[1].units, "/step")
        assert column.compression == ("gzip" if increments > 600 else None)
