"""Validate a case file by pydantic models of all its keys, in mm, N, MPa, rad."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import (
    AfterValidator,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from fretsolve.case.base import CaseModel, GridPoints, Position, PositiveLength, Repeated, auto, refused_at
from fretsolve.case.dimensions import LENGTH, Dimension
from fretsolve.case.expected import unjudged_quantities, unknown_quantities
from fretsolve.case.expression import Expression
from fretsolve.case.history import COMPONENTS, DIMENSIONS_BY_NAME, HISTORY_DIMENSIONS
from fretsolve.case.keys.body_specs import Body, RoughnessSurface, Surfaces
from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.keys.load_path_spec import LoadStep
from fretsolve.case.keys.output_spec import DEFAULT_FIELDS, OutputSpec, WearField
from fretsolve.case.keys.rig_spec import InterfaceSpec, RigSpec
from fretsolve.case.keys.settings_spec import Expectation, SolverSpec
from fretsolve.case.keys.unrolled_path import (
    Stage,
    bulk_keys,
    check_load_path,
    stage_count,
    stage_friction,
    unrolled,
    with_cycle_friction,
)
from fretsolve.case.keys.wear_spec import WearSpec, check_wear
from fretsolve.case.quantities import QuantityError, refused, to_internal
from fretsolve.case.source import CaseSource, Place
from fretsolve.errors import KeyPath


class GridSpec(CaseModel):
    """The potential contact area and its cells."""

    points: Annotated[tuple[GridPoints, GridPoints] | None, Repeated(2)] = Field(
        default=None,
        description="cells per side, or [nx, ny], such as 128; or solver.accuracy, which picks them",
        examples=[128, [128, 96]],
    )
    size: Annotated[tuple[PositiveLength, PositiveLength] | None, Repeated(2), auto("10 mm")] = Field(
        default=None, description="[lx, ly] of the potential contact area, one value for both, or auto: by the loads"
    )
    center: Position = Field(default=(0.0, 0.0), description="[x, y] of its centre", examples=[["0.1 mm", 0]])


def too_few_points(sides: Sequence[int], what: str = "error bars") -> str | None:
    """Return the message that so few points per side have no error bars, None if they have."""
    fewest = 16  # since the coarse runs have half of them
    if min(sides) >= fewest:
        return None
    few = " x ".join(map(str, sides))
    return f"{few} are too few for {what}; {fewest} or more per side are needed"


class Case(CaseModel):
    """Case file of fretsolve. A bare number is in mm, N, MPa, rad."""

    dimensions: ClassVar[Mapping[str, Dimension]] = HISTORY_DIMENSIONS
    """The quantities of the history with their dimensions."""

    title: str | None = Field(default=None, description="title of the case", examples=["Fretting mode I"])
    plane: Literal["strain"] | None = Field(
        default=None,
        description="strain for a line contact in plane strain; left out for a contact on an area",
        examples=["strain"],
    )
    bodies: tuple[Body, Body] = Field(
        description="body 1, which is loaded, and body 2, which is held",
        examples=[["rigid", {"young_modulus": "200 GPa", "poisson_ratio": 0.3}]],
    )
    surface: Surfaces = Field(
        description="undeformed separation: one surface, or a list of surfaces that add up",
        examples=[{"sphere": {"radius": "10 mm"}}],
    )
    # Parts that may be left out are constructed without validation, which would build their validators at each start.
    grid: GridSpec = Field(
        default=GridSpec.model_construct(), description="grid of the potential contact area", examples=[{"points": 128}]
    )
    friction: FrictionSpec = Field(
        default=FrictionSpec.model_construct(coefficient=0.0), description="coefficient of friction", examples=[0.1]
    )
    wear: WearSpec | None = Field(
        default=None,
        description="wear by the slip of the cycles that represent others",
        examples=[{"law": "energy", "alpha": "1e-4 mm^3/J"}],
    )
    coupling: Literal["auto", "none", "tangential", "full"] = Field(
        default="auto",
        description="influence coefficients that are kept: none (ux from qx, uy from qy, uz from p),"
        " tangential (also ux from qy, uy from qx), full (also between p and q), auto (those that the case needs)",
    )
    load_path: Annotated[tuple[LoadStep, ...], AfterValidator(check_load_path)] = Field(
        min_length=1,
        description="the stages, a list: each moves what it names to a new total",
        examples=[[{"P": "400 N"}, {"Qx": "36 N", "increments": 10}]],
    )
    reference_depth: PositiveLength | None = Field(
        default=None,
        description="with plane: strain, depth in both bodies of the points that move by delta_z and delta_x, which"
        " are unknown without it",
        examples=["10 mm"],
    )
    rig: RigSpec | None = Field(
        default=None,
        description="what gives between contact and actuator, in series with the contact",
        examples=[{"stiffness_x": "50 kN/mm"}],
    )
    interface: InterfaceSpec | None = Field(
        default=None,
        description="layer between the bodies that shears or is compressed",
        examples=[{"shear_compliance": "2e-5 mm/MPa"}],
    )
    solver: SolverSpec = Field(SolverSpec.model_construct(), description="accuracy and limits of the solver")
    output: OutputSpec = Field(OutputSpec.model_construct(), description="what the result holds")
    expect: tuple[Expectation, ...] = Field(
        default=(),
        description="what `fretsolve check` compares",
        examples=[[{"quantity": "stick_radius", "value": "0.1398 mm", "rel": "1 %", "stage": 2}]],
    )

    _source: CaseSource = PrivateAttr(default_factory=lambda: CaseSource(Path(), "", Place(1)))

    @property
    def source(self) -> CaseSource:
        """The file that the case was read from. Comparisons leave it out."""
        source = self._source
        return source if source.data is not None else replace(source, data={"load_path": self.load_path})

    def stages(self) -> tuple[Stage, ...]:
        """Return the load path with its cycles unrolled."""
        stages = unrolled(self.load_path)
        return stages if self.friction.cycles is None else tuple(with_cycle_friction(stages, self.friction.in_cycle))

    @property
    def friction_varies(self) -> bool:
        """True if the friction limit is anything but one coefficient times the pressure."""
        return not self.friction.is_constant or bool(stage_friction(self.load_path))

    def effective(self) -> dict[str, Any]:
        """Return the case with every default filled in, as a case file has it, in values that JSON can hold."""
        return dict(_without_none(self.model_dump(mode="json")))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.values()))

    @field_validator("bodies")
    @classmethod
    def _one_deforms(cls, bodies: tuple[Body, Body]) -> tuple[Body, Body]:
        if all(body == "rigid" for body in bodies):
            raise refused("both bodies are rigid; at least one must be elastic")
        return bodies

    @field_validator("load_path")
    @classmethod
    def _bulk_stress_is_in_elastic_bodies(
        cls, load_path: tuple[LoadStep, ...], info: ValidationInfo
    ) -> tuple[LoadStep, ...]:
        rigid = [f"bulk_{body}" for body, kind in enumerate(info.data.get("bodies", ()), start=1) if kind == "rigid"]
        if rigid:
            refused_at(
                (key, f"body {str(key[-1])[-1]} is rigid, so it has no bulk stress; an elastic body is needed")
                for key in bulk_keys(load_path)
                if key[-1] in rigid
            )
        return load_path

    @model_validator(mode="after")
    def _depth_of_a_line(self) -> Self:
        if self.plane is None and self.reference_depth is not None:
            refused_at([(("reference_depth",), "only a line contact needs it; remove it, or add plane: strain")])
        return self

    @model_validator(mode="after")
    def _actuator_has_a_rig(self) -> Self:
        if self.rig is None:
            moved = ((stage, name) for stage in unrolled(self.load_path) for name, _ in stage.targets)
            refused_at(
                (stage.place(name), f"no actuator without a rig; add rig: {{stiffness_{name[9:]}: ...}} to the case")
                for stage, name in moved
                if name.startswith("actuator_")
            )
        return self

    @model_validator(mode="after")
    def _expected_is_known(self) -> Self:
        if self.expect:
            refused_at(unknown_quantities(self.expect, unrolled(self.load_path), self.output, rig=self.rig is not None))
        if self.solver.accuracy is not None and (of := self.solver.accuracy.of):
            has = {"rig": self.rig is not None, "wear": self.wear is not None}
            refused_at(unjudged_quantities(of, unrolled(self.load_path), **has))
        return self

    @model_validator(mode="after")
    def _accuracy_has_error_bars(self) -> Self:
        solver = self.solver
        if solver.accuracy is not None and self.wear is None and "error_bars" in solver.model_fields_set:
            message = "without error bars nothing tells what a round is known to; leave the key out"
            refused_at([(("solver", "error_bars"), message)] if not solver.error_bars else [])
        return self

    @model_validator(mode="after")
    def _friction_can_change(self) -> Self:
        if not isinstance(self.friction.coefficient, float):
            refused_at(
                (stage.key, "a stage can change friction only where it is one coefficient; remove it here")
                for stage in unrolled(self.load_path)
                if "friction" in dict(stage.targets)
            )
        return self

    @model_validator(mode="before")
    @classmethod
    def _worn_depth_is_stored(cls, value: Any) -> Any:
        output = value.get("output", {}) if isinstance(value, dict) and value.get("wear") is not None else None
        if isinstance(output, dict) and "fields" not in output:
            return {**value, "output": {**output, "fields": [*DEFAULT_FIELDS, "wear_depth"]}}
        return value

    @model_validator(mode="before")
    @classmethod
    def _roughness_has_the_span_of_the_grid(cls, value: Any) -> Any:
        if not isinstance(value, dict) or (span := _longer_side(value.get("grid"))) is None:
            return value
        surface = value.get("surface")
        entries = [_with_span(one, span) for one in (surface if isinstance(surface, list | tuple) else [surface])]
        return {**value, "surface": entries if isinstance(surface, list | tuple) else entries[0]}

    @model_validator(mode="after")
    def _roughness_has_a_span(self) -> Self:
        message = "span is missing, and grid.size is auto; give the period, such as 0.5 mm"
        lacking = (i for i, one in enumerate(self.surface) if isinstance(one, RoughnessSurface) and one.span is None)
        refused_at((("surface", index, "roughness"), message) for index in lacking)
        return self

    @model_validator(mode="after")
    def _wear_fits(self) -> Self:
        if self.wear is None:
            refused_at(
                (("output", "fields", place), f"{name} belongs to wear, which the case does not have; leave it out")
                for place, name in enumerate(self.output.fields)
                if name in get_args(WearField)
            )
        elif self.solver.error_bars:
            message = "coarse runs cannot follow wear; leave it out, wear_error estimates the error by the jumps"
            refused_at([(("solver", "error_bars"), message)])
        elif self.solver.precision == "single":
            message = "single precision cannot resolve the small slips by which a contact follows its wear; take double"
            refused_at([(("solver", "precision"), message)])
        coefficient = self.friction.coefficient
        friction = coefficient if isinstance(coefficient, float) else None
        check_wear(self.wear, unrolled(self.load_path), friction, {**DIMENSIONS_BY_NAME, **self.dimensions})
        return self

    @model_validator(mode="after")
    def _friction_has_the_variables_of_a_line(self) -> Self:
        formula = self.friction.expression
        if self.plane is not None and formula is not None and Expression(formula).uses("y"):
            message = "a line contact has no y; a formula of x or r = |x| is needed"
            refused_at([(("friction", "expression"), message)])
        return self

    @model_validator(mode="after")
    def _two_coefficients_are_solved(self) -> Self:
        if self.friction.pair is None:
            return self
        key: KeyPath = ("friction", "coefficient")
        if self.plane is not None:
            refused_at([(key, "a line contact has one coefficient of friction; give one number")])
        turned = not math.isclose(math.sin(2.0 * (self.friction.angle or 0.0)), 0.0, abs_tol=1e-12)
        forced = {"Qx": True, "Qy": True}
        for stage in unrolled(self.load_path):
            for name, value in stage.targets:
                if name == "Mz" or (name in COMPONENTS[5] and value):
                    refused_at([(stage.key, "two coefficients of friction are not solved with torsion; give one")])
                if name in (*COMPONENTS[3], *COMPONENTS[4]):
                    forced["Qx" if name in COMPONENTS[3] else "Qy"] = name[0] == "Q"
            if turned and forced["Qx"] != forced["Qy"]:
                message = "with friction.angle forces or displacements are needed along x and y both, not one of each"
                refused_at([(stage.key, message)])
        return self

    @model_validator(mode="after")
    def _enough_points(self) -> Self:
        if self.grid.points is None:
            if self.solver.accuracy is None:
                lacking = ("grid", "points") if "grid" in self.model_fields_set else ("grid",)
                raise ValidationError.from_exception_data("case", [{"type": "missing", "loc": lacking, "input": None}])
            return self
        implied = self.solver.accuracy is not None and "error_bars" not in self.solver.model_fields_set
        what = "the error bars that solver.accuracy takes" if implied else "error bars"
        message = too_few_points(self.grid.points[: 1 if self.plane else 2], what)
        if message is not None and (self.solver.error_bars or implied):
            refused_at([(("grid", "points"), message)])
        return self

    @model_validator(mode="after")
    def _stress_is_known(self) -> Self:
        output = self.output
        crack = output.crack
        chosen: dict[str, list[tuple[KeyPath, int]]] = {
            name: [(("bodies", index), body) for index, body in enumerate(spec.bodies)]
            for name, spec in (("stress", output.stress), ("fatigue", output.fatigue))
            if spec is not None
        }
        if crack is not None:
            chosen["crack"] = [] if crack.body is None else [(("body",), crack.body)]
        for name, bodies in chosen.items():
            refused_at(
                (("output", name, *key), f"body {body} is rigid, so that it has no stress; leave it out")
                for key, body in bodies
                if self.bodies[body - 1] == "rigid"
            )
            if missing := [field for field in ("pressure", "shear") if field not in output.fields]:
                message = f"stresses follow from pressure and shear; output.fields needs {' and '.join(missing)}"
                refused_at([(("output", name), message)])
        return self

    @field_validator("expect")
    @classmethod
    def _stages_exist(cls, expect: tuple[Expectation, ...], info: ValidationInfo) -> tuple[Expectation, ...]:
        if "load_path" in info.data:  # not refused itself
            count = stage_count(info.data["load_path"])
            refused_at(
                ((i, "stage"), f"{wanted.stage} is beyond the load path; a stage from 1 to {count} is needed")
                for i, wanted in enumerate(expect)
                if wanted.stage is not None and wanted.stage > count
            )
        return expect


def _longer_side(grid: Any) -> float | None:
    """Return the longer side (mm) of a grid as the file has it; None if there is none, which the grid refuses."""
    size = grid.get("size") if isinstance(grid, dict) else None
    try:
        side = max(to_internal(side, LENGTH) for side in (size if isinstance(size, list | tuple) else [size]))
    except (QuantityError, ValueError):  # auto, no length, or no sides
        return None
    return side if side > 0.0 else None


def _with_span(surface: Any, span: float) -> Any:
    """Return a surface as the file has it, and roughness without a span with this one."""
    keys = surface.get("roughness") if isinstance(surface, dict) else None
    return {**surface, "roughness": {"span": span, **keys}} if isinstance(keys, dict) else surface


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list) else value
