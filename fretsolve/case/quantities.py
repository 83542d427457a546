"""Quantities with units: read by pint, kept as plain floats in mm, N, MPa, rad (and s).

A bare number is in these units already. pint and its registry are loaded only when an uncommon unit is met, and the
registry holds the few units that a contact problem needs instead of pint's full file, which takes fifty times
as long to load and would read "5 oil_bbl" as a volume.
"""

from __future__ import annotations

import functools
import math
import re
import reprlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic_core import CoreSchema, PydanticCustomError, core_schema

if TYPE_CHECKING:
    import pint
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

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
pound_force = 4.4482216152605 * newton = lbf
psi = pound_force / inch ** 2
ksi = 1000 * psi
bar = 1e5 * pascal
minute = 60 * second = min
hour = 3600 * second = h
percent = 0.01 = %
"""

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_FACTOR = r"[A-Za-zµμ°%_]+(?:(?:\^|\*\*)-?[1-9]|[²³])?"
_UNIT = rf"{_FACTOR}(?:(?:\s*[*/·.]\s*|\s+){_FACTOR})*"
_QUANTITY = re.compile(rf"^\s*(?:({_NUMBER})\s*)?({_UNIT})?\s*$")
TEXT_PATTERN = r"^\s*[+-]?\.?[0-9][^,]*$"
"""For the JSON Schema, coarser than what is read: a number, then perhaps its unit."""
_LONGEST = 100

UNIT_NOTE = "; a bare number is in "
"""In the JSON Schema, between a key's description and its unit."""


LEAST_MAGNITUDE, LARGEST_MAGNITUDE = 1e-40, 1e40
"""In internal units; products of a few such numbers have room in double precision. Forces and moments below it are
none; moduli, and lengths that cannot be 0, are refused."""


class QuantityError(ValueError):
    """Text or a number that is not the quantity needed; the text says what would be."""


@dataclass(frozen=True)
class Dimension:
    """A physical dimension: its name in messages, its internal unit, and how users write a value."""

    noun: str
    unit: str
    example: str

    @property
    def wanted(self) -> str:
        """The noun with an example, as in ``a force such as '400 N'``."""
        return f"{self.noun} such as {self.example!r}"

    def shown(self, value: float) -> str:
        """Return a value in internal units as users read it."""
        if self is ANGLE:
            return f"{math.degrees(value):g} deg"
        return f"{value:g} {self.unit}".rstrip()


LENGTH = Dimension("a length", "mm", "10 mm")
AREA = Dimension("an area", "mm^2", "0.28 mm^2")
FORCE = Dimension("a force", "N", "400 N")
MOMENT = Dimension("a moment", "N*mm", "5 N*mm")
ENERGY = Dimension("an energy", "N*mm", "0.014 N*mm")
PRESSURE = Dimension("a pressure", "MPa", "200 GPa")
ANGLE = Dimension("an angle", "rad", "0.1 deg")
TIME = Dimension("a time", "s", "2 s")
NUMBER = Dimension("a number", "", "0.1")
_KNOWN = (LENGTH, AREA, FORCE, MOMENT, PRESSURE, ANGLE, TIME, NUMBER)


COMMON_FACTORS = {
    ("m", LENGTH): 1e3,
    ("um", LENGTH): 1e-3,
    ("nm", LENGTH): 1e-6,
    ("kN", FORCE): 1e3,
    ("N*m", MOMENT): 1e3,
    ("GPa", PRESSURE): 1e3,
    ("deg", ANGLE): 0.017453292519943295,
    ("%", NUMBER): 0.01,
}
"""The usual units besides the internal ones. With them most cases start without pint, a quarter of the start-up."""


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    """Return the units of a case file (about 4 ms once pint is imported)."""
    import pint

    return pint.UnitRegistry(_DEFINITIONS.strip().splitlines())


@functools.cache
def _unit_factor(unit: str, dimension: Dimension) -> float:
    """Return one `unit` in the internal unit of `dimension`. Raises `QuantityError` for another dimension."""
    if unit == dimension.unit:
        return 1.0
    if (unit, dimension) in COMMON_FACTORS:
        return COMMON_FACTORS[unit, dimension]
    import pint

    registry = _registry()
    try:
        one = registry.Quantity(1.0, registry.parse_units(unit))
    except pint.UndefinedUnitError as error:
        names = error.unit_names
        unknown = names if isinstance(names, str) else ", ".join(names)
        raise QuantityError(f"has the unknown unit {unknown!r}; {dimension.wanted} is needed") from None
    try:
        return float(one.to(dimension.unit or "dimensionless").magnitude)
    except pint.DimensionalityError:
        found = next((d for d in _KNOWN if one.is_compatible_with(d.unit or "dimensionless")), None)
        kind = found.noun if found else f"a quantity in {unit}"
        raise QuantityError(f"is {kind}; {dimension.wanted} is needed") from None


