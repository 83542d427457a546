"""Validate `solver` and `expect`: accuracy and limits of the solver, and the values that `fretsolve check` compares."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    StrictBool,
    ValidationInfo,
    WithJsonSchema,
    field_serializer,
    field_validator,
    model_validator,
)

from fretsolve.case.base import CaseModel, Count, refused_at, require_either
from fretsolve.case.cycle_quantities import ACTUATOR
from fretsolve.case.dimensions import NUMBER, Dimension
from fretsolve.case.history import CORRECTED_SUFFIX, ERROR_SUFFIX, HISTORY_DIMENSIONS
from fretsolve.case.keys.accuracy_spec import Accuracy
from fretsolve.case.keys.quantity_names import EXPECTED_DIMENSIONS, MAYBE_ENDLESS, dataset_name
from fretsolve.case.other_names import close_name
from fretsolve.case.quantities import TEXT_PATTERN, InUnits, refused, shown

SINGLE_TOLERANCE = 1e-4
"""Default tolerance in single precision."""

LEAST_SINGLE_TOLERANCE = 1e-5
"""The least tolerance that single precision certifies in most cases (docs/performance.md)."""


class SolverSpec(CaseModel):
    """Accuracy, tolerance and limits of the solver."""

    accuracy: Accuracy | None = Field(
        default=None,
        description="accuracy of the results, such as 1 %, which picks points, automatic increments and tolerance"
        " unless they are given, and error bars, which show if it is met",
        examples=["1 %", {"target": "1 %", "of": ["Qx", "work_total"], "at_most": {"time": "10 min"}}],
    )
    refinement: Annotated[float, InUnits(NUMBER, above=0, most=1000)] | None = Field(
        default=None,
        description="factor on automatic numbers of increments where there is more than one; by default 1, or what"
        " accuracy picks",
        examples=[2],
    )
    tolerance: Annotated[float, InUnits(NUMBER, above=1e-15, below=1)] = Field(
        default=1e-6, description="largest residual of the contact conditions", examples=[1e-6]
    )
    precision: Literal["double", "single"] = Field(
        default="double",
        description="precision of the elastic operator and the fields; single takes less memory on large grids, and"
        " smaller files",
    )
    max_iterations: Count = Field(default=2000, description="most iterations of one solve")
    error_bars: StrictBool = Field(
        default=False, description="whether the history has error bars, and corrected values, from coarse runs"
    )

    @model_validator(mode="before")
    @classmethod
    def _tolerance_of_precision(cls, value: Any) -> Any:
        if isinstance(value, dict) and value.get("precision") == "single":
            return {"tolerance": SINGLE_TOLERANCE, **value}
        return value

    @model_validator(mode="after")
    def _certifiable(self) -> Self:
        if self.precision == "single" and self.tolerance < LEAST_SINGLE_TOLERANCE:
            message = f"{self.tolerance:g} is less than single precision can certify"
            message += f"; {LEAST_SINGLE_TOLERANCE:g} or more is needed, or precision: double"
            refused_at([(("tolerance",), message)])
        return self


def _known_quantity(name: str) -> str:
    """Return the name of a quantity as it stands in tables, with underscores for hyphens."""
    found = dataset_name(name)
    if found not in EXPECTED_DIMENSIONS:
        as_run = found.removesuffix(ERROR_SUFFIX).removesuffix(CORRECTED_SUFFIX)
        counts = {known for known, dimension in HISTORY_DIMENSIONS.items() if dimension == NUMBER}  # they are rare
        known = [name for name in EXPECTED_DIMENSIONS if name not in counts]
        others = [name for name in known if name not in HISTORY_DIMENSIONS and not name.startswith(ACTUATOR)]
        advice = f"a scalar of the history, such as stick_radius, or one of {', '.join(others)} is needed"
        if (meant := close_name(found, known)) is not None:
            advice = f"did you mean {meant!r}?"
        if as_run in known:
            advice = f"values as run are: {as_run} is needed"
        raise refused(f"{shown(name)} is not a quantity that can be compared; {advice}")
    return found


_ANY_QUANTITY = WithJsonSchema(
    {"anyOf": [{"type": "number"}, {"type": "string", "pattern": TEXT_PATTERN, "examples": ["0.1398 mm"]}]}
)


class Expectation(CaseModel):
    """A quantity of the result, the value expected of it, and how far off it may be.

    It is a scalar of the history at the end of a stage, a quantity of a cycle, the largest stress at the end of a stage
    (with `output.stress`), a fatigue parameter or life (`output.fatigue`), or of a crack (`output.crack`).
    """

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["rel"]}, {"required": ["abs"]}]})
    dimensions: ClassVar[Mapping[str, Dimension]] = EXPECTED_DIMENSIONS

    quantity: Annotated[
        str, AfterValidator(_known_quantity), Field(json_schema_extra={"enum": list(EXPECTED_DIMENSIONS)})
    ] = Field(
        description="name of a scalar of the history, such as stick_radius, of a quantity of a cycle, such as"
        " energy_ratio, or of the files beside the result, such as swt_life",
        examples=["stick_radius"],
    )
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
    cycle: Count | None = Field(
        default=None, description="cycle of a quantity of cycles, from 1; the last by default", examples=[1]
    )

    @field_validator("value", "abs", mode="before")
    @classmethod
    def _of_the_quantity(cls, value: Any, info: ValidationInfo) -> Any:
        dimension = cls.dimensions.get(info.data.get("quantity", ""))
        if dimension is None:
            return 0.0  # the quantity itself is refused
        if info.field_name == "value" and info.data["quantity"] in MAYBE_ENDLESS and value in (math.inf, ".inf"):
            return math.inf
        least = 0.0 if info.field_name == "abs" else None
        return InUnits(dimension, least=least).read(value)

    @model_validator(mode="after")
    def _one_tolerance(self) -> Self:
        require_either(self, "rel", "abs")
        if self.rel is not None and self.value in (0.0, math.inf):
            raise refused(f"rel says nothing about a value of {self.value:g}; abs is needed")
        return self

    @field_serializer("value", when_used="json")
    def _as_json(self, value: float) -> float | str:
        """JSON has no number for an infinite value."""
        return ".inf" if math.isinf(value) else value
