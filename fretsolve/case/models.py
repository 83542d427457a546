"""The models of a case file: all that it states, in mm, N, MPa, rad."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, StrictBool, ValidationError, ValidationInfo, field_validator, model_validator
from pydantic_core import CoreSchema, core_schema

from .base import Auto, CaseModel, Count, Position, PositiveLength, Repeated, refused_at
from .expectations import Expectation
from .load_path_spec import LoadStep, Stage, check_load_path, stage_count, unrolled
from .quantities import NUMBER, PRESSURE, InUnits, refused, shown
from .source import CaseSource, Place
from .surface_specs import Surfaces

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

FEWEST_POINTS = 16
"""Per side, with error bars: the coarse runs have half of them."""

SINGLE_TOLERANCE = 1e-4
"""The default in single precision."""

LEAST_SINGLE_TOLERANCE = 1e-5
"""The least tolerance that single precision certifies in most cases (docs/performance.md)."""

FieldName = Literal["pressure", "shear", "slip", "slip_path", "work_density", "zone", "gap"]


class ElasticBody(CaseModel):
    """A linear elastic, isotropic half-space."""

    young_modulus: Annotated[float, InUnits(PRESSURE, above=0)] = Field(
        description="Young's modulus, such as 200 GPa"
    )
    poisson_ratio: Annotated[float, InUnits(NUMBER, above=-1, most=0.5)] = Field(
        description="Poisson's ratio, such as 0.3", examples=[0.3]
    )


class RigidBody(CaseModel):
    """A body that does not deform."""


class _FromFile:
    """Annotation of a body: ``rigid``, or the mapping of an elastic one."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_wrap_validator_function(
            self._read,
            handler.generate_schema(ElasticBody),
            serialization=core_schema.plain_serializer_function_ser_schema(self._write),
        )

    def _read(self, value: Any, elastic: core_schema.ValidatorFunctionWrapHandler) -> ElasticBody | RigidBody:
        if value == "rigid" or isinstance(value, RigidBody):
            return RigidBody()
        if not isinstance(value, dict | ElasticBody):
            needed = "rigid or {young_modulus: 200 GPa, poisson_ratio: 0.3}"
            raise refused(f"{shown(value)} is not a body; {needed} is needed")
        body: ElasticBody = elastic(value)
        return body

    def _write(self, body: ElasticBody | RigidBody) -> object:
        return "rigid" if isinstance(body, RigidBody) else body.model_dump(mode="json")

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"const": "rigid"}, handler(schema)]}


Body = Annotated[ElasticBody | RigidBody, _FromFile()]


class GridSpec(CaseModel):
    """The potential contact area and its cells."""

    points: Annotated[tuple[Count, Count] | None, Repeated(2)] = Field(
        default=None,
        description="cells per side, or [nx, ny], such as 128; or solver.accuracy, which picks them",
        examples=[128, [128, 96]],
    )
    size: Annotated[tuple[PositiveLength, PositiveLength] | None, Repeated(2), Auto("10 mm")] = Field(
        default=None, description="[lx, ly] of the potential contact area, one value for both, or auto: by the loads"
    )
    center: Position = Field(default=(0.0, 0.0), description="[x, y] of its centre", examples=[["0.1 mm", 0]])


class FrictionSpec(CaseModel):
    """Coulomb friction."""

    coefficient: Annotated[float, InUnits(NUMBER, least=0)] = Field(
        description="coefficient of friction, such as 0.1"
    )

    @model_validator(mode="before")
    @classmethod
    def _from_number(cls, value: Any) -> Any:
        return value if isinstance(value, dict | list | FrictionSpec) else {"coefficient": value}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        mapping = handler(schema)
        return {"anyOf": [handler.resolve_ref_schema(mapping)["properties"]["coefficient"], mapping]}


LEVELS = {"draft": 0.05, "standard": 0.01, "reference": 0.002}
"""The accuracy that each name stands for."""

SHARE = InUnits(NUMBER, least=1e-4, most=0.2)


@dataclass(frozen=True)
class Accuracy:
    """Annotation of an optional float: in the file, a share such as ``1 %``, or the name of a level."""

    def read(self, value: object) -> object:
        """Return the share that a number or a level stands for."""
        if isinstance(value, str) and value in LEVELS:
            return LEVELS[value]
        if isinstance(value, str) and not any(map(str.isdigit, value)):
            names = ", ".join(LEVELS)
            raise refused(f"{shown(value)} is not allowed; {names} or a number such as 1 % is needed")
        return value if value is None else SHARE.read(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        share = SHARE.__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [{"enum": list(LEVELS)}, *share["anyOf"]]}


