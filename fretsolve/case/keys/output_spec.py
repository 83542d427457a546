"""Validate `output`: the fields that the result keeps, stresses below the surface, fatigue parameters and a crack."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, field_validator, model_validator
from pydantic_core import CoreSchema, core_schema

from fretsolve.case.base import CaseModel, Count, Length, PositiveLength, auto, each_once, refused_at
from fretsolve.case.dimensions import LENGTH, NUMBER
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


CriterionName = Literal["crossland", "dang-van", "findley", "mcdiarmid", "fatemi-socie", "swt", "ruiz-1", "ruiz-2"]
LifeCriterion = Literal["swt", "fatemi-socie"]
"""Criteria with a life curve."""

LIFE_CURVES: dict[LifeCriterion, str] = {"swt": "strain_life", "fatemi-socie": "shear_strain_life"}
"""The constants of the material from which the life of a criterion follows."""

AverageKind = Literal["point", "line", "volume"]

KINDS: tuple[AverageKind, ...] = ("point", "line", "volume")


class MaterialFile:
    """Annotation of a material: in the file, the name of a material file may stand in its place."""

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


class WithHyphens:
    """Annotation of the name of a criterion: in the file, underscores may stand for hyphens."""

    def read(self, name: object) -> object:
        """Return the name with hyphens, as in dang-van."""
        return name.replace("_", "-") if isinstance(name, str) else name

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        inner = handler(schema)
        other = [name.replace("-", "_") for name in inner["enum"] if "-" in name]
        return {"anyOf": [inner, {"enum": other, "type": "string"}]}


CycleNumber = Annotated[int, Field(strict=True, ge=1)]


class CyclesSpec(CaseModel):
    """The cycles of the load path that count, and how often each of them occurs."""

    cycle: Literal["last", "all"] | CycleNumber = Field(
        default="last",
        description="the cycle that counts: last, all for each once, or its number in the table of cycles; a load path"
        " without a cycle counts as one",
        examples=["last"],
    )
    blocks: dict[int, Annotated[float, InUnits(NUMBER, above=0)]] | None = Field(
        default=None,
        description="a block that is repeated: numbers of cycles, and how often each of them occurs in it; damage adds"
        " up by Miner's rule",
        examples=[{1: 1000, 2: 10}],
    )

    @field_validator("blocks")
    @classmethod
    def _counted_from_one(cls, blocks: dict[int, float] | None) -> dict[int, float] | None:
        if blocks is not None:
            refused_at(((number,), f"{number} is no cycle; cycles count from 1") for number in blocks if number < 1)
            if not blocks:
                raise refused("no cycle is named; a block such as {1: 1000, 2: 10} is needed")
        return blocks

    @model_validator(mode="after")
    def _cycle_or_blocks(self) -> Self:
        if self.blocks is not None and "cycle" in self.model_fields_set:
            refused_at([(("cycle",), "blocks names the cycles; remove one of the two")])
        return self

    @property
    def chosen(self) -> Literal["last", "all"] | int | dict[int, float]:
        """The cycle, or the block."""
        return self.blocks if self.blocks is not None else self.cycle


class FatigueSpec(CyclesSpec):
    """Fatigue parameters over cycles of the load path, computed at the end of the run and written beside the result
    (`NAME.fatigue.h5`)."""

    material: Annotated[Material, MaterialFile()] = Field(
        description="constants of the material, or the name of a file of them, relative to the case file",
        examples=["steel.yaml"],
    )
    criteria: tuple[Annotated[CriterionName, WithHyphens()], ...] = Field(
        min_length=1, description="criteria", examples=[["crossland", "swt"]]
    )
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


class CrackSpec(CyclesSpec):
    """Stress intensity, arrest and life of a crack from the surface, computed at the end of the run and written beside
    the result (`NAME.crack.h5`)."""

    material: Annotated[Material, MaterialFile()] = Field(
        default=Material(),
        description="constants of the material, or the name of a file of them, relative to the case file; stress"
        " intensity needs none of them",
        examples=["aluminium.yaml"],
    )
    at: Literal["edge", "max"] | Length = Field(
        default="edge",
        description="x of the crack: edge, the edge of the contact with the larger tension, max, where the fatigue"
        " parameter on the surface is largest, or a length",
        examples=["0.1 mm"],
    )
    body: Literal[1, 2] | None = Field(
        default=None, description="the body that may crack; by default 2, or 1 if that is rigid", examples=[2]
    )
    criterion: Annotated[LifeCriterion, WithHyphens()] | None = Field(
        default=None,
        description="the parameter that gives the cycles to a crack; by default swt, or fatemi-socie if the material"
        " has only the life curve of shear strain",
    )
    final_length: PositiveLength | None = Field(
        default=None,
        description="length of the crack at which life ends; by default where toughness or thickness is reached",
        examples=["2 mm"],
    )
    thickness: PositiveLength | None = Field(
        default=None,
        description="thickness of the body, at which life ends at the latest; K is right for cracks of a tenth of it",
        examples=["10 mm"],
    )


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
    crack: CrackSpec | None = Field(default=None, description="a crack from the surface at the end of the run")

    @field_validator("fields")
    @classmethod
    def _each_once(cls, names: tuple[FieldName, ...]) -> tuple[FieldName, ...]:
        return each_once(names)
