"""Quantities with units: read by pint, kept as plain floats in mm, N, MPa, rad (and s).

pint is loaded only for an uncommon unit. Its registry holds the few units that a contact problem needs: pint's full
file takes fifty times as long to load and would read "5 oil_bbl" as a volume.
"""

from __future__ import annotations

import functools
import math
import operator
import re
import reprlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from fretsolve.case.dimensions import (
    ANGLE,
    DIMENSIONS,
    ENERGY,
    FORCE,
    LENGTH,
    LINE_ENERGY,
    LINE_FORCE,
    LINE_MOMENT,
    MOMENT,
    NUMBER,
    PRESSURE,
    STRESS_INTENSITY,
    WEAR_COEFFICIENT,
    Dimension,
    percent,
)

_DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
gram = [mass] = g
second = [time] = s
radian = [angle] = rad
degree = 0.017453292519943295 * radian = deg = °
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
joule = newton * meter = J
micron = 1e-6 * meter
inch = 0.0254 * meter = in
foot = 12 * inch = ft
mil = 0.001 * inch
decanewton = 10 * newton = daN
kilogram_force = 9.80665 * newton = kgf
pound_force = 4.4482216152605 * newton = lbf
kip = 1000 * pound_force
psi = pound_force / inch ** 2
ksi = 1000 * psi
bar = 1e5 * pascal
minute = 60 * second = min
hour = 3600 * second = h
percent = 0.01 = %
"""

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_FACTOR = r"[A-Za-zµμ°%_]+(?:(?:\^|\*\*)(?:-?[1-9]|0\.5)|[²³])?"
_PRODUCT = rf"{_FACTOR}(?:(?:\s*[*·.]\s*|\s+){_FACTOR})*"
_PART = rf"(?:{_FACTOR}|\(\s*{_PRODUCT}\s*\))"
_UNIT = rf"{_PART}(?:(?:\s*[*/·.]\s*|\s+){_PART})*"
_QUANTITY = re.compile(rf"^\s*(?:({_NUMBER})\s*)?({_UNIT})?\s*$")
TEXT_PATTERN = r"^\s*[+-]?\.?[0-9][^,]*$"
"""For the JSON Schema, coarser than what is read: a number, then perhaps its unit."""

UNIT_NOTE = "; a bare number is in "
"""In the JSON Schema, between a key's description and its unit."""

LEAST_MAGNITUDE, LARGEST_MAGNITUDE = 1e-40, 1e40
"""In internal units; products of a few such numbers have room in double precision. Smaller values count as 0, and are
refused where a value cannot be 0."""


class QuantityError(ValueError):
    """Text or a number that is not the quantity needed; the text says what would be."""


COMMON_FACTORS = {
    ("m", LENGTH): 1e3,
    ("um", LENGTH): 1e-3,
    ("nm", LENGTH): 1e-6,
    ("kN", FORCE): 1e3,
    ("N/m", LINE_FORCE): 1e-3,
    ("kN/m", LINE_FORCE): 1.0,
    ("N m", MOMENT): 1e3,
    ("GPa", PRESSURE): 1e3,
    ("mm^3/J", WEAR_COEFFICIENT): 1e-3,
    ("mm^3/(N*m)", WEAR_COEFFICIENT): 1e-3,
    ("MPa mm^0.5", STRESS_INTENSITY): 0.03162277660168379,
    ("deg", ANGLE): 0.017453292519943295,
    ("%", NUMBER): 0.01,
}
"""The usual units besides the internal ones. With them most cases start without pint, a quarter of the start-up."""


@functools.cache
def _registry() -> Any:
    """Return the units of a case file (about 4 ms once pint is imported)."""
    import pint

    return pint.UnitRegistry(_DEFINITIONS.strip().splitlines())


