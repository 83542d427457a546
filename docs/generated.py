"""Parts of the pages that are made from the package when Sphinx reads them: the keys of the case file, the datasets of
results. A page names them as ``%% case file`` on a line of its own."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fretsolve.case import case_schema
from fretsolve.case.quantities import UNIT_NOTE
from fretsolve.result.layout import ERRORS, FIELDS, HISTORY, Quantity

if TYPE_CHECKING:
    from sphinx.application import Sphinx

Schema = Mapping[str, Any]

KEY_HEADINGS = ("key", "value, such as", "default", "meaning")
SHORTHANDS = ("SurfaceEntry", "CycleSpec")
"""Definitions that only wrap others, each under a key of its own."""


def case_file() -> Iterator[str]:
    """The keys of the case file: those of the top, then a section for each kind of mapping."""
    schema = case_schema()
    yield from _mapping(schema)
    for name in _mentioned(schema["properties"], schema["$defs"]):
        if name not in SHORTHANDS:
            yield f"\n## {_heading(name)}\n"
            yield from _mapping(schema["$defs"][name])


def _mentioned(node: Schema, definitions: Schema) -> list[str]:
    """Names of the definitions that a part of the schema leads to, in the order of their appearance."""
    waiting, found = [node], dict[str, None]()
    while waiting:
        for name in re.findall(r"#/\$defs/(\w+)", json.dumps(waiting.pop(0))):
            if name not in found:
                found[name] = None
                waiting.append(definitions[name])
    return list(found)


def _mapping(schema: Schema) -> Iterator[str]:
    if "anyOf" in schema:
        schema = next(part for part in schema["anyOf"] if "properties" in part)
        yield f"A value alone stands for `{next(iter(schema['properties']))}`.\n"
    yield schema["description"] + "\n"
    required = schema.get("required", ())
    rows = []
    for key, node in schema["properties"].items():
        default = "needed" if key in required else _default(node)
        meaning = node.get("description", "").partition(UNIT_NOTE)[0]
        rows.append((f"`{key}`", _value(node), default, meaning))
    yield from _table(KEY_HEADINGS, rows)


def _heading(name: str) -> str:
    """Such as ``Elastic body`` of ``ElasticBody``; of a surface its key."""
    words = re.findall("[A-Z][a-z]+", name.removesuffix("Spec"))
    return f"Surface: {words[0].lower()}" if words[-1] == "Surface" else " ".join(words).capitalize()


def _default(node: Schema) -> str:
    if "default" not in node:
        return ""
    value = node["default"]
    if isinstance(value, Mapping):
        return f"`{next(iter(value.values()))}`" if len(value) == 1 else "those below"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _value(node: Schema) -> str:
    """What may stand for a key, in words."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        if name == "SurfaceEntry":
            return "one of the surfaces below"
        heading = "Cycle" if name == "CycleSpec" else _heading(name)
        return f"[{heading}](#{re.sub('[^a-z]+', '-', heading.lower())})"
    if "const" in node:
        return f"`{node['const']}`"
    if "enum" in node:
        return ", ".join(f"`{value}`" for value in node["enum"])
    if "examples" in node and all(part.get("type") in ("number", "string") for part in node.get("anyOf", [node])):
        return " or ".join(f"`{value}`" for value in node["examples"])
    for kind in ("anyOf", "oneOf"):
        if kind in node:
            found = dict.fromkeys(_value(part) for part in node[kind] if "pattern" in part or not _is_bare(part, node))
            return ", or ".join(found)
    if node.get("type") == "array":
        return _list(node)
    words = {"integer": "whole number", "boolean": "`true`, `false`", "string": "text", "number": "number"}
    least = f" from {node['minimum']} on" if node.get("type") == "integer" and "minimum" in node else ""
    return words[node["type"]] + least


def _is_bare(part: Schema, node: Schema) -> bool:
    """Whether `part` is the bare number beside a text with a unit."""
    texts = any("examples" in other for other in node["anyOf"]) if "anyOf" in node else False
    return part.get("type") == "number" and texts


def _list(node: Schema) -> str:
    if "prefixItems" in node:
        return f"list of {len(node['prefixItems'])}, each {_value(node['prefixItems'][0])}"
    return f"list of {_value(node['items'])}"


def history() -> Iterator[str]:
    """The columns of ``/history``."""
    yield from _quantities(HISTORY)


def errors() -> Iterator[str]:
    """The columns of the error bars."""
    yield from _quantities(ERRORS)


def fields() -> Iterator[str]:
    """The datasets of ``/fields``."""
    yield from _quantities(FIELDS)


def _quantities(quantities: Sequence[Quantity]) -> Iterator[str]:
    rows = [(f"`{quantity.name}`", quantity.units, quantity.long_name) for quantity in quantities]
    yield from _table(("dataset", "units", "meaning"), rows)


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    for row in (headings, ["---"] * len(headings), *rows):
        yield f"| {' | '.join(row)} |"


PARTS = {"case file": case_file, "history": history, "errors": errors, "fields": fields}


def expand(app: Sphinx, page: str, source: list[str]) -> None:
    """Put the parts into a page that is being read."""
    for name, part in PARTS.items():
        mark = f"\n%% {name}\n"
        if mark in source[0]:
            source[0] = source[0].replace(mark, "\n" + "\n".join(part()) + "\n")


def escape(app: Sphinx, what: str, name: str, subject: Any, options: Any, lines: list[str]) -> None:
    """Bars in a docstring are those of magnitudes."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", expand)
    app.connect("autodoc-process-docstring", escape)
    return {"parallel_read_safe": True}
