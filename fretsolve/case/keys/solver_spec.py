"""Validate `solver`: accuracy, tolerance and limits."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, StrictBool, model_validator

from fretsolve.case.base import CaseModel, Count, Named, refused_at
from fretsolve.case.dimensions import NUMBER
from fretsolve.case.quantities import InUnits

SINGLE_TOLERANCE = 1e-4
"""Default tolerance in single precision."""

LEAST_SINGLE_TOLERANCE = 1e-5
"""The least tolerance that single precision certifies in most cases (docs/performance.md)."""

LEVELS = {"draft": 0.05, "standard": 0.01, "reference": 0.002}
"""The accuracy that each name stands for."""


class SolverSpec(CaseModel):
    """Accuracy, tolerance and limits of the solver."""

    accuracy: (
        Annotated[
            float,
            InUnits(NUMBER, least=1e-4, most=0.2, share=True),
            Named(LEVELS, f"is not allowed; {', '.join(LEVELS)} or a number such as 1 %"),
        ]
        | None
    ) = Field(
        default=None,
        description="accuracy of the results, such as 1 %, or draft (5 %), standard (1 %), reference (0.2 %); it picks"
        " points, automatic increments and tolerance unless they are given, and error bars, which show if it is met",
        examples=["1 %"],
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
