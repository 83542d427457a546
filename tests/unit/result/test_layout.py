"""The layout table against the state it stores, and the units against what reads them."""

from __future__ import annotations

from dataclasses import fields

import pint
import pytest

from fretsolve.result.layout import (
    BULK_HISTORY,
    DERIVED_FIELDS,
    FIELDS,
    HISTORY,
    RIG_HISTORY,
    SPOT_HISTORY,
    STEP,
    WEAR_HISTORY,
    X,
    stored_fields,
)
from fretsolve.result.state import Fields, Summary


def test_history_has_the_columns_of_a_summary_in_order() -> None:
    columns = (STEP, *HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *RIG_HISTORY)
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
    [*HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *RIG_HISTORY, *FIELDS, *DERIVED_FIELDS, X],
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
