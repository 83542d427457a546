"""Friction as written in the case file: one coefficient, or one that varies."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from fretsolve.case.base import CaseModel, Count, Position, PositiveLength, refused_at
from fretsolve.case.dimensions import ANGLE, ENERGY_PER_AREA, NUMBER, PRESSURE
from fretsolve.case.expression import Expression
from fretsolve.case.keys.map_keys import MapKeys, file_in_case_folder
from fretsolve.case.quantities import InUnits, QuantityError, refused

Coefficient = Annotated[float, InUnits(NUMBER, least=0)]
PositiveCoefficient = Annotated[float, InUnits(NUMBER, above=0)]

KINDS = ("coefficient", "map", "expression", "initial", "cycles")
"""Keys of which a friction has exactly one."""

COMPANIONS = {
    "angle": "coefficient",
    **dict.fromkeys(MapKeys.model_fields, "map"),
    "center": "map",
    "final": "initial",
    "slip": "initial",
    "energy": "initial",
    "weakening": "initial",
}
"""Keys that stand beside one of `KINDS` alone."""


def _readable(text: str) -> str:
    try:
        Expression(text)
    except QuantityError as error:
        raise refused(str(error)) from None
    return text


class FrictionByPlace(CaseModel):
    """Friction by one coefficient, by a formula, or by a map."""

    coefficient: (
        Annotated[
            Annotated[Coefficient, Tag("(number)")]
            | Annotated[tuple[PositiveCoefficient, PositiveCoefficient], Tag("(pair)")],
            Discriminator(lambda value: "(pair)" if isinstance(value, list | tuple) else "(number)"),
        ]
        | None
    ) = Field(
        default=None,
        description="coefficient of friction, such as 0.1, or [mu_x, mu_y] along two axes",
        examples=[0.1, [0.2, 0.1]],
    )
    angle: Annotated[float, InUnits(ANGLE)] | None = Field(
        default=None, description="with [mu_x, mu_y], from x to the first axis", examples=["30 deg"]
    )
    expression: Annotated[str, AfterValidator(_readable)] | None = Field(
        default=None,
        description="coefficient as a formula of x, y and r = hypot(x, y), in mm",
        examples=["0.1 + 0.2*(abs(y) < 0.1 mm)"],
    )
    map: Path | None = Field(
        default=None, description="file of a map of the coefficient, read as one of heights", examples=["mu.npy"]
    )


class FrictionSpec(MapKeys, FrictionByPlace):
    """Friction: one coefficient, or one that varies over the contact, with slip, from cycle to cycle."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": [kind]} for kind in KINDS]})

    center: Position | None = Field(default=None, description="[x, y] of the map's middle", examples=[["0.1 mm", 0]])
    initial: Coefficient | None = Field(
        default=None, description="coefficient before any slip, which runs in to `final`", examples=[0.2]
    )
    final: Coefficient | None = Field(default=None, description="coefficient after much slip", examples=[0.7])
    slip: PositiveLength | None = Field(
        default=None, description="path of slip on which the change falls to 1/e", examples=["5 mm"]
    )
    energy: Annotated[float, InUnits(ENERGY_PER_AREA, above=0)] | None = Field(
        default=None, description="instead of slip, dissipated energy per area on which the change falls to 1/e"
    )
    weakening: Literal["refuse", "allow"] | None = Field(
        default=None,
        description="allow to go on where friction falls so fast with slip that the result depends on the increments",
    )
    cycles: tuple[tuple[Count, Coefficient], ...] | None = Field(
        default=None,
        min_length=1,
        description="list of [cycle, coefficient], linear between them and constant in a cycle",
        examples=[[[1, 0.2], [1000, 0.7]]],
    )
    shear_limit: Annotated[float, InUnits(PRESSURE, above=0)] | None = Field(
        default=None, description="largest shear traction, above which the surfaces slip", examples=["300 MPa"]
    )
    exponent: Annotated[float, InUnits(NUMBER, above=0, most=3)] | None = Field(
        default=None,
        description="m of a friction limit mu p (p/reference_pressure)^(m - 1); the factor on mu is at most 10",
        examples=[0.667],
    )
    reference_pressure: Annotated[float, InUnits(PRESSURE, above=0)] | None = Field(
        default=None, description="with exponent, pressure at which the coefficient is the given one"
    )

    @property
    def kind(self) -> str:
        """The one of `KINDS` that is given."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def is_constant(self) -> bool:
        """True if the friction limit is one coefficient times the pressure."""
        return isinstance(self.coefficient, float) and self.shear_limit is None and self.exponent is None

    @property
    def pair(self) -> tuple[float, float] | None:
        """The coefficients along two axes, None if there is one for all directions."""
        return self.coefficient if isinstance(self.coefficient, tuple) else None

    def in_cycle(self, number: float) -> float:
        """Return the coefficient in a cycle, counted from 1, by the table of cycles."""
        table = self.cycles or ()
        for (before, low), (after, high) in pairwise(table):
            if before <= number < after:
                return low + (high - low) * (number - before) / (after - before)
        return table[0][1] if number < table[0][0] else table[-1][1]

    @model_validator(mode="before")
    @classmethod
    def _from_number(cls, value: Any) -> Any:
        if isinstance(value, list):
            raise refused("a list stands below a key, as {coefficient: [0.2, 0.1]} along two axes; name the key")
        return value if isinstance(value, dict | FrictionSpec) else {"coefficient": value}

    @field_validator("map", mode="before")
    @classmethod
    def _from_case_folder(cls, value: object, info: ValidationInfo) -> object:
        return None if value is None else file_in_case_folder(value, info, "mu.npy")

    @field_validator("cycles")
    @classmethod
    def _ascending(cls, table: tuple[tuple[int, float], ...] | None) -> tuple[tuple[int, float], ...] | None:
        late = [row for row in range(1, len(table or ())) if table and table[row][0] <= table[row - 1][0]]
        refused_at(((row, 0), "the cycles do not ascend; a larger one than before is needed") for row in late)
        return table

    @model_validator(mode="after")
    def _keys_fit(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        kinds = [name for name in given if name in KINDS]
        if not kinds:
            lone = next((name for name in given if name in COMPANIONS), None)
            if lone is not None:
                refused_at([((lone,), f"{lone} belongs to {COMPANIONS[lone]}, which is not given; give it as well")])
            raise ValidationError.from_exception_data(
                "friction", [{"type": "missing", "loc": ("coefficient",), "input": None}]
            )
        if len(kinds) > 1:
            refused_at([((kinds[1],), f"{' and '.join(kinds)} cannot be given together; keep one of them")])
        for name in given:
            if name in COMPANIONS and COMPANIONS[name] not in given:
                refused_at([((name,), f"{name} belongs to {COMPANIONS[name]}, which is not given; remove it")])
        if self.initial is not None:
            if self.final is None:
                raise refused("initial is given without final; give the coefficient after much slip as well")
            if (self.slip is None) == (self.energy is None):
                raise refused("either slip or energy is needed beside initial and final")
        if self.angle is not None and self.pair is None:
            refused_at([(("angle",), "angle belongs to two coefficients [mu_x, mu_y]; remove it")])
        if abs(self.angle or 0.0) > 2.0 * math.pi:
            refused_at(
                [(("angle",), f"{self.angle:g} rad is more than a turn; write '{self.angle:g} deg' if so meant")]
            )
        if self.pair is not None and (self.shear_limit is not None or self.exponent is not None):
            raise refused("two coefficients cannot stand beside shear_limit or exponent; give one coefficient")
        if (self.exponent is None) != (self.reference_pressure is None):
            raise refused("exponent and reference_pressure belong together; give both or neither")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        mapping = handler(schema)
        number = InUnits(NUMBER, least=0).__get_pydantic_json_schema__(schema, handler)
        text = handler.resolve_ref_schema(mapping)["properties"]["coefficient"]["description"]
        return {"anyOf": [{**number, "description": text, "examples": [0.1]}, mapping]}
