"""Validate `output`: the fields that the result keeps, stresses below the surface and fatigue parameters."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, field_validator, model_validator
from pydantic_core import CoreSchema

from fretsolve.case.base import CaseModel, Count, PositiveLength, auto, each_once, refused_at
from fretsolve.case.dimensions import LENGTH
from fretsolve.case.keys.material_spec import Material
from fretsolve.case.quantities import InUnits, refused

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


CriterionName = Literal["crossland", "dang-van", "findley", "mcdiarmid", "fatemi-socie", "swt"]
AverageKind = Literal["point", "line", "volume"]

KINDS: tuple[AverageKind, ...] = ("point", "line", "volume")


class MaterialFile:
    """Annotation of a material: in the file, the name of a file of it may stand in its place."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"type": "string"}, handler(schema)]}


class AverageSpec(CaseModel):
    """A length over which stresses are averaged before a parameter is taken, of one of three kinds."""

    point: PositiveLength | None = Field(
        default=None, description="the stress at half this length below the surface", examples=["20 um"]
    )
    line: PositiveLength | None = Field(
        default=None, description="its mean over depths from 0 to twice this length", examples=["20 um"]
    )
    volume: PositiveLength | None = Field(
        default=None, description="its mean over a cube of this side below the surface", examples=["20 um"]
    )

    @model_validator(mode="after")
    def _one(self) -> AverageSpec:
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            there = f"{' and '.join(given)} are given" if given else "none is given"
            raise refused(f"one of {', '.join(KINDS)} is needed, such as {{point: 20 um}}; {there}")
        return self

    @property
    def kind(self) -> AverageKind:
        """The key that is given."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def length(self) -> float:
        """Its length (mm)."""
        return float(getattr(self, self.kind))


class FatigueSpec(CaseModel):
    """Fatigue parameters over the last `cycle` of the load path, computed at the end of the run and written beside the
    result (`NAME.fatigue.h5`)."""

    material: Annotated[Material, MaterialFile()] = Field(
        description="constants of the material, or the name of a file of them, relative to the case file",
        examples=["steel.yaml"],
    )
    criteria: tuple[CriterionName, ...] = Field(min_length=1, description="criteria", examples=[["crossland", "swt"]])
    average: AverageSpec | None = Field(
        default=None, description="average stresses first", examples=[{"point": "20 um"}]
    )
    bodies: Bodies = ()
    depths: Depths = ()

    @field_validator("criteria", "bodies", "depths")
    @classmethod
    def _each_once(cls, values: tuple[object, ...]) -> tuple[object, ...]:
        return each_once(values)

    @model_validator(mode="after")
    def _depths_matter(self) -> FatigueSpec:
        if self.depths and self.average is not None:
            refused_at([(("depths",), "an average has depths of its own; remove one of the two")])
        return self


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
