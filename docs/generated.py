"""Write the parts of the reference pages that follow from the code: case file, result file, commands, Python.

    python docs/generated.py            # name the pages that are stale; exit code 1 if there are any
    python docs/generated.py --write    # bring them up to date

A part stands between the marks ``<!-- generated: NAME -->`` and ``<!-- end of generated -->`` of a page.
"""

from __future__ import annotations

import dataclasses
import enum
import importlib
import inspect
import json
import re
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from fretsolve.case.quantities import UNIT_NOTE
from fretsolve.case.schema import area_schema, line_schema
from fretsolve.cli.main import main
from fretsolve.errors import FretsolveError
from fretsolve.reference.materials import LIBRARY
from fretsolve.result.cycles.table import CYCLES
from fretsolve.result.layout import (
    BULK_HISTORY,
    DERIVED_FIELDS,
    ERRORS,
    FIELDS,
    HISTORY,
    SPOT_HISTORY,
    WEAR_HISTORY,
    Quantity,
)

Schema = Mapping[str, Any]

PAGES = Path(__file__).parent / "reference"

KEY_HEADINGS = ("key", "value, such as", "default", "meaning")
SHORTHANDS = ("SurfaceEntry", "CycleSpec", "LineSurfaceEntry", "LineCycleSpec", "LineExpectation")
"""Definitions that only wrap others, each under a key of its own."""

FUNCTIONS = {"fretsolve": ("load_case", "case_from_dict", "run", "run_with_error_bars", "open_result")}
RESULTS = {"fretsolve.result": ("Result",), "fretsolve.result.state": ("State", "Summary", "Fields", "Zone")}
PICTURES = "fretsolve.plots"
CLOSED_FORMS = tuple(
    f"fretsolve.reference.{name}"
    for name in ("hertz", "tangential", "cyclic_loading", "slip_from_rim", "bulk_stress", "line", "worn_contact")
)


def case_file() -> Iterator[str]:
    """Return the keys of the case file: those of the top, then a section for each kind of mapping."""
    yield from _sections(area_schema())


def materials() -> Iterator[str]:
    """Return a table of the library of materials."""
    rows = []
    for one in LIBRARY:
        limit = "" if one.yield_stress is None else f"{one.yield_stress:g}"
        names = "`" + "`, `".join((one.name, *one.others)) + "`"
        rows.append((names, f"{1e-3 * one.young_modulus:g}", f"{one.poisson_ratio:g}", limit, one.source))
    yield from _table(("name", "E (GPa)", "nu", "yield (MPa)", "source"), rows)


def line_case_file() -> Iterator[str]:
    """Return the keys of a line contact that differ: those of the top, then a section for each kind of mapping."""
    yield from _sections(line_schema(), known=area_schema()["$defs"])


def _sections(schema: Schema, known: Collection[str] = ()) -> Iterator[str]:
    yield from _mapping(schema)
    for name in _mentioned(schema["properties"], schema["$defs"]):
        if name not in SHORTHANDS and name not in known:
            yield f"\n## {_heading(name)}\n"
            yield from _mapping(schema["$defs"][name])


def _mentioned(node: Schema, definitions: Schema) -> list[str]:
    """Return the names of the definitions that a part of the schema leads to, in the order of their appearance."""
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
    required = dict.fromkeys(schema.get("required", ()), "needed")
    if "then" in schema:
        without = schema["if"]["not"]["required"][0]
        required |= dict.fromkeys(schema["then"]["required"], f"needed without `{without}`")
    rows = []
    for key, node in schema["properties"].items():
        default = required[key] if key in required else _default(node)
        meaning = node.get("description", "").partition(UNIT_NOTE)[0]
        rows.append((f"`{key}`", _value(node), default, meaning))
    yield from _table(KEY_HEADINGS, rows)


def _heading(name: str) -> str:
    """Return a heading such as ``Elastic body`` for ``ElasticBody``; for a surface its key."""
    words = re.findall("[A-Z][a-z]+", name.removesuffix("Spec"))
    if words[0] == "Line":
        return f"Line contact: {' '.join(words[1:]).lower()}"
    return f"Surface: {words[0].lower()}" if words[-1] == "Surface" else " ".join(words).capitalize()


