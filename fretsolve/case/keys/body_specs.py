"""The bodies of a case and the undeformed separation h(x, y) of their surfaces, as written in the case file.

Elastic constants are numbers, or follow from the name of a material. Kinds of surfaces add up.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    GetPydanticSchema,
    Tag,
    model_validator,
)
from pydantic_core import CoreSchema, core_schema

from fretsolve.case.base import CaseModel, Named, Placed, PositiveLength, Radius, Repeated, refused_at, require_either
from fretsolve.case.dimensions import ANGLE, LENGTH, NUMBER, PRESSURE
from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.other_names import nearest
from fretsolve.case.quantities import InUnits, refused, shown
from fretsolve.reference.materials import NAMES, every_name, material_named

MATERIAL = "material"
"""The key that names a material."""


class MaterialName:
    """Annotation of a name of the library, for the JSON Schema: editors list the names, and take other spellings."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"type": "string", "enum": list(NAMES)}, {"type": "string"}, {"type": "integer"}]}


class ElasticBody(CaseModel):
    """A linear elastic, isotropic half-space."""

    material: Annotated[str, MaterialName()] | None = Field(
        default=None,
        description="name of a material of `fretsolve materials`; keys beside it override its constants",
        examples=["Ti-6Al-4V"],
    )
    young_modulus: Annotated[float, InUnits(PRESSURE, above=0)] = Field(description="Young's modulus, such as 200 GPa")
    poisson_ratio: Annotated[float, InUnits(NUMBER, above=-1, most=0.5)] = Field(
        description="Poisson's ratio, such as 0.3", examples=[0.3]
    )
    yield_stress: Annotated[float, InUnits(PRESSURE, above=0)] | None = Field(
        default=None, description="yield stress, for a warning where the contact would yield", examples=["900 MPa"]
    )

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        node = handler(schema)
        body = handler.resolve_ref_schema(node)
        body |= {"if": {"not": {"required": [MATERIAL]}}, "then": {"required": body.pop("required")}}
        return node

    @model_validator(mode="before")
    @classmethod
    def _with_constants_of_material(cls, value: Any) -> Any:
        if not isinstance(value, dict) or MATERIAL not in value:
            return value
        name = value[MATERIAL]
        found = material_named(str(name)) if isinstance(name, str | int) else None
        if found is None:
            hint = nearest(str(name), every_name())
            others = f"one of {', '.join(NAMES)} is needed, or young_modulus and poisson_ratio"
            known = hint if hint.startswith("did") else others
            refused_at([((MATERIAL,), f"{shown(name)} is not a material of the library; {known}")])
            raise AssertionError  # refused above
        return {**found.constants, **value, MATERIAL: found.name}


def _require_body(value: object) -> object:
    if value == "rigid" or isinstance(value, dict | ElasticBody):
        return value
    found = material_named(str(value)) if isinstance(value, str | int) else None
    with_numbers = "" if found else ", {young_modulus: 200 GPa, poisson_ratio: 0.3}"
    name = found.name if found else "steel"
    raise refused(f"{shown(value)} is not a body; rigid{with_numbers} or {{{MATERIAL}: {name}}} is needed")


Body = Annotated[
    Annotated[Literal["rigid"], Tag("(rigid)")] | Annotated[ElasticBody, Tag("(elastic)")],
    Discriminator(lambda value: "(rigid)" if value == "rigid" else "(elastic)"),
    BeforeValidator(_require_body),
]


class SphereSurface(Placed):
    """A sphere, as the paraboloid that osculates it."""

    kind: ClassVar[Literal["sphere"]] = "sphere"
    radius: Radius = Field(description="radius of curvature, negative where concave, such as 10 mm")


