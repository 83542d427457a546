"""The bodies of a case: their elastic constants, given as numbers or by the name of a material."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, GetJsonSchemaHandler, Tag, model_validator
from pydantic_core import CoreSchema

from fretsolve.case.base import CaseModel, refused_at
from fretsolve.case.dimensions import NUMBER, PRESSURE
from fretsolve.case.quantities import InUnits, refused, shown

MATERIAL = "material"
"""The key that names a material."""


class MaterialName:
    """Annotation of a name of the library, for the JSON Schema: editors list the names, and take other spellings."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        from fretsolve.reference.materials import NAMES  # few cases need it

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
        from fretsolve.case.other_names import nearest
        from fretsolve.reference.materials import NAMES, every_name, material_named

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
    from fretsolve.reference.materials import material_named

    found = material_named(str(value)) if isinstance(value, str | int) else None
    with_numbers = "" if found else ", {young_modulus: 200 GPa, poisson_ratio: 0.3}"
    name = found.name if found else "steel"
    raise refused(f"{shown(value)} is not a body; rigid{with_numbers} or {{{MATERIAL}: {name}}} is needed")


Body = Annotated[
    Annotated[Literal["rigid"], Tag("(rigid)")] | Annotated[ElasticBody, Tag("(elastic)")],
    Discriminator(lambda value: "(rigid)" if value == "rigid" else "(elastic)"),
    BeforeValidator(_require_body),
]
