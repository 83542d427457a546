"""The case of a line contact (`plane: strain`): one row of cells along x, and loads per mm of the line's length.

The models have the attributes of the models of a contact on an area, without the keys that a line has no use for, so
that the other modules read both alike.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    AfterValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    Tag,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema, core_schema

from fretsolve.case.base import CaseModel, GridPoints, Length, PositiveLength, Repeated, refused_at
from fretsolve.case.dimensions import LENGTH, LINE_FORCE, LINE_MOMENT, LINE_STIFFNESS, LINE_TURNING_STIFFNESS, Dimension
from fretsolve.case.history import COMPONENTS, LINE_DIMENSIONS, LINE_MEANINGS
from fretsolve.case.keys.body_specs import CylinderSurface, OneSurface, PunchSurface, RoughnessSurface, read_from
from fretsolve.case.keys.load_path_spec import (
    AmplitudeCycle,
    BulkStress,
    Cycle,
    CycleSpec,
    StageSpec,
    cycle_tag,
    exclusive,
    step_tag,
)
from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.keys.quantity_names import LINE_EXPECTED_DIMENSIONS
from fretsolve.case.keys.rig_spec import RigSpec
from fretsolve.case.keys.settings_spec import Expectation
from fretsolve.case.keys.unrolled_path import check_load_path
from fretsolve.case.models import Case, GridSpec
from fretsolve.case.quantities import InUnits, refused, shown


@dataclass(frozen=True)
class AlongX:
    """Annotation of a pair (along x, along y): in the file, the value along x alone.

    other: the value along y; None for the value along x. automatic: whether `auto` stands for None.
    """

    other: float | None = None
    automatic: bool = False

    def read(self, value: object) -> object:
        """Return the pair that a value stands for; a pair of the default, and None, stay."""
        if isinstance(value, list):
            raise refused(f"{shown(value)} is a list; with plane: strain one value is needed, that along x")
        if value is None or isinstance(value, tuple):
            return value
        if self.automatic and value == "auto":
            return None
        return value, value if self.other is None else self.other

    def write(self, value: Any) -> object:
        """Return what stands for a pair in a file."""
        return ("auto" if self.automatic else None) if value is None else value[0]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        writer = core_schema.plain_serializer_function_ser_schema(self.write)
        return core_schema.no_info_before_validator_function(self.read, handler(source), serialization=writer)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        inner = handler(schema)
        array = next(node for node in inner.get("anyOf", [inner]) if node.get("type") == "array")
        one = dict(array["prefixItems"][0])
        return {"anyOf": [{"const": "auto"}, *one.get("anyOf", [one])]} if self.automatic else one


Place = Annotated[tuple[Length, Length], AlongX(0.0)]
_PLACE = Field(
    default=(0.0, 0.0), description="x of the surface's origin", examples=["0.1 mm"], json_schema_extra={"default": 0.0}
)


class _LineModel(CaseModel):
    """A mapping that refuses, with a reason, keys that only a contact on an area has; their values stay None."""

    refused_keys: ClassVar[Mapping[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _of_a_line(cls, value: Any) -> Any:
        if isinstance(value, dict):
            refused_at(((key,), reason) for key, reason in cls.refused_keys.items() if key in value)
        return value

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        node = handler(schema)
        for key in cls.refused_keys:
            handler.resolve_ref_schema(node)["properties"].pop(key, None)
        return node


_NO_LENGTH = "a line contact is endless along y; remove it, or plane: strain"


class LineCylinder(_LineModel, CylinderSurface):
    """A cylinder whose axis is the y axis."""

    refused_keys = dict.fromkeys(("axis", "length", "end_radius", "crown_radius"), _NO_LENGTH)

    center: Place = _PLACE
    axis: ClassVar[float] = 0.5 * math.pi  # type: ignore[misc]


class LinePunch(_LineModel, PunchSurface):
    """A punch, flat over twice `half_width`; beyond, its face falls away with `edge_radius`, or ends if that is 0."""

    model_config = ConfigDict(json_schema_extra={"required": ["half_width"]})
    refused_keys: ClassVar[Mapping[str, str]] = {"radius": "no punch of a line contact is round; half_width is needed"}

    of_line: ClassVar[bool] = True
    center: Place = _PLACE
    half_width: PositiveLength = Field(description="half of the flat, such as 1 mm")
    edge_radius: Annotated[float, InUnits(LENGTH, least=0)] = Field(
        default=0.0, description="radius of curvature beyond the flat, 0 for a sharp edge", examples=["100 mm"]
    )

    @model_validator(mode="after")
    def _one_size(self) -> Self:
        return self


class LineHeights(_LineModel, HeightsSurface):
    """A measured profile along x, one column: the separation itself, or with `invert` heights of body 1."""

    of_line: ClassVar[bool] = True
    refused_keys = dict.fromkeys(("transpose",), "a profile has no y; remove it, or plane: strain")
    center: Place = _PLACE
    spacing: Annotated[tuple[PositiveLength, PositiveLength] | None, AlongX()] = Field(
        default=None, description="distance between the points, unless the file gives it", examples=["5 um"]
    )
    crop: tuple[Length, ...] | None = Field(
        default=None,
        description="[x0, x1], the part that is kept, from the first point",
        examples=[["0.2 mm", "0.8 mm"]],
    )


class LineRoughness(_LineModel, RoughnessSurface):
    """A self-affine rough profile of random waves along x, by its spectrum: level up to the rolloff, then falling."""

    of_line: ClassVar[bool] = True
    center: Place = _PLACE
    span: PositiveLength | None = Field(
        default=None, description="period along x, the longest wave; default grid.size", examples=["0.5 mm"]
    )


LineSurface = LineCylinder | LinePunch | LineHeights | LineRoughness


class LineSurfaceEntry(_LineModel, OneSurface):
    """One surface as the file has it: its kind, and what belongs to the kind."""

    refused_keys = dict.fromkeys(
        ("sphere", "ellipsoid", "cone"), "it makes no line contact; cylinder, punch, heights or roughness is needed"
    )
    cylinder: LineCylinder | None = None
    punch: LinePunch | None = None
    heights: LineHeights | None = None
    roughness: LineRoughness | None = None


LineSurfaces = Annotated[
    tuple[Annotated[LineSurface, read_from(LineSurfaceEntry)], ...], Field(min_length=1), Repeated(1)
]


class LineGridSpec(GridSpec):
    """The potential contact area of a line contact: one row of cells along x."""

    points: Annotated[tuple[GridPoints, Literal[1]] | None, AlongX(1)] = Field(
        default=None, description="cells along x, such as 256; or solver.accuracy, which picks them", examples=[256]
    )
    size: Annotated[tuple[PositiveLength, PositiveLength] | None, AlongX(automatic=True)] = Field(
        default=None, description="length of the row of cells, or auto: by the loads"
    )
    center: Place = Field(
        default=(0.0, 0.0), description="x of its middle", examples=["0.1 mm"], json_schema_extra={"default": 0.0}
    )


LineForce = Annotated[float, InUnits(LINE_FORCE)]
LineMoment = Annotated[float, InUnits(LINE_MOMENT)]


class LineBulkStress(_LineModel, BulkStress):
    """A uniform stress along x that stretches a body, and with it its surface; nothing strains it along y."""

    model_config = ConfigDict(json_schema_extra={"required": ["xx"]})
    refused_keys: ClassVar[Mapping[str, str]] = {
        "yy": "in plane strain the stress along y follows from xx; remove it, or plane: strain",
        "xy": "a line contact is the same all along y; remove it, or plane: strain",
    }


class LineStageSpec(_LineModel, StageSpec):
    """A stage of a line contact: the totals to which it moves the load components that it names."""

    model_config = ConfigDict(
        json_schema_extra={"minProperties": 1, "allOf": exclusive((COMPONENTS[0], COMPONENTS[2], COMPONENTS[3]))}
    )
    refused_keys: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(COMPONENTS[1], "a line contact is the same all along y; My or phi_y tilts it about y"),
        **dict.fromkeys(COMPONENTS[5], "a line contact cannot turn about z; remove it, or plane: strain"),
        **dict.fromkeys(
            COMPONENTS[4][1:], "a displacement along y has an unknown constant in a line contact; impose Qy"
        ),
    }

    P: Annotated[float, InUnits(LINE_FORCE, least=0)] | None = Field(
        default=None, description="normal force per length, compressive"
    )
    My: LineMoment | None = Field(default=None, description="moment of the pressure per length, sum of x p dx")
    Qx: LineForce | None = Field(default=None, description="tangential force per length along x")
    Qy: LineForce | None = Field(default=None, description="tangential force per length along y")
    bulk_1: LineBulkStress | None = Field(default=None, description="bulk stress of body 1")
    bulk_2: LineBulkStress | None = Field(
        default=None, description="bulk stress of body 2", examples=[{"xx": "70 MPa"}]
    )


class LineRigSpec(_LineModel, RigSpec):
    """Springs between a line contact and the actuator, per mm of the line's length."""

    refused_keys: ClassVar[Mapping[str, str]] = {
        "stiffness_y": "the motion along y is unknown in a line contact; remove it, or plane: strain",
        **dict.fromkeys(
            ("stiffness_phi_x", "stiffness_phi_z"), "a line contact turns about y alone; remove it, or plane: strain"
        ),
        "compliance": "a line contact has the stiffnesses x, z and phi_y per mm; give these",
    }

    stiffness_x: Annotated[float, InUnits(LINE_STIFFNESS, above=0)] | None = Field(
        default=None, description="stiffness per length along x", examples=["5 kN/mm^2"]
    )
    stiffness_z: Annotated[float, InUnits(LINE_STIFFNESS, above=0)] | None = Field(
        default=None, description="stiffness per length along the normal", examples=["20 kN/mm^2"]
    )
    stiffness_phi_y: Annotated[float, InUnits(LINE_TURNING_STIFFNESS, above=0)] | None = Field(
        default=None, description="stiffness per length against tilts about y", examples=["5e5 N/rad"]
    )


