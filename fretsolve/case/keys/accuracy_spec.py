"""Validate `solver.accuracy`: how well which quantities are to be known, and what that may cost."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated, Any

from pydantic import AfterValidator, Field, GetJsonSchemaHandler, field_serializer, field_validator, model_validator
from pydantic_core import CoreSchema

from fretsolve.case.base import CaseModel, Count, Named, each_once
from fretsolve.case.cycle_quantities import CYCLES_WITH_BARS
from fretsolve.case.dimensions import NUMBER, TIME
from fretsolve.case.history import SCALED
from fretsolve.case.other_names import key_meant, nearest
from fretsolve.case.quantities import InUnits, QuantityError, refused, shown, split_quantity

LEVELS = {"draft": 0.05, "standard": 0.01, "reference": 0.002}
"""The accuracy that each name stands for."""

NAMED = (*SCALED, *CYCLES_WITH_BARS)
"""Quantities that an accuracy may be about: columns of the history, worn ones, and quantities of cycles."""


def _known(name: str) -> str:
    if name not in NAMED:
        meant = key_meant(name, NAMED)
        advice = f"did you mean {meant!r}?" if meant else nearest(name, NAMED)
        raise refused(f"{shown(name)} is not a quantity with an error bar; {advice}")
    return name


class AtMost(CaseModel):
    """Limits of the rounds of an accuracy; the first one is solved in any case."""

    time: Annotated[float, InUnits(TIME, above=0)] | None = Field(
        default=None,
        description="time, with its unit, after which no round begins that would end later",
        examples=["10 min"],
    )
    cells: Count = Field(default=1_000_000, description="most cells of the grid", examples=[400000])

    @field_validator("time", mode="before")
    @classmethod
    def _has_a_unit(cls, value: object) -> object:
        """A bare number is refused: seconds are as likely as minutes."""
        with suppress(QuantityError):
            number, unit = split_quantity(value)
            if not unit:
                raise refused(f"{shown(value)} has no unit; a time such as '{number:g} min' is needed")
        return value

    @field_serializer("time", when_used="json")
    def _with_unit(self, value: float | None) -> str | None:
        return None if value is None else f"{value:.10g} s"


Target = Annotated[
    float,
    InUnits(NUMBER, least=1e-4, most=0.2, share=True),
    Named(LEVELS, f"is not allowed; {', '.join(LEVELS)} or a number such as 1 %"),
]


class Accuracy(CaseModel):
    """Largest errors of quantities at the ends of stages, or in cycles."""

    target: Target = Field(
        description="largest error bar over the quantity's scale, such as 1 %, or draft (5 %), standard (1 %),"
        " reference (0.2 %)",
        examples=["1 %"],
    )
    of: tuple[Annotated[str, AfterValidator(_known), Field(json_schema_extra={"enum": list(NAMED)})], ...] = Field(
        default=(),
        description="quantities, also of cycles; none for loads, displacements, contact radius and dissipated energy",
        examples=[["Qx", "delta_x", "work_total"]],
    )
    at_most: AtMost = Field(
        default_factory=AtMost, description="what the rounds may take", examples=[{"time": "10 min"}]
    )

    @model_validator(mode="before")
    @classmethod
    def _from_target(cls, value: Any) -> Any:
        return value if isinstance(value, dict | Accuracy) else {"target": value}

    @field_validator("of")
    @classmethod
    def _each_once(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        return each_once(names)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        mapping = handler(schema)
        target = handler.resolve_ref_schema(mapping)["properties"]["target"]
        return {"anyOf": [dict(target), mapping]}