def _default(node: Schema) -> str:
    if "default" not in node:
        return ""
    value = node["default"]
    if isinstance(value, Mapping):
        return f"`{next(iter(value.values()))}`" if len(value) == 1 else "those below"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _value(node: Schema) -> str:
    """Return what may stand for a key, in words."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        if name.endswith("SurfaceEntry"):
            return "one of the surfaces below"
        heading = _heading("Expectation" if name == "LineExpectation" else name)
        return f"[{heading}](#{re.sub('[^a-z]+', '-', heading.lower())})"
    if "const" in node:
        return f"`{node['const']}`"
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
    words = {"integer": "whole number", "boolean": "`true`, `false`", "string": "text", "number": "number"}
    least = f" from {node['minimum']} on" if node.get("type") == "integer" and "minimum" in node else ""
    return words[node["type"]] + least


def _is_bare(part: Schema, node: Schema) -> bool:
    """Return whether `part` is the bare number beside a text with a unit."""
    texts = any("examples" in other for other in node["anyOf"]) if "anyOf" in node else False
    return part.get("type") == "number" and texts


def _list(node: Schema) -> str:
    if "prefixItems" in node:
        return f"list of {len(node['prefixItems'])}, each {_value(node['prefixItems'][0])}"
    return f"list of {_value(node['items'])}"


def history() -> Iterator[str]:
    """Return the columns of ``/history``."""
    yield from _quantities((*HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY))


def errors() -> Iterator[str]:
    """Return the columns of the error bars."""
    yield from _quantities(ERRORS)


def cycles() -> Iterator[str]:
    """Return the columns of ``/cycles``."""
    yield from _quantities(CYCLES)


def fields() -> Iterator[str]:
    """Return the datasets of ``/fields``."""
    yield from _quantities((*FIELDS, *DERIVED_FIELDS))


def _quantities(quantities: Sequence[Quantity]) -> Iterator[str]:
    rows = [(f"`{quantity.name}`", quantity.units, quantity.long_name) for quantity in quantities]
    yield from _table(("dataset", "units", "meaning"), rows)


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    for row in (headings, ["---"] * len(headings), *rows):
        yield f"| {' | '.join(row)} |"


def commands(group: click.Group = main, name: str = "fretsolve") -> Iterator[str]:
    """Return a section for each command: usage, what it does, its options."""
    context = click.Context(group)
    for word in group.list_commands(context):
        command = group.get_command(context, word)
        if command is None or command.hidden:
            continue
        yield f"## {name} {word}\n"
        if isinstance(command, click.Group):
            yield f"{_paragraphs(command.help or '')}\n"
            yield from commands(command, f"{name} {word}")
        else:
            yield from _command(command, f"{name} {word}")


def _command(command: click.Command, name: str) -> Iterator[str]:
    arguments = [_value_of(each) for each in command.params if isinstance(each, click.Argument)]
    yield f"`{' '.join([name, '[OPTIONS]', *arguments])}`\n"
    yield f"{_paragraphs(command.help or '')}\n"
    options = [each for each in command.params if isinstance(each, click.Option) and not each.hidden]
    if options:
        yield from _table(("option", "meaning"), [(_option(each), _meaning(each)) for each in options])
        yield ""


def _value_of(parameter: click.Parameter) -> str:
    """Return what stands for the value of an option or argument."""
    if parameter.metavar:
        return parameter.metavar
    if isinstance(parameter.type, click.Choice):
        return "|".join(parameter.type.choices)
    return "N" if isinstance(parameter, click.Option) else str(parameter.name).upper()


def _option(option: click.Option) -> str:
    names = ", ".join(f"`{name}`" for name in option.opts)
    return names if option.is_flag else f"{names} {_escaped(_value_of(option))}"


def _meaning(option: click.Option) -> str:
    default = f" The default is {option.default}." if option.show_default and not option.is_flag else ""
    return _in_a_cell((option.help or "") + default)


def python_functions() -> Iterator[str]:
    """Return the functions that solve and read."""
    for module, names in FUNCTIONS.items():
        for name in names:
            yield from _described(_found(module, name), f"{module}.{name}")


def python_results() -> Iterator[str]:
    """Return the classes of what a run yields and of what a result file holds."""
    for module, names in RESULTS.items():
        for name in names:
            yield from _described(_found(module, name), f"{module}.{name}")


def python_pictures() -> Iterator[str]:
    """Return the functions that draw."""
    module = importlib.import_module(PICTURES)
    yield _paragraphs(inspect.getdoc(module) or "") + "\n"
    for name in module.__all__:
        if name[0].islower():
            yield from _described(_found(PICTURES, name), f"{PICTURES}.{name}")


def python_closed_forms() -> Iterator[str]:
    """Return a table of the functions of the closed forms, and of the classes that they return."""
    rows = []
    for module in CLOSED_FORMS:
        for name, subject in vars(importlib.import_module(module)).items():
            if callable(subject) and subject.__module__ == module and name[0] != "_":
                rows.append((f"`{name}{_signature(subject)}`", _in_a_cell(_first_paragraph(subject))))
    yield from _table(("function or class", "meaning"), rows)


def python_errors() -> Iterator[str]:
    """Return a table of the errors."""
    waiting: list[type[FretsolveError]] = [FretsolveError]
    rows = []
    while waiting:
        kind = waiting.pop(0)
        waiting = [*kind.__subclasses__(), *waiting]
        if kind.__module__ == FretsolveError.__module__:
            base = kind.__bases__[0].__name__
            rows.append((f"`{kind.__name__}`", f"`{base}`", _in_a_cell(_first_paragraph(kind))))
    yield from _table(("error", "a kind of", "meaning"), rows)


def _found(module: str, name: str) -> Any:
    return getattr(importlib.import_module(module), name)


def _first_paragraph(subject: object) -> str:
    return (inspect.getdoc(subject) or "").partition("\n\n")[0]


def _described(subject: Any, name: str) -> Iterator[str]:
    """Return a section: the docstring, the signature of a function, attributes and public members of a class."""
    yield f"### {name}\n"
    if not inspect.isclass(subject):
        yield f"`{name.rpartition('.')[2]}{_signature(subject)}`\n"
    yield f"{_paragraphs(inspect.getdoc(subject) or '')}\n"
    if dataclasses.is_dataclass(subject):
        names = [field.name for field in dataclasses.fields(subject) if not field.name.startswith("_")]
        yield f"Attributes: {', '.join(f'`{name}`' for name in names)}.\n"
    rows = list(_members(subject)) if inspect.isclass(subject) else []
    if rows:
        yield from _table(("member", "meaning"), rows)
        yield ""


def _members(subject: type) -> Iterator[tuple[str, str]]:
    if issubclass(subject, enum.Enum):
        yield from ((f"`{member.name}`", str(member.value)) for member in subject)
    for name, member in vars(subject).items():
        text = inspect.getdoc(member)
        if name[0] == "_" or not text:
            continue
        if isinstance(member, property):
            yield f"`{name}`", _in_a_cell(text)
        elif inspect.isfunction(member):
            yield f"`{name}{_signature(member)}`", _in_a_cell(text)


def _signature(function: Callable[..., Any]) -> str:
    """Return parameters with their defaults, and the type of the result."""
    signature = inspect.signature(function)
    parameters = [
        each.replace(annotation=inspect.Parameter.empty)
        for each in signature.parameters.values()
        if each.name != "self"
    ]
    bare = str(inspect.Signature(parameters))
    result = signature.return_annotation
    return f"{bare} -> {result}" if isinstance(result, str) and result != "None" else bare


def _paragraphs(text: str) -> str:
    """Return a docstring as Markdown, a line for each paragraph. Lines after click's mark ``\\b`` stay as they are."""
    found = []
    for paragraph in inspect.cleandoc(text).split("\n\n"):
        if paragraph.startswith("\b\n"):
            found.append("```text\n" + paragraph.removeprefix("\b\n") + "\n```")
            continue
        words = " ".join(paragraph.replace("``", "`").split()).split("`")
        words[::2] = [re.sub(r"(?<!\w)\*|<(?=\w)", r"\\\g<0>", part) for part in words[::2]]  # outside of code
        found.append("`".join(words))
    return "\n\n".join(found)


