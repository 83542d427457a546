"""The keys of the case file as lists, from its JSON Schema; `docs/generated.py` writes them into the reference."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from fretsolve.case.quantities import UNIT_NOTE
from fretsolve.case.schema import area_schema, line_schema

Schema = Mapping[str, Any]

MOST_NAMED = 20
"""Most values of a key that are listed: only the names of the history are more."""

SHORTHANDS = ("SurfaceEntry", "CycleSpec", "LineSurfaceEntry", "LineCycleSpec", "LineExpectation")
"""Definitions that only wrap others, each under a key of its own."""


def case_file() -> Iterator[str]:
    """Return the keys of the case file: those of the top, then a section for each kind of mapping."""
    yield from _sections(area_schema(), Shown())


def line_case_file() -> Iterator[str]:
    """Return the keys of a line contact that differ: those of the top, then a section for each kind of mapping."""
    known, shown = area_schema(), Shown()
    for _ in _sections(known, shown):
        pass
    yield from _sections(line_schema(), shown, known["$defs"])


class Shown(dict[Sequence[str], str]):
    """Keys and descriptions on the page, each with a link to its section; later sections refer to them."""

    def split(self, rows: Sequence[Sequence[str]]) -> tuple[list[str], list[Sequence[str]]]:
        """Return lines that refer to sections with some of `rows`, and the rest of them."""
        sections: dict[str, list[Sequence[str]]] = {}
        for row in rows:
            sections.setdefault(self.get(row, ""), []).append(row)
        lines, known = [], []
        for link, same in sections.items():
            if link:
                known += same
                lines.append(f"{', '.join(row[0] for row in same)}: as in {link}.\n")
        return lines, [row for row in rows if row not in known]


def _sections(schema: Schema, shown: Shown, known: Collection[str] = ()) -> Iterator[str]:
    yield from _mapping(schema, "the [whole](#the-whole)", shown)
    for name in _mentioned(schema["properties"], schema["$defs"]):
        if name not in SHORTHANDS and name not in known:
            heading = _heading(name)
            yield f"\n## {heading}\n"
            yield from _mapping(schema["$defs"][name], _link(heading), shown)


def _mentioned(node: Schema, definitions: Schema) -> list[str]:
    """Return the names of the definitions that a part of the schema leads to, in the order of their appearance."""
    waiting, found = [node], dict[str, None]()
    while waiting:
        for name in re.findall(r"#/\$defs/(\w+)", json.dumps(waiting.pop(0))):
            if name not in found:
                found[name] = None
                waiting.append(definitions[name])
    return list(found)


def _mapping(schema: Schema, link: str, shown: Shown) -> Iterator[str]:
    if "anyOf" in schema:
        alone, schema = schema["anyOf"][0], next(part for part in schema["anyOf"] if "properties" in part)
        same = (key for key, node in schema["properties"].items() if node.get("description") == alone["description"])
        yield f"A value alone stands for `{next(same)}`.\n"
    about = (schema["description"],)
    if about not in shown:
        yield about[0] + "\n"
        shown[about] = link
    required = dict.fromkeys(schema.get("required", ()), "**needed**")
    if "then" in schema:
        without = schema["if"]["not"]["required"][0]
        required |= dict.fromkeys(schema["then"]["required"], f"**needed** without `{without}`")
    rows = []
    for key, node in schema["properties"].items():
        value, meaning = _value(node), node.get("description", "").partition(UNIT_NOTE)[0]
        meaning, _, example = meaning.partition(", such as ")
        if example and f"`{example}`" not in value:
            meaning += f", such as {example}"
        value += f", {required[key]}" if key in required else _default(node)
        rows.append((f"`{key}`", f"({value}): {meaning}"))
    lines, rest = shown.split(rows)
    yield from lines
    if rest:
        yield from (f"- {' '.join(row)}" for row in rest)
    for row in rows:
        shown.setdefault(row, link)


def _heading(name: str) -> str:
    """Return a heading such as ``Elastic body`` for ``ElasticBody``; for a surface its key."""
    words = re.findall("[A-Z][a-z]+", name.removesuffix("Spec"))
    if words[0] == "Line":
        return f"Line contact: {' '.join(words[1:]).lower()}"
    return f"Surface: {words[0].lower()}" if words[-1] == "Surface" else " ".join(words).capitalize()


def _link(heading: str) -> str:
    return f"[{heading}](#{re.sub('[^a-z]+', '-', heading.lower())})"


def _default(node: Schema) -> str:
    """Return the default, to follow the value; none of an empty list, and of a mapping, whose keys have their own."""
    value = node.get("default", {})
    if isinstance(value, Mapping):
        if len(value) != 1:
            return ""
        value = next(iter(value.values()))
    return "" if value == [] else f"; default `{str(value).lower() if isinstance(value, bool) else value}`"


def _value(node: Schema) -> str:
    """Return what may stand for a key, in words."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        if name.endswith("SurfaceEntry"):
            return "one of the surfaces below"
        heading = _heading("Expectation" if name == "LineExpectation" else name)
        return _link(heading)
    if "const" in node:
        return f"`{node['const']}`"
    if "enum" in node and len(node["enum"]) > MOST_NAMED:
        return "a dataset of the [history](result.md#history)"
    if "enum" in node:
        return ", ".join(f"`{value}`" for value in node["enum"])
    plain = ("number", "string", "integer") if "anyOf" in node else ("number", "string")
    if "examples" in node and all(part.get("type") in plain for part in node.get("anyOf", [node])):
        return " or ".join(f"`{value}`" for value in node["examples"])
    for kind in ("anyOf", "oneOf"):
        if kind in node:
            found = dict.fromkeys(_value(part) for part in node[kind] if "pattern" in part or not _is_bare(part, node))
            return ", or ".join(found)
    if node.get("type") == "array":
        return _list(node)
    if node.get("type") == "object":
        return f"`{str(node['examples'][0]).replace(chr(39), '')}`"
    words = {"integer": "integer", "boolean": "`true`, `false`", "string": "text", "number": "number"}
    least = f" from {node['minimum']}" if node.get("type") == "integer" and "minimum" in node else ""
    return words[node["type"]] + least


def _is_bare(part: Schema, node: Schema) -> bool:
    """Return whether `part` is the bare number beside a text with a unit."""
    texts = any("examples" in other for other in node["anyOf"]) if "anyOf" in node else False
    return part.get("type") == "number" and texts


def _list(node: Schema) -> str:
    if "prefixItems" in node:
        each, count = _value(node["prefixItems"][0]), len(node["prefixItems"])
        plain = re.fullmatch("`([^`]*)`", each)
        return f"`[{', '.join([plain[1]] * count)}]`" if plain else f"list of {count}, each {each}"
    return f"list of {_value(node['items'])}"


def table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Return the lines of a table."""
    for row in (headings, ["---"] * len(headings), *rows):
        yield f"| {' | '.join(row)} |"