class EllipsoidSurface(Placed):
    """A surface of two principal curvatures."""

    kind: ClassVar[Literal["ellipsoid"]] = "ellipsoid"
    radius_x: Radius = Field(description="radius of curvature along the first axis, such as 10 mm")
    radius_y: Radius = Field(description="radius of curvature along the second axis, such as 20 mm")
    angle: Annotated[float, InUnits(ANGLE)] = Field(
        default=0.0, description="from x to the first axis", examples=["30 deg"]
    )


class CylinderSurface(Placed):
    """A cylinder lying on the plane: endless, crowned, or of finite length; `axis` is an angle from x."""

    kind: ClassVar[Literal["cylinder"]] = "cylinder"
    radius: Radius = Field(description="radius across the axis, negative where concave, such as 10 mm")
    axis: Annotated[
        float, InUnits(ANGLE), Named({"x": 0.0, "y": math.pi / 2}, "is not an axis; x, y or an angle such as '30 deg'")
    ] = Field(
        description="direction of the axis: x, y, or its angle from x (none with plane: strain)",
        examples=["x", "30 deg"],
    )
    length: PositiveLength | None = Field(
        default=None, description="of the straight part and its rounded ends together"
    )
    end_radius: PositiveLength | None = Field(
        default=None, description="radius that rounds the ends off", examples=["0.1 mm"]
    )
    crown_radius: PositiveLength | None = Field(
        default=None, description="radius of the crown along the axis", examples=["1000 mm"]
    )

    @property
    def straight_length(self) -> float | None:
        """Length (mm) between the roundings of the ends, the whole length if the roundings meet; None without ends."""
        if self.length is None:
            return None
        return self.length - 2.0 * (self.end_radius or 0.0) or self.length

    @model_validator(mode="after")
    def _ends_fit(self) -> Self:
        if self.end_radius is not None and self.length is None:
            raise refused("end_radius is given without a length; give the length of the cylinder as well")
        if self.end_radius is not None and self.length is not None and self.end_radius > self.length / 2:
            raise refused(f"end_radius is more than half of the length; at most {self.length / 2:g} mm fits")
        return self


class ConeSurface(Placed):
    """A cone with its tip down."""

    kind: ClassVar[Literal["cone"]] = "cone"
    angle: Annotated[float, InUnits(ANGLE, above=0, below=math.pi / 2)] = Field(
        description="between flank and contact plane, such as 2 deg", examples=["2 deg"]
    )


