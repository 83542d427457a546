"""JSON Schema of the case file as users write it, drawn from the models."""

from __future__ import annotations

from typing import Any

from .models import Case

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def case_schema() -> dict[str, Any]:
    """The schema (draft 2020-12), for editors and for hints in messages."""
    schema: dict[str, Any] = _tidied(Case.model_json_schema())
    return {"$schema": DIALECT, "title": "fretsolve case", **schema}


def _tidied(node: Any) -> Any:
    """`node` without what only the Python side knows: titles of classes and fields, and None."""
    if isinstance(node, list):
        return [_tidied(item) for item in node]
    if not isinstance(node, dict):
        return node
    tidy = {name: _tidied_keyword(name, value) for name, value in node.items() if name != "title"}
    if "default" in tidy and tidy["default"] is None:
        del tidy["default"]
        if {"const": "auto"} in tidy.get("anyOf", ()):
            tidy["default"] = "auto"
    if "anyOf" in tidy:
        return _without_null(tidy)
    return tidy


def _tidied_keyword(name: str, value: Any) -> Any:
    if name in ("properties", "$defs"):  # here the keys are names of the user's or of models
        return {key: _tidied(child) for key, child in value.items()}
    return _tidied(value)


def _without_null(node: dict[str, Any]) -> dict[str, Any]:
    """`node` without the alternative null, which a case file doesn't have: a key is left out instead."""
    alternatives = [alternative for alternative in node["anyOf"] if alternative != {"type": "null"}]
    if len(alternatives) > 1 or "description" in alternatives[0]:
        return {**node, "anyOf": alternatives}
    return {**alternatives[0], **{name: value for name, value in node.items() if name != "anyOf"}}