class SolverSpec(CaseModel):
    """Accuracy, tolerance and limits of the solver."""

    accuracy: Annotated[float | None, Accuracy()] = Field(
        default=None,
        description="accuracy of the results, such as 1 %, or draft (5 %), standard (1 %), reference (0.2 %); it picks"
        " points, automatic increments and tolerance unless they are given, and error bars, which tell if it is met",
        examples=["1 %"],
    )

    tolerance: Annotated[float, InUnits(NUMBER, above=1e-15, below=1)] = Field(
        default=1e-6, description="bound on the residuals of the contact conditions", examples=[1e-6]
    )
    precision: Literal["double", "single"] = Field(
        default="double",
        description="precision of the elastic operator and the fields; single takes less memory on large grids, and"
        " smaller files",
    )
    max_iterations: Count = Field(default=2000, description="most iterations of one solve")
    error_bars: StrictBool = Field(
        default=False, description="whether the history has error bars, from coarse runs on half of the points"
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
            message = (
                f"{self.tolerance:g} is less than single precision can certify; {LEAST_SINGLE_TOLERANCE:g} or more is"
                " needed, or precision: double"
            )
            refused_at([(("tolerance",), message)])
        return self


class OutputSpec(CaseModel):
    """Which fields the result keeps; `shear` and `slip` stand for both of their components."""

    fields: tuple[FieldName, ...] = Field(
        default=("pressure", "shear", "slip", "zone"), description="fields to store"
    )
    every: Count = Field(default=1, description="fields are stored at every n-th increment")

    @field_validator("fields")
    @classmethod
    def _each_once(cls, names: tuple[FieldName, ...]) -> tuple[FieldName, ...]:
        repeated = [(i, name) for i, name in enumerate(names) if name in names[:i]]
        refused_at(((i,), f"{name!r} is named twice; once is enough") for i, name in repeated)
        return names


class Case(CaseModel):
    """Case file of fretsolve. A bare number is in mm, N, MPa, rad."""

    title: str | None = Field(default=None, description="title of the case", examples=["Fretting mode I"])
    bodies: tuple[Body, Body] = Field(
        description="body 1, which is loaded, and body 2, which is held",
        examples=[["rigid", {"young_modulus": "200 GPa", "poisson_ratio": 0.3}]],
    )
    surface: Surfaces = Field(
        description="undeformed separation: one surface, or a list of surfaces that add up",
        examples=[{"sphere": {"radius": "10 mm"}}],
    )
    grid: GridSpec = Field(
        default=GridSpec(), description="grid of the potential contact area", examples=[{"points": 128}]
    )
    friction: FrictionSpec = Field(
        default=FrictionSpec(coefficient=0.0), description="coefficient of friction", examples=[0.1]
    )
    coupling: Literal["auto", "none", "tangential", "full"] = Field(
        default="auto",
        description="influence coefficients that are kept: none (ux from qx, uy from qy, uz from p),"
        " tangential (also ux from qy, uy from qx), full (also between p and q), auto (those that the case needs)",
    )
    load_path: tuple[LoadStep, ...] = Field(
        min_length=1,
        description="the stages, a list: each moves what it names to a new total",
        examples=[[{"P": "400 N"}, {"Qx": "36 N", "increments": 10}]],
    )
    solver: SolverSpec = Field(SolverSpec(), description="accuracy and limits of the solver")
    output: OutputSpec = Field(OutputSpec(), description="what the result holds")
    expect: tuple[Expectation, ...] = Field(
        default=(),
        description="what `fretsolve check` compares",
        examples=[[{"quantity": "stick_radius", "value": "0.1398 mm", "rel": "1 %", "stage": 2}]],
    )

    _source: CaseSource = PrivateAttr(default_factory=lambda: CaseSource(Path(), "", Place(1)))

    @property
    def source(self) -> CaseSource:
        """The file that the case was read from. Comparisons leave it out."""
        return self._source

    def stages(self) -> tuple[Stage, ...]:
        """Return the load path with its cycles unrolled."""
        return unrolled(self.load_path)

    def effective(self) -> dict[str, Any]:
        """Return the case with every default filled in, as a case file has it, in values that JSON can hold."""
        written: dict[str, Any] = _without_none(self.model_dump(mode="json"))
        return written

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.values()))

    @field_validator("bodies")
    @classmethod
    def _one_deforms(cls, bodies: tuple[Body, Body]) -> tuple[Body, Body]:
        if all(isinstance(body, RigidBody) for body in bodies):
            raise refused("both bodies are rigid; at least one must be elastic")
        return bodies

    @field_validator("load_path")
    @classmethod
    def _runnable(cls, load_path: tuple[LoadStep, ...]) -> tuple[LoadStep, ...]:
        return check_load_path(load_path)

    @model_validator(mode="after")
    def _enough_points(self) -> Self:
        if self.grid.points is None:
            if self.solver.accuracy is None:
                lacking = ("grid", "points") if "grid" in self.model_fields_set else ("grid",)
                raise ValidationError.from_exception_data("case", [{"type": "missing", "loc": lacking, "input": None}])
            return self
        implied = self.solver.accuracy is not None and "error_bars" not in self.solver.model_fields_set
        if (self.solver.error_bars or implied) and min(self.grid.points) < FEWEST_POINTS:
            nx, ny = self.grid.points
            message = f"{nx} x {ny} are too few for error bars; {FEWEST_POINTS} or more per side are needed"
            refused_at([(("grid", "points"), message)])
        return self

    @field_validator("expect")
    @classmethod
    def _stages_exist(cls, expect: tuple[Expectation, ...], info: ValidationInfo) -> tuple[Expectation, ...]:
        if "load_path" not in info.data:  # refused itself
            return expect
        count = stage_count(info.data["load_path"])
        refused_at(
            ((i, "stage"), f"{wanted.stage} is beyond the load path; a stage from 1 to {count} is needed")
            for i, wanted in enumerate(expect)
            if wanted.stage is not None and wanted.stage > count
        )
        return expect


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list) else value
