"""The JSON Schema of the case file as users write it, and pydantic's errors in the terms of the file, one line each."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import ErrorDetails
from pydantic_core.core_schema import ModelFieldsSchema, ModelSchema, NullableSchema, WithDefaultSchema

from fretsolve.case.keys.unrolled_path import MANY_CYCLES, MOST_SOLVED_CYCLES, typed_key
from fretsolve.case.models import Case
from fretsolve.case.other_names import ALIKE, MISSPELT, close_name, key_meant, meant_by, nearest, not_modelled
from fretsolve.case.quantities import UNIT_NOTE, shown
from fretsolve.case.source import CaseSource
from fretsolve.errors import CaseError, KeyPath, dotted


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


OF_THE_MODEL = ("bodies", "load_path", "friction", "wear")
"""Parts of a case in which an unknown key may be of what is not modelled."""


def is_key(key: KeyPath, schema: Mapping[str, Any]) -> bool:
    """Return whether a file of this schema may have `key`."""
    return bool(_Reader(None, schema).nodes(key))


def nearest_key(name: str, allowed: Collection[str], schema: Mapping[str, Any], parent: KeyPath = ()) -> str:
    """Return a hint for an unknown key: the likely one, also where it stands elsewhere in `schema`, or why there is
    none.

    parent: the mapping of the file that it stands in.
    """
    here = key_meant(name, allowed)
    begun = here is not None and close_name(name, [here], MISSPELT) is not None
    if begun or close_name(name, allowed, ALIKE if here is None else MISSPELT) is None:
        for key, noun in sorted(meant_by(name), key=lambda one: one[0] not in allowed):
            elsewhere = _place(key, schema) if len(name) > 1 or not parent else None  # a letter has many meanings
            if (place := repr(key) if key in allowed else elsewhere) is not None:
                return f"{noun} is {place}"
        if (not parent or parent[0] in OF_THE_MODEL) and (reason := not_modelled(name)) is not None:
            return reason
        if not parent and (place := _place(name, schema)) is not None:
            return f"did you mean {place}?"
    return nearest(name, allowed)


def _place(name: str, schema: Mapping[str, Any]) -> str | None:
    """Return where a key may stand in a case, as one types it: the place with the fewest parts."""
    reader, places = _Reader(None, schema), deque[KeyPath]([()])
    while places:
        place = places.popleft()
        keys = reader.keys(place)
        if name in keys:
            return dotted(typed_key([{"cycle": {}} if "cycle" in place else {}], (*place, name)))
        if len(place) < 3:  # deeper places have too many keys
            lists = any("items" in node or "prefixItems" in node for node in reader.nodes(place))
            places += [(*place, key) for key in keys] + ([(*place, 0)] if lists else [])
    return None


def translated(error: ValidationError, data: Any, schema: Mapping[str, Any], source: CaseSource) -> list[CaseError]:
    """Return the problems in `error`, found in `data` from `source`; schema: of the case file."""
    reader = _Reader(data, schema)
    problems = [(reader.key(details), details) for details in error.errors(include_url=False)]
    unknown = [key for key, details in problems if details["type"] == "extra_forbidden"]
    # None where no key is near, and any may be meant
    meant = {key: reader.meant(key) for key in unknown}
    misspelt = {(*key[:-1], name) for key, name in meant.items() if name or not_modelled(str(key[-1])) is None}
    faulty = {key[:depth] for key, details in problems for depth in range(len(key) + (details["type"] != "too_short"))}

    def is_consequence(key: KeyPath, kind: str) -> bool:
        if kind == "missing":  # under its right name
            return key in misspelt or (*key[:-1], None) in misspelt
        return kind == "too_short" and key in faulty  # pydantic counts the valid entries alone

    return [
        source.problem(reader.message(key, details), key)
        for key, details in problems
        if not is_consequence(key, details["type"])
    ]


class _Reader:
    """Read errors beside the data that the user wrote and the schema of what is allowed."""

    def __init__(self, data: Any, schema: Mapping[str, Any]):
        self._data = data
        self._schema = schema

    def key(self, details: ErrorDetails) -> KeyPath:
        """Return where the error is, without the parts of pydantic's location that the file does not have."""
        value, key = self._data, []
        for part in details["loc"]:
            if part in (value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()):
                value = value[part]
                key.append(part)
        last = details["loc"][-1] if details["loc"] else 0
        if details["type"] == "missing" and isinstance(last, str):
            key.append(last)
        return tuple(key)

    def message(self, key: KeyPath, details: ErrorDetails) -> str:
        """Return the text of the error: what is wrong, the value, what would be right."""
        kind, limits, value = details["type"], details.get("ctx", {}), shown(details["input"])
        if kind == "refused":
            return str(limits["message"])
        if kind == "less_than_equal":
            return f"{value} is too large; a whole number <= {limits['le']} is needed"
        if kind == "too_short" and limits["field_type"] == "Dictionary":
            return f"{value} has no keys; at least one is needed"
        if kind in ("too_short", "too_long") or (kind == "missing" and isinstance(details["loc"][-1], int)):
            array = next(node for node in self.nodes(key) if node.get("type") == "array")
            length = f"{array['maxItems']} are" if "maxItems" in array else f"at least {array['minItems']} is"
            return f"{value} has the wrong number of entries; {length} needed"
        if kind == "missing":
            return f"missing; needed: {self._description(key)}"
        if kind == "extra_forbidden":
            name, allowed = str(key[-1]), self.keys(key[:-1])
            if name in allowed:  # of another alternative, as P beside cycle
                return f"key {shown(name)} cannot stand beside the other keys here; remove it"
            hint = nearest_key(name, allowed, self._schema, key[:-1])
            return f"unknown key {shown(name)}; {hint}"
        if kind == "literal_error":
            # pydantic's 'a', 'b' or 'c', or 1 or 2
            allowed = re.findall("'([^']*)'", limits["expected"]) or re.split(", | or ", limits["expected"])
            return f"{value} is not allowed; {nearest(str(details['input']), allowed)}"
        if kind == "greater_than_equal":
            return f"{value} is too small; a whole number >= {limits['ge']} is needed"
        if kind in ("model_type", "model_attributes_type", "dict_type"):
            return f"{value} is not a mapping; one with the keys {', '.join(self.keys(key))} is needed"
        number = details["input"]
        if kind in ("int_type", "int_from_float") and isinstance(number, float) and number.is_integer():
            many = f"; {MANY_CYCLES}" if key[-1] == "times" and number > MOST_SOLVED_CYCLES else ""
            return f"{value} is written as a decimal number; the whole number {number:.0f} is needed{many}"
        needed = {
            "int_type": "a whole number such as 10",
            "int_from_float": "a whole number such as 10",
            "string_type": "text in quotes",
            "bool_type": "true or false",
            "tuple_type": f"a list such as {self._list_example(key)}",
        }.get(kind)
        return f"{value} is not allowed; {needed} is needed" if needed else f"{value}: {details['msg']}"

    def meant(self, key: KeyPath) -> str | None:
        """Return the key that an unknown key most likely stands for, among the keys that may stand beside it."""
        name, allowed = str(key[-1]), self.keys(key[:-1])
        return close_name(name, allowed) or key_meant(name, allowed)

    def keys(self, key: KeyPath) -> list[str]:
        """Return the keys that the mapping at `key` may have."""
        return list(dict.fromkeys(name for node in self.nodes(key) for name in node.get("properties", ())))

    def _list_example(self, key: KeyPath) -> str:
        examples = (one for node in self.nodes(key) for one in node.get("examples", ()) if isinstance(one, list))
        example = next(examples, None)
        return "[..., ...]" if example is None else shown(example)

    def _description(self, key: KeyPath) -> str:
        properties = [part.get("properties", {}).get(key[-1], {}) for part in self.nodes(key[:-1])]
        texts = (part["description"] for part in properties if "description" in part)
        return next(texts, "this key").partition(UNIT_NOTE)[0]

    def nodes(self, key: KeyPath) -> list[Mapping[str, Any]]:
        """Return what the schema allows at `key`: alternatives side by side, references followed."""
        nodes = list(self._alternatives(self._schema))
        for part in key:
            nodes = [inner for node in nodes for child in _children(node, part) for inner in self._alternatives(child)]
        return nodes

    def _alternatives(self, node: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        if "$ref" in node:
            yield from self._alternatives(self._schema["$defs"][node["$ref"].rpartition("/")[2]])
        for alternative in (*node.get("anyOf", ()), *node.get("oneOf", ())):
            yield from self._alternatives(alternative)
        yield node


def _children(node: Mapping[str, Any], part: str | int) -> Iterator[Mapping[str, Any]]:
    of_mapping = isinstance(part, str)
    listed = node.get("properties", {}) if of_mapping else dict(enumerate(node.get("prefixItems", ())))
    others = node.get("additionalProperties" if of_mapping else "items")
    if part in listed:
        yield listed[part]
    elif isinstance(others, dict):
        yield others
