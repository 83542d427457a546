"""The JSON Schema of the case file as users write it, drawn from the models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core.core_schema import ModelFieldsSchema, ModelSchema, NullableSchema, WithDefaultSchema

from fretsolve.case.models import Case
from fretsolve.case.quantities import UNIT_NOTE


def case_schema() -> dict[str, Any]:
    """Return the schema (draft 2020-12) of any case, for editors."""
    area, line = ({**schema} for schema in (area_schema(), line_schema()))
    definitions = area.pop("$defs") | line.pop("$defs")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "fretsolve case",
        "if": {"properties": {"plane": {"const": "strain"}}, "required": ["plane"]},
        "then": line,
        "else": area,
        "$defs": definitions,
    }


def area_schema() -> Mapping[str, Any]:
    """Return the schema of a case without `plane: strain`."""
    return model_schema(Case)


def line_schema() -> Mapping[str, Any]:
    """Return the schema of a line contact."""
    from fretsolve.case.line_case import LineCase  # other cases need not build its models

    return model_schema(LineCase)


@cache
def model_schema(model: type[BaseModel]) -> Mapping[str, Any]:
    """Return the schema of a file that `model` reads. It takes 0.1 s to draw, and each refused file needs it."""
    return model.model_json_schema(schema_generator=_FileSchema)


class _FileSchema(GenerateJsonSchema):
    """Draws schemas without what only Python knows: titles of classes and fields, and None."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False

    def model_schema(self, schema: ModelSchema) -> dict[str, Any]:
        return {name: value for name, value in super().model_schema(schema).items() if name != "title"}

    def nullable_schema(self, schema: NullableSchema) -> dict[str, Any]:
        return self.generate_inner(schema["schema"])  # a case file leaves the key out instead

    def default_schema(self, schema: WithDefaultSchema) -> dict[str, Any]:
        node = super().default_schema(schema)
        default = node.pop("default", None)
        if isinstance(default, dict):
            default = {name: value for name, value in default.items() if value is not None}
        if default is None and {"const": "auto"} in node.get("anyOf", ()):
            default = "auto"
        return node if default is None else {**node, "default": default}

    def model_fields_schema(self, schema: ModelFieldsSchema) -> dict[str, Any]:
        node = super().model_fields_schema(schema)
        return {**node, "properties": {key: _told(child) for key, child in node["properties"].items()}}


def _told(node: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a key with the unit and the examples of its parts, where editors show them."""
    found = list(_nodes(node))
    meanings = [inner.get("description", "") for inner in found]
    units = [text.removeprefix("in ") for text in meanings if text.startswith("in ")]
    examples = next((list(map(_plain, inner["examples"])) for inner in found if "examples" in inner), None)
    told = dict(node)
    if units and "description" in node:
        told["description"] = node["description"] + UNIT_NOTE + units[0]
    if examples and "examples" not in node:
        told["examples"] = [examples * len(node["prefixItems"])] if "prefixItems" in node else examples
    return told


def _plain(example: Any) -> Any:
    """Return an example as a case file has it: a number without a unit is a number."""
    try:
        return float(example)
    except (TypeError, ValueError):
        return example


def _nodes(node: Any) -> Iterator[dict[str, Any]]:
    """Yield `node` and the alternatives and entries within it."""
    yield node
    for name in ("anyOf", "oneOf", "prefixItems"):
        for inner in node.get(name, ()):
            yield from _nodes(inner)