def _in_a_cell(text: str) -> str:
    return _escaped(_paragraphs(text).replace("\n\n", " "))


def _escaped(text: str) -> str:
    return text.replace("|", r"\|")


PARTS: Mapping[str, Callable[[], Iterator[str]]] = {
    "case file": case_file,
    "materials": materials,
    "line case file": line_case_file,
    "history": history,
    "errors": errors,
    "cycles": cycles,
    "fields": fields,
    "commands": commands,
    "python functions": python_functions,
    "python results": python_results,
    "python pictures": python_pictures,
    "python closed forms": python_closed_forms,
    "python errors": python_errors,
}

_PART = re.compile(r"(<!-- generated: ([a-z ]+) -->\n).*?(<!-- end of generated -->)", re.DOTALL)


def updated(page: str) -> str:
    """Return the text of a page with its generated parts as the code has them now."""

    def part(marks: re.Match[str]) -> str:
        text = "\n".join(PARTS[marks[2]]()).strip()
        return f"{marks[1]}\n{text}\n\n{marks[3]}"

    return _PART.sub(part, page)


def stale_pages() -> dict[Path, str]:
    """Return the reference pages that differ from the code, with the text that they should have."""
    found = {}
    for page in sorted(PAGES.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        if (new := updated(text)) != text:
            found[page] = new
    return found


if __name__ == "__main__":
    stale = stale_pages()
    for page, text in stale.items():
        print(page)
        if "--write" in sys.argv:
            page.write_text(text, encoding="utf-8")
    sys.exit(bool(stale) and "--write" not in sys.argv)
