"""Quantities with units: conversion, dimensions, and what is said of a wrong one."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError

from fretsolve.case.dimensions import ANGLE, ENERGY, FORCE, LENGTH, MOMENT, NUMBER, PRESSURE, TIME, Dimension
from fretsolve.case.quantities import COMMON_FACTORS, InUnits, QuantityError, to_internal


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("400 N", FORCE, 400.0),
        ("  -36 N ", FORCE, -36.0),
        ("1.5 um", LENGTH, 1.5e-3),
        ("1.5 µm", LENGTH, 1.5e-3),
        ("1.5 μm", LENGTH, 1.5e-3),
        ("2 micron", LENGTH, 2e-3),
        ("1 in", LENGTH, 25.4),
        ("1 ft", LENGTH, 304.8),
        ("1 kgf", FORCE, 9.80665),
        ("29e3 kip/in^2", PRESSURE, 29e3 * 4448.2216152605 / 645.16),
        ("200 GPa", PRESSURE, 200e3),
        ("200e3 N/mm**2", PRESSURE, 200e3),
        ("200e3 N/mm²", PRESSURE, 200e3),
        ("5 N*mm", MOMENT, 5.0),
        ("5 N*mm", ENERGY, 5.0),
        ("5 mJ", ENERGY, 5.0),
        ("5 N mm", MOMENT, 5.0),
        ("5 N·mm", MOMENT, 5.0),
        ("5 N.m", MOMENT, 5000.0),
        ("0.1 deg", ANGLE, math.radians(0.1)),
        ("90 °", ANGLE, math.pi / 2),
        ("1 %", NUMBER, 0.01),
        ("0.1", NUMBER, 0.1),
        ("2 min", TIME, 120.0),
        (".5", LENGTH, 0.5),
        (7, LENGTH, 7.0),
    ],
)
def test_conversion_to_internal_units(text: object, dimension: Dimension, expected: float) -> None:
    assert to_internal(text, dimension) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("value", "dimension", "message"),
    [
        ("5 N", MOMENT, "'5 N' is a force; a moment such as '5 N mm' is needed"),
        ("5 mm", FORCE, "'5 mm' is a length; a force such as '400 N' is needed"),
        ("5 N*mm", FORCE, "'5 N*mm' is a moment; a force such as '400 N' is needed"),
        ("1 %", ANGLE, "'1 %' is a number; an angle such as '0.1 deg' is needed"),
        ("1 deg", NUMBER, "'1 deg' is an angle; a number such as '0.1' is needed"),
        (
            "5 N/mm",
            FORCE,
            "'5 N/mm' is a force per length; a force such as '400 N' is needed"
            " (per length with plane: strain, which makes a line contact)",
        ),
        ("5 N/m^3", FORCE, "'5 N/m^3' is a quantity in N/m^3; a force such as '400 N' is needed"),
        ("5 Nm", MOMENT, "'5 Nm' has the unknown unit 'Nm' (did you mean N m?); a moment such as '5 N mm' is needed"),
        ("20 degC", ANGLE, "'20 degC' has the unknown unit 'degC'; an angle such as '0.1 deg' is needed"),
        ("200e3 N/mm2", PRESSURE, "'200e3 N/mm2' is not a pressure such as '200 GPa' (did you mean '200e3 N/mm^2'?)"),
        ("5 mm2", LENGTH, "'5 mm2' is not a length such as '10 mm'"),
        ("5 furlong", LENGTH, "'5 furlong' has the unknown unit 'furlong'; a length such as '10 mm' is needed"),
        ("mm", LENGTH, "'mm' has no number; a length such as '10 mm' is needed"),
        ("1,5 mm", LENGTH, "'1,5 mm' is not a length such as '10 mm' (the decimal separator is a point)"),
        ("2 * 3 mm", LENGTH, "'2 * 3 mm' is not a length such as '10 mm'"),
        ("", LENGTH, "'' is not a length such as '10 mm'"),
        (True, LENGTH, "true is not a length such as '10 mm'"),
        ([1], LENGTH, "[1] is not a length such as '10 mm'"),
        (math.inf, LENGTH, "inf is not finite; a length such as '10 mm' is needed"),
        (math.nan, FORCE, "nan is not finite; a force such as '400 N' is needed"),
        ("1e308 GPa", PRESSURE, "'1e308 GPa' is not finite; a pressure such as '200 GPa' is needed"),
        ("1e999", LENGTH, "'1e999' is not finite; a length such as '10 mm' is needed"),
    ],
)
def test_message_names_the_value_and_what_is_needed(value: object, dimension: Dimension, message: str) -> None:
    with pytest.raises(QuantityError) as caught:
        to_internal(value, dimension)
    assert str(caught.value) == message


def test_number_beyond_a_float_is_refused() -> None:
    with pytest.raises(QuantityError, match="is not finite"):
        to_internal(10**400, LENGTH)
    with pytest.raises(QuantityError, match="thousands of digits is not finite"):
        to_internal(10**5000, LENGTH)


def test_unit_alone_stands_for_one_of_it_only_where_that_is_meant() -> None:
    assert to_internal("um", LENGTH, bare_unit=True) == pytest.approx(1e-3, rel=1e-14)
    assert to_internal("2 um", LENGTH, bare_unit=True) == pytest.approx(2e-3, rel=1e-14)


@given(st.text(alphabet="0123456789.+-eE NmkGPadrgµ°%*/^²()_'[],\n", max_size=30), st.sampled_from([LENGTH, MOMENT]))
def test_any_text_converts_or_is_refused_in_one_line(text: str, dimension: Dimension) -> None:
    try:
        assert math.isfinite(to_internal(text, dimension))
    except QuantityError as error:
        assert "\n" not in str(error)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_text_in_the_internal_unit_keeps_every_digit(number: float) -> None:
    """As far as such numbers are computed with: squares and products of some of them stay finite."""
    if abs(number) <= 1e40:
        assert to_internal(f"{number!r} mm", LENGTH) == number
    else:
        with pytest.raises(QuantityError, match=r"between 1e-40 and 1e\+40 mm is needed"):
            to_internal(f"{number!r} mm", LENGTH)


@pytest.mark.parametrize(("unit", "dimension"), COMMON_FACTORS)
def test_common_units_are_those_of_pint(unit: str, dimension: Dimension) -> None:
    """The same unit in words that only pint knows."""
    by_pint = to_internal(f"3 {unit} % / %" if unit != "%" else "3 % % / %", dimension)
    assert to_internal(f"3 {unit}", dimension) == pytest.approx(by_pint, rel=1e-15)


def test_pint_is_loaded_only_for_an_uncommon_unit() -> None:
    code = (
        "import sys; from fretsolve.case.quantities import to_internal, LENGTH, PRESSURE;"
        "to_internal(3, LENGTH); to_internal('3 mm', LENGTH); to_internal('3 GPa', PRESSURE);"
        "assert 'pint' not in sys.modules; to_internal('3 ksi', PRESSURE); assert 'pint' in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_load_that_is_next_to_nothing_is_none() -> None:
    """Its squares would vanish."""
    assert to_internal("1e-30 N", FORCE) == 1e-30
    assert to_internal("-1e-300 N", FORCE) == 0.0


@pytest.mark.parametrize(
    "quantity", [InUnits(LENGTH, above=0), InUnits(PRESSURE, above=0), InUnits(LENGTH, nonzero=True)]
)
def test_what_cannot_be_0_is_not_next_to_it_either(quantity: InUnits) -> None:
    assert quantity.read(1e-30) == 1e-30
    with pytest.raises(PydanticCustomError, match=r"between 1e-40 and 1e\+40 (mm|MPa) is needed"):
        quantity.read(1e-200)
