"""The JSON Schema of the case file as users write it, drawn from the models."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from .models import Case
from .quantities import UNIT_NOTE

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def case_schema() -> dict[str, Any]:
    """Return the schema (draft 2020-12), for editors and for hints in messages."""
    return {"$schema": DIALECT, "title": "fretsolve case", **model_schema(Case)}


def model_schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the schema of a file that `model` reads."""
    schema: dict[str, Any] = _tidied(model.model_json_schema())
    return schema


def _told(node: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a key with unit and examples, which stand deeper within, where editors show them."""
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


def _tidied(node: Any) -> Any:
    """Return `node` without what only Python knows: titles of classes and fields, and None."""
    if isinstance(node, list):
        return [_tidied(item) for item in node]
    if not isinstance(node, dict):
        return node
    tidy = {name: _tidied_keyword(name, value) for name, value in node.items() if name != "title"}
    if "default" in tidy and tidy["default"] is None:
        del tidy["default"]
        if {"const": "auto"} in tidy.get("anyOf", ()):
            tidy["default"] = "auto"
    if isinstance(tidy.get("default"), dict):
        tidy["default"] = {name: value for name, value in tidy["default"].items() if value is not None}
    if "anyOf" in tidy:
        return _without_null(tidy)
    return tidy


def _tidied_keyword(name: str, value: Any) -> Any:
    if name == "properties":  # here the keys are names of the user's
        return {key: _told(_tidied(child)) for key, child in value.items()}
    if name == "$defs":  # and here of models
        return {key: _tidied(child) for key, child in value.items()}
    if name in ("examples", "default"):
        return value
    return _tidied(value)


def _without_null(node: dict[str, Any]) -> dict[str, Any]:
    """Return `node` without the alternative null; a case file leaves the key out instead."""
    alternatives = [alternative for alternative in node["anyOf"] if alternative != {"type": "null"}]
    if len(alternatives) > 1 or "description" in alternatives[0]:
        return {**node, "anyOf": alternatives}
    return {**alternatives[0], **{name: value for name, value in node.items() if name != "anyOf"}}