@functools.cache
def _unit_factor(unit: str, dimension: Dimension) -> float:
    """Return one `unit` in the internal unit of `dimension`. Raises `QuantityError` for another dimension."""
    spaced = re.sub(r"\s*[*·]\s*|\s+", " ", unit)  # N*mm is N mm
    if spaced == dimension.unit:
        return 1.0
    if (spaced, dimension) in COMMON_FACTORS:
        return COMMON_FACTORS[spaced, dimension]
    import pint

    registry = _registry()
    try:
        one = registry.Quantity(1.0, registry.parse_units(unit))
    except pint.UndefinedUnitError as error:
        names = error.unit_names
        unknown = names if isinstance(names, str) else ", ".join(names)
        meant = _meant(unit, dimension)
        raise QuantityError(f"has the unknown unit {unknown!r}{meant}; {dimension.wanted} is needed") from None
    try:
        return float(one.to(dimension.unit or "dimensionless").magnitude)
    except pint.DimensionalityError:
        found = next((d for d in DIMENSIONS if one.is_compatible_with(d.unit or "dimensionless")), None)
        if found is MOMENT and (dimension in (ENERGY, LINE_ENERGY) or "J" in unit):
            found = ENERGY
        kind = found.noun if found else f"a quantity in {unit}"
        per_length = " (per length with plane: strain, which makes a line contact)" if found is LINE_FORCE else ""
        hint = per_length if dimension in (FORCE, MOMENT) else ""
        raise QuantityError(f"is {kind}; {dimension.wanted} is needed{hint}") from None


def _meant(unit: str, dimension: Dimension) -> str:
    """Return a question about a usual unit of the dimension that differs in capitals or a sign; empty without one."""
    usual = [dimension.unit, *(one for one, of in COMMON_FACTORS if of == dimension)]
    plain = {one.replace(" ", "").lower(): one for one in reversed(usual)}
    found = plain.get(re.sub(r"[\s*·]", "", unit).lower())
    return f" (did you mean {found}?)" if found else ""


def to_internal(value: object, dimension: Dimension, bare_unit: bool = False) -> float:
    """Convert a value of a case file to a float in internal units.

    value: a number in internal units, or text such as "400 N". bare_unit: a unit alone stands for one unit ("um" for
    1e-3 mm). Raises `QuantityError`, whose text begins with the value.
    """
    try:
        given, unit = _parts(value)
        if given is None and not unit:
            raise QuantityError(f"is not {dimension.wanted}{_hint(value, dimension)}")
        if given is None and not bare_unit:
            raise QuantityError(f"has no number; {dimension.wanted} is needed")
        number = (1.0 if given is None else given) * (_unit_factor(unit, dimension) if unit else 1.0)
    except OverflowError:
        number = math.inf
    except QuantityError as error:
        raise QuantityError(f"{shown(value)} {error}") from None
    if not math.isfinite(number):
        raise QuantityError(f"{shown(value)} is not finite; {dimension.wanted} is needed")
    if abs(number) > LARGEST_MAGNITUDE:
        raise _out_of_bounds(value, dimension)
    if dimension in (FORCE, MOMENT, LINE_FORCE, LINE_MOMENT) and abs(number) < LEAST_MAGNITUDE:
        return 0.0
    return number


def _hint(value: object, dimension: Dimension) -> str:
    """Return what is wrong with a text that is no quantity, in parentheses; empty if nothing is known of the text."""
    if not isinstance(value, str):
        return ""
    if re.search(r"\d,\d", value):
        return " (the decimal separator is a point)"
    with_power = re.sub(r"(?<![\d.][eE])(?<=[A-Za-zµμ])([2-9])(?![\d.])", r"^\1", value)  # N/mm2
    if with_power != value:
        with suppress(QuantityError):
            to_internal(with_power, dimension)
            return f" (did you mean {shown(with_power)}?)"
    return ""


def _out_of_bounds(value: object, dimension: Dimension) -> QuantityError:
    bounds = f"{LEAST_MAGNITUDE:g} and {LARGEST_MAGNITUDE:g} {dimension.unit}".rstrip()
    return QuantityError(f"{shown(value)} is too small or too large; a value between {bounds} is needed")


