"""The part of a case file that asks for fatigue parameters."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, field_validator, model_validator
from pydantic_core import CoreSchema

from fretsolve.case.base import CaseModel, PositiveLength, each_once, refused_at
from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.stress_spec import Bodies, Depths
from fretsolve.case.quantities import refused

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