class LineAmplitudeSpec(LineStageSpec):
    """Amplitudes of load components that move in phase (one below 0 moves the other way), or their means."""

    nothing: ClassVar[str] = "no component is given"
    others: ClassVar[str] = "bulk_1, bulk_2"
    friction: ClassVar[None] = None  # type: ignore[misc]
    increments: ClassVar[None] = None  # type: ignore[misc]
    spacing: ClassVar[None] = None  # type: ignore[misc]


class LineCycle(Cycle):
    """Stages that are repeated."""

    stages: tuple[LineLoadStep, ...] = Field(
        min_length=1,
        description="the stages of one cycle, a list; or an amplitude",
        examples=[[{"Qx": "-18 N/mm", "increments": 20}, {"Qx": "18 N/mm", "increments": 20}]],
    )


class LineAmplitudeCycle(AmplitudeCycle):
    """A cycle about a mean: from where it stands to mean + amplitude, then on each repetition to mean - amplitude and
    back."""

    amplitude: LineAmplitudeSpec = Field(  # type: ignore[assignment]
        description="amplitudes of the load components that move", examples=[{"Qx": "18 N/mm"}]
    )
    mean: LineAmplitudeSpec | None = Field(  # type: ignore[assignment]
        default=None, description="their means, 0 if left out", examples=[{"Qx": "5 N/mm"}]
    )