def _parts(value: object) -> tuple[float | None, str]:
    """Return the number and the unit of a value, each of which may be missing; neither for anything else."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), ""
    text = re.sub(r"sqrt\(\s*(m|mm)\s*\)|√(m{1,2})\b", r"\1\2^0.5", value) if isinstance(value, str) else ""
    match = _QUANTITY.match(text) if 0 < len(text) <= 100 else None
    return (float(match[1]) if match[1] else None, match[2] or "") if match is not None else (None, "")


def split_quantity(value: object) -> tuple[float, str]:
    """Split a number with or without a unit into number and unit. Raises `QuantityError`."""
    try:
        number, unit = _parts(value)
    except OverflowError:
        number, unit = math.inf, ""
    if number is None:
        raise QuantityError(f"{shown(value)} is not a number with a unit or without, such as '400 N' or 0.1")
    if not math.isfinite(number):
        raise QuantityError(f"{shown(value)} is not finite; a number such as 0.1 is needed")
    return number, unit


class _AsTyped(reprlib.Repr):
    """Values as they stand in a case file, shortened; a text that stands alone in quotes."""

    def repr_bool(self, value: bool, level: int) -> str:
        return "true" if value else "false"

    def repr_NoneType(self, value: None, level: int) -> str:  # noqa: N802
        return "null"

    def repr_str(self, value: str, level: int) -> str:
        text = super().repr_str(value, level)
        return text if level == self.maxlevel else text[1:-1]

    def repr_dict(self, value: dict[Any, Any], level: int) -> str:
        if level <= 0:
            return "{...}"
        parts = [f"{self.repr1(key, level - 1)}: {self.repr1(one, level - 1)}" for key, one in value.items()]
        return f"{{{', '.join(parts[: self.maxdict] + ['...'] * (len(parts) > self.maxdict))}}}"


def shown(value: object) -> str:
    """Return a value of the case file for a message: on one line, and short however large it is."""
    short = _AsTyped()
    short.maxlevel, short.maxdict, short.maxlist = 3, 4, 4
    short.maxstring = short.maxother = 60
    try:
        text = short.repr(value)
    except ValueError:  # an int beyond the interpreter's limit of digits
        return "a number of thousands of digits"
    return text if len(text) <= 120 else f"{text[:117]}..."


@dataclass(frozen=True)
class InUnits:
    """Annotation of a float: read by `to_internal`, then checked. above, below: exclusive bounds; nonzero: not 0.

    share: a part of something, whose bounds are told in per cent.
    """

    dimension: Dimension
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    nonzero: bool = False
    bare_unit: bool = False
    share: bool = False

    def read(self, value: object) -> float:
        """Return the value in internal units. A validation error says what is wrong and what would be right."""
        try:
            number = to_internal(value, self.dimension, self.bare_unit)
            if (self.above == 0 or self.nonzero) and 0.0 < abs(number) < LEAST_MAGNITUDE:
                raise _out_of_bounds(value, self.dimension)
        except QuantityError as error:
            raise refused(str(error)) from None
        if not self._allows(number):
            write = percent if self.share else self.dimension.shown
            needed = " and ".join(f"{sign} {write(bound)}" for sign, _, _, bound in self._bounds())
            meant = f" (did you mean {shown(value)} %?)" if self._forgets_percent(value) else ""
            raise refused(f"{shown(value)} is out of range; {self.dimension.noun} {needed} is needed{meant}")
        return 0.0 if abs(number) < LEAST_MAGNITUDE else number

    def _allows(self, number: float) -> bool:
        return all(holds(number, bound) for _, _, holds, bound in self._bounds())

    def _forgets_percent(self, value: object) -> bool:
        """Return whether a bare number would be allowed in per cent."""
        return self.share and isinstance(value, int | float) and self._allows(0.01 * value)

    def _bounds(self) -> list[tuple[str, str, Callable[[float, float], bool], float]]:
        """Return the bounds: sign, keyword of the JSON Schema, operator, value."""
        bounds = [
            (">", "exclusiveMinimum", operator.gt, self.above),
            (">=", "minimum", operator.ge, self.least),
            ("<", "exclusiveMaximum", operator.lt, self.below),
            ("<=", "maximum", operator.le, self.most),
            ("!=", "not", operator.ne, 0.0 if self.nonzero else None),
        ]
        return [(sign, keyword, holds, bound) for sign, keyword, holds, bound in bounds if bound is not None]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        number: dict[str, Any] = {"type": "number"}
        number |= {keyword: {"const": 0} if keyword == "not" else bound for _, keyword, _, bound in self._bounds()}
        if self.dimension.unit:
            number["description"] = f"in {self.dimension.unit}"
        pattern = {} if self.bare_unit else {"pattern": TEXT_PATTERN}
        return {"anyOf": [number, {"type": "string", **pattern, "examples": [self.dimension.example]}]}


def refused(message: str) -> PydanticCustomError:
    """Return a validation error whose text reaches the user as it is."""
    return PydanticCustomError("refused", "{message}", {"message": message})