def to_internal(value: object, dimension: Dimension, bare_unit: bool = False) -> float:
    """Convert a value of a case file to a float in internal units.

    value: a number, already in internal units, or text such as "400 N". bare_unit: a unit alone stands for
    one of it ("um" for 1e-3 mm). Raises `QuantityError`, whose text begins with the value.
    """
    try:
        number = _converted(value, dimension, bare_unit)
    except OverflowError:
        number = math.inf
    except QuantityError as error:
        raise QuantityError(f"{shown(value)} {error}") from None
    if not math.isfinite(number):
        raise QuantityError(f"{shown(value)} is not finite; {dimension.wanted} is needed")
    if abs(number) > LARGEST_MAGNITUDE:
        raise _out_of_bounds(value, dimension)
    if dimension in (FORCE, MOMENT) and abs(number) < LEAST_MAGNITUDE:
        return 0.0
    return number


def _out_of_bounds(value: object, dimension: Dimension) -> QuantityError:
    bounds = f"{LEAST_MAGNITUDE:g} and {LARGEST_MAGNITUDE:g} {dimension.unit}".rstrip()
    return QuantityError(f"{shown(value)} is beyond what is computed with; between {bounds} is needed")


def _converted(value: object, dimension: Dimension, bare_unit: bool) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, str):
        raise QuantityError(f"is not {dimension.wanted}")
    match = _QUANTITY.match(value) if len(value) <= _LONGEST else None
    if match is None or not value.strip():
        hint = " (the decimal separator is a point)" if re.search(r"\d,\d", value) else ""
        raise QuantityError(f"is not {dimension.wanted}{hint}")
    number, unit = match.groups()
    if number is None and not bare_unit:
        raise QuantityError(f"has no number; {dimension.wanted} is needed")
    return float(number or 1.0) * (_unit_factor(unit, dimension) if unit else 1.0)


def split_quantity(value: object) -> tuple[float, str]:
    """Split a number with or without a unit into number and unit. Raises `QuantityError`."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        number, unit = float(value), ""
    else:
        match = _QUANTITY.match(value) if isinstance(value, str) and len(value) <= _LONGEST else None
        if match is None or match.group(1) is None:
            raise QuantityError(f"{shown(value)} is not a number with a unit or without, such as '400 N' or 0.1")
        number, unit = float(match.group(1)), match.group(2) or ""
    if not math.isfinite(number):
        raise QuantityError(f"{shown(value)} is not finite; a number such as 0.1 is needed")
    return number, unit


def shown(value: object) -> str:
    """Return a value of the case file for a message: on one line, and short however large it is."""
    short = reprlib.Repr()
    short.maxlevel, short.maxdict, short.maxlist = 3, 4, 4
    short.maxstring = short.maxother = 60
    try:
        text = short.repr(value)
    except ValueError:  # an int beyond the interpreter's limit of digits
        return "a number of thousands of digits"
    return text if len(text) <= 120 else f"{text[:117]}..."


@dataclass(frozen=True)
class InUnits:
    """Annotation of a float of a model: read by `to_internal`, checked against bounds in internal units.

    above, below are exclusive, least and most inclusive; nonzero refuses 0.
    """

    dimension: Dimension
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    nonzero: bool = False
    bare_unit: bool = False

    def read(self, value: object) -> float:
        """Return the value in internal units. A validation error says what is wrong and what would be right."""
        try:
            number = to_internal(value, self.dimension, self.bare_unit)
            if (self.above == 0 or self.nonzero) and 0.0 < abs(number) < LEAST_MAGNITUDE:
                raise _out_of_bounds(value, self.dimension)
        except QuantityError as error:
            raise refused(str(error)) from None
        inside = (
            (self.above is None or number > self.above)
            and (self.least is None or number >= self.least)
            and (self.below is None or number < self.below)
            and (self.most is None or number <= self.most)
            and not (self.nonzero and number == 0)
        )
        if not inside:
            raise refused(f"{shown(value)} is out of range; {self.dimension.noun} {self._range()} is needed")
        return number

    def _range(self) -> str:
        bounds = [
            (">", self.above),
            (">=", self.least),
            ("<", self.below),
            ("<=", self.most),
            ("!=", 0.0 if self.nonzero else None),
        ]
        return " and ".join(
            f"{sign} {self.dimension.shown(bound)}" for sign, bound in bounds if bound is not None
        )

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        number: JsonSchemaValue = {"type": "number"}
        bounds = {
            "exclusiveMinimum": self.above,
            "minimum": self.least,
            "exclusiveMaximum": self.below,
            "maximum": self.most,
        }
        number |= {name: bound for name, bound in bounds.items() if bound is not None}
        if self.nonzero:
            number["not"] = {"const": 0}
        if self.dimension.unit:
            number["description"] = f"in {self.dimension.unit}"
        pattern = {} if self.bare_unit else {"pattern": TEXT_PATTERN}
        text = {"type": "string", **pattern, "examples": [self.dimension.example]}
        return {"anyOf": [number, text]}


def refused(message: str) -> PydanticCustomError:
    """Return a validation error whose text reaches the user as it is."""
    return PydanticCustomError("refused", "{message}", {"message": message})
