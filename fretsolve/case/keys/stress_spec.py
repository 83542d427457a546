"""The part of a case file that asks for stresses below the surface."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator

from fretsolve.case.base import CaseModel, Count, auto, each_once
from fretsolve.case.dimensions import LENGTH
from fretsolve.case.quantities import InUnits

Depth = Annotated[float, InUnits(LENGTH, least=0)]
Bodies = Annotated[
    tuple[Literal[1, 2], ...], Field(description="bodies; none for body 2, or 1 if that is rigid", examples=[[1, 2]])
]
Depths = Annotated[
    tuple[Depth, ...],
    Field(
        description="depths below the surface; none for the surface and graded ones to two contact radii",
        examples=[["0 mm", "5 um", "20 um"]],
    ),
]
StressComponent = Literal["xx", "yy", "zz", "xy", "xz", "yz"]

ALL_COMPONENTS: tuple[StressComponent, ...] = ("xx", "yy", "zz", "xy", "xz", "yz")


class StressSpec(CaseModel):
    """Stresses below the surface, computed at the end of the run and written beside the result (`NAME.stress.h5`)."""

    bodies: Bodies = ()
    depths: Depths = ()
    every: Annotated[Count | None, auto("10")] = Field(
        default=None,
        description="every n-th increment, if its fields are stored, and the last one, or auto: the ends of stages",
        examples=[10],
    )
    window: Literal["auto", "all"] = Field(
        default="auto",
        description="the cells: auto, the contact with a margin, as in `fretsolve stress`, or all, the whole grid",
    )
    components: tuple[StressComponent, ...] = Field(
        default=ALL_COMPONENTS, description="components to store; none to keep the largest stresses alone"
    )

    @field_validator("bodies", "depths", "components")
    @classmethod
    def _each_once(cls, values: tuple[object, ...]) -> tuple[object, ...]:
        return each_once(values)
