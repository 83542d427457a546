"""The values that `fretsolve check` compares at the ends of stages."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from .base import CaseModel, Count
from .problems import nearest
from .quantities import (
    ANGLE,
    AREA,
    ENERGY,
    FORCE,
    LENGTH,
    MOMENT,
    NUMBER,
    PRESSURE,
    TEXT_PATTERN,
    TIME,
    Dimension,
    InUnits,
    refused,
    shown,
)

_QUANTITIES: dict[Dimension, str] = {
    FORCE: "P Qx Qy",
    MOMENT: "Mx My Mz",
    LENGTH: "delta_z delta_x delta_y contact_radius stick_radius",
    ANGLE: "phi_x phi_y phi_z",
    AREA: "contact_area stick_area",
    PRESSURE: "max_pressure max_shear",
    ENERGY: "work work_total",
    NUMBER: "contact_cells stick_cells iterations_normal iterations_tangential alternations operator_applications"
    " residual_gap residual_stick residual_slip residual_bound residual_load",
    TIME: "wall_time",
}
HISTORY_DIMENSIONS = {name: dimension for dimension, names in _QUANTITIES.items() for name in names.split()}
"""Dimension of each scalar of the history that can be expected."""


def _known_quantity(name: str) -> str:
    if name not in HISTORY_DIMENSIONS:
        raise refused(f"{shown(name)} is not a quantity of the history; {nearest(name, HISTORY_DIMENSIONS)}")
    return name


_ANY_QUANTITY = WithJsonSchema(
    {
        "anyOf": [
            {"type": "number"},
            {"type": "string", "pattern": TEXT_PATTERN, "examples": ["0.1398 mm"]},
        ]
    }
)


class Expectation(CaseModel):
    """A scalar of the history, the value expected of it, and how far off it may be."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["rel"]}, {"required": ["abs"]}]})

    quantity: Annotated[
        str, AfterValidator(_known_quantity), Field(json_schema_extra={"enum": list(HISTORY_DIMENSIONS)})
    ] = Field(description="name of a scalar of the history, such as stick_radius", examples=["stick_radius"])
    value: Annotated[float, _ANY_QUANTITY] = Field(description="expected value, such as 0.1398 mm")
    rel: Annotated[float, InUnits(NUMBER, least=0)] | None = Field(
        default=None, description="largest deviation over the value, such as 0.01 or 1 %", examples=["1 %"]
    )
    abs: Annotated[float, _ANY_QUANTITY] | None = Field(
        default=None, description="largest deviation, such as 0.001 mm", examples=["0.001 mm"]
    )
    stage: Count | None = Field(
        default=None, description="stage at whose end to compare, from 1; the last by default", examples=[2]
    )

    @field_validator("value", "abs", mode="before")
    @classmethod
    def _of_the_quantity(cls, value: Any, info: ValidationInfo) -> Any:
        dimension = HISTORY_DIMENSIONS.get(info.data.get("quantity", ""))
        if dimension is None:
            return 0.0  # the quantity itself is refused
        least = 0.0 if info.field_name == "abs" else None
        return InUnits(dimension, least=least).read(value)

    @model_validator(mode="after")
    def _one_tolerance(self) -> Self:
        if (self.rel is None) == (self.abs is None):
            given = "neither is" if self.rel is None else "both are"
            raise refused(f"either rel or abs is needed; {given} given")
        if self.rel is not None and self.value == 0:
            raise refused("rel says nothing about a value of 0; abs is needed")
        return self