class LineCycleSpec(CycleSpec):
    """An entry of the load path that is a cycle."""

    cycle: Annotated[
        Annotated[LineCycle, Tag("(stages)")] | Annotated[LineAmplitudeCycle, Tag("(amplitude)")],
        Discriminator(cycle_tag),
    ] = Field(
        description="stages, or an amplitude, that are repeated",
        examples=[{"amplitude": {"Qx": "18 N/mm"}, "times": 3, "increments": 20}],
    )


LineLoadStep = Annotated[
    Annotated[LineStageSpec, Tag("(stage)")] | Annotated[LineCycleSpec, Tag("(cycle)")], Discriminator(step_tag)
]


NEVER_KNOWN = frozenset(name for name, meaning in LINE_MEANINGS.items() if meaning.startswith("always NaN"))
"""Columns of the history that hold NaN in every line contact."""


class LineExpectation(Expectation):
    """A quantity of the result of a line contact, the value expected of it, and how far off it may be."""

    dimensions = LINE_EXPECTED_DIMENSIONS

    @field_validator("quantity")
    @classmethod
    def _known(cls, quantity: str) -> str:
        if quantity in NEVER_KNOWN:
            raise refused(f"{quantity} is {LINE_MEANINGS[quantity]}; another quantity is needed")
        return quantity


