"""Validate `output`: what the result keeps."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from fretsolve.case.base import CaseModel, Count, each_once
from fretsolve.case.keys.fatigue_spec import FatigueSpec
from fretsolve.case.keys.stress_spec import StressSpec

WearField = Literal["wear_depth", "wear_depth_1", "wear_depth_2"]
FieldName = Literal[
    "pressure", "shear", "slip", "slip_path", "work_density", "zone", "gap", "friction", "shear_bound", WearField
]
DEFAULT_FIELDS: tuple[FieldName, ...] = ("pressure", "shear", "slip", "zone")


class OutputSpec(CaseModel):
    """The fields that the result keeps; `shear` and `slip` stand for both of their components."""

    fields: tuple[FieldName, ...] = Field(
        default=DEFAULT_FIELDS, description="fields to store; with wear, wear_depth is among them if they are left out"
    )
    every: Count = Field(default=1, description="fields are stored at every n-th increment")
    stress: StressSpec | None = Field(
        default=None, description="stresses below the surface at the end of the run", examples=[{"bodies": [2]}]
    )
    fatigue: FatigueSpec | None = Field(default=None, description="fatigue parameters at the end of the run")

    @field_validator("fields")
    @classmethod
    def _each_once(cls, names: tuple[FieldName, ...]) -> tuple[FieldName, ...]:
        return each_once(names)