class PunchSurface(Placed):
    """A flat punch: round with a `radius`, or square with a `half_width`. Its edge may be rounded, within that size."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["radius"]}, {"required": ["half_width"]}]})

    kind: ClassVar[Literal["punch"]] = "punch"
    of_line: ClassVar[bool] = False
    radius: PositiveLength | None = Field(default=None, description="of a round punch", examples=["1 mm"])
    half_width: PositiveLength | None = Field(default=None, description="of a square punch", examples=["1 mm"])
    edge_radius: Annotated[float, InUnits(LENGTH, least=0)] = Field(
        default=0.0, description="0 for a sharp edge", examples=["0.1 mm"]
    )

    @model_validator(mode="after")
    def _one_size(self) -> Self:
        require_either(self, "radius", "half_width")
        size = self.radius or self.half_width or 0.0
        if self.edge_radius > size:
            message = f"edge_radius ({self.edge_radius:g} mm) is larger than the punch ({size:g} mm)"
            raise refused(f"{message}; a smaller one is needed")
        return self


MOST_WAVES = 4096
"""Shortest waves on the period of a rough surface, of which half a gigabyte of amplitudes is the most to be kept."""


class RoughnessSurface(Placed):
    """A self-affine rough surface of random waves, by its spectrum: level up to the rolloff, then falling."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["rms_height"]}, {"required": ["rms_slope"]}]})

    kind: ClassVar[Literal["roughness"]] = "roughness"
    of_line: ClassVar[bool] = False
    hurst: Annotated[float, InUnits(NUMBER, above=0, below=1)] = Field(
        description="Hurst exponent, such as 0.8", examples=[0.8]
    )
    rms_height: PositiveLength | None = Field(
        default=None, description="root mean square height of the sum of the waves", examples=["0.1 um"]
    )
    rms_slope: Annotated[float, InUnits(NUMBER, above=0)] | None = Field(
        default=None, description="root mean square slope of the sum of the waves", examples=[0.01]
    )
    rolloff: PositiveLength | None = Field(
        default=None, description="wavelength beyond which the spectrum is level; default span", examples=["0.1 mm"]
    )
    cutoff: PositiveLength = Field(description="shortest wavelength, such as 10 um", examples=["10 um"])
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(
        default=1, description="number of the random phases; the same one gives the same surface on every grid"
    )
    span: PositiveLength | None = Field(
        default=None,
        description="period along x and y, the longest wave; default grid.size, its longer side",
        examples=["0.5 mm"],
    )

    @property
    def period(self) -> float:
        """The span (mm), which every case that was read has."""
        assert self.span is not None
        return self.span

    @property
    def longest(self) -> float:
        """Wavelength (mm) from which the spectrum falls."""
        return self.rolloff or self.period

    @property
    def directions(self) -> int:
        """Directions in which the surface varies."""
        return 1 if self.of_line else 2

    @property
    def exponent(self) -> float:
        """Exponent with which the spectrum falls."""
        return -self.directions - 2.0 * self.hurst

    @model_validator(mode="after")
    def _waves_fit(self) -> Self:
        require_either(self, "rms_height", "rms_slope")
        span, rolloff = self.span or math.inf, self.rolloff or self.span or math.inf
        if rolloff > span:
            message = f"{rolloff:g} mm is longer than the span ({span:g} mm); a shorter one is needed"
            refused_at([(("rolloff",), message)])
        if self.cutoff >= rolloff:
            name = "rolloff" if self.rolloff else "span"
            message = f"{self.cutoff:g} mm is not shorter than the {name} ({rolloff:g} mm); a shorter one is needed"
            refused_at([(("cutoff",), message)])
        if self.span is not None and span > MOST_WAVES * self.cutoff:
            message = (
                f"{span / self.cutoff:.0f} of the shortest waves fit into the span ({span:g} mm), at most {MOST_WAVES}"
                " are possible; a longer cutoff or a shorter span is needed"
            )
            refused_at([(("cutoff",), message)])
        return self


Surface = (
    SphereSurface | EllipsoidSurface | CylinderSurface | ConeSurface | PunchSurface | HeightsSurface | RoughnessSurface
)


class OneSurface(CaseModel):
    """A mapping with one key, the kind of a surface."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1, "maxProperties": 1})

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if len(self.model_fields_set) != 1:
            kinds = ", ".join(sorted(self.model_fields_set)) or "none"
            allowed = ", ".join(type(self).model_fields)
            raise refused(f"one kind of surface ({allowed}) is needed, not {kinds}; several go in a list")
        return self


class SurfaceEntry(OneSurface):
    """One surface as the file has it: its kind, and what belongs to the kind."""

    sphere: SphereSurface | None = None
    ellipsoid: EllipsoidSurface | None = None
    cylinder: CylinderSurface | None = None
    cone: ConeSurface | None = None
    punch: PunchSurface | None = None
    heights: HeightsSurface | None = None
    roughness: RoughnessSurface | None = None


def read_from(entry: type[OneSurface]) -> GetPydanticSchema:
    """Return the annotation of a surface that stands in the file as an `entry`."""
    return GetPydanticSchema(
        lambda source, handler: core_schema.no_info_after_validator_function(
            lambda one: getattr(one, *one.model_fields_set),
            handler.generate_schema(entry),
            serialization=core_schema.plain_serializer_function_ser_schema(
                lambda surface: {surface.kind: surface.model_dump(mode="json")}
            ),
        )
    )


Surfaces = Annotated[tuple[Annotated[Surface, read_from(SurfaceEntry)], ...], Field(min_length=1), Repeated(1)]