class LineCase(Case):
    """Case file of a line contact. A bare number is in mm, N/mm, N mm/mm, MPa, rad."""

    dimensions: ClassVar[Mapping[str, Dimension]] = LINE_DIMENSIONS

    plane: Literal["strain"] = Field(description="strain: a line contact in plane strain, the same all along y")
    surface: LineSurfaces = Field(
        description="undeformed separation: one surface, or a list of surfaces that add up",
        examples=[{"cylinder": {"radius": "10 mm"}}],
    )
    grid: LineGridSpec = Field(
        default=LineGridSpec(), description="grid of the potential contact area", examples=[{"points": 256}]
    )
    rig: LineRigSpec | None = Field(
        default=None,
        description="what gives between contact and actuator, per mm of the line, in series with the contact",
        examples=[{"stiffness_x": "5 kN/mm^2"}],
    )
    coupling: Literal["auto", "none", "full"] = Field(
        default="auto",
        description="influence coefficients that are kept: none (ux from qx, uy from qy, uz from p),"
        " full (also between p and qx), auto (those that the case needs)",
    )
    load_path: Annotated[tuple[LineLoadStep, ...], AfterValidator(check_load_path)] = Field(
        min_length=1,
        description="the stages, a list: each moves what it names to a new total",
        examples=[[{"P": "100 N/mm"}, {"Qx": "18 N/mm", "increments": 20}]],
    )
    expect: tuple[LineExpectation, ...] = Field(
        default=(),
        description="what `fretsolve check` compares",
        examples=[[{"quantity": "stick_radius", "value": "0.0681 mm", "rel": "1 %", "stage": 2}]],
    )

    @model_validator(mode="after")
    def _known_depth(self) -> Self:
        of = () if self.solver.accuracy is None else self.solver.accuracy.of
        refused_at(
            (("solver", "accuracy", "of", index), f"{name} is {LINE_MEANINGS[name]}; another quantity is needed")
            for index, name in enumerate(of)
            if name in NEVER_KNOWN
        )
        if self.reference_depth is None:
            message = "has an unknown constant in a line contact; give reference_depth, or impose"
            refused_at(
                (stage.place(motion), f"{motion} {message} {names[0]}")
                for stage in self.stages()
                for names in (COMPONENTS[0], COMPONENTS[3])
                for motion in names[1:]
                if motion in dict(stage.targets)
            )
            needed = {name for names in (COMPONENTS[0], COMPONENTS[3]) for name in names[1:]}
            refused_at(
                (
                    ("expect", index, "quantity"),
                    f"{one.quantity} is NaN in a line contact without reference_depth; give that, or expect another"
                    " quantity",
                )
                for index, one in enumerate(self.expect)
                if one.quantity in needed
            )
            refused_at(
                (
                    ("solver", "accuracy", "of", index),
                    f"{name} is NaN in a line contact without reference_depth; give that, or another quantity",
                )
                for index, name in enumerate(of)
                if name in needed
            )
        return self
