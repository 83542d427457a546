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
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from generated_case import MOST_NAMED, Shown, case_file, line_case_file, table

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
    RIG_HISTORY,
    SPOT_HISTORY,
    WEAR_HISTORY,
    Quantity,
)

PAGES = Path(__file__).parent / "reference"

ERROR_ENDINGS = {
    "_corrected_error": "estimated error of the corrected",
    "_corrected": "value, corrected for the number of increments, of",
    "_error": "estimated error of",
}
"""What the endings of columns of error bars mean, a longer ending before the one that it ends with."""

FUNCTIONS = {"fretsolve": ("load_case", "case_from_dict", "run", "run_with_error_bars", "open_result")}
RESULTS = {
    "fretsolve.result": ("Result",),
    "fretsolve.result.state": ("State", "Summary", "SummaryErrors", "Fields", "Zone"),
}
PICTURES = "fretsolve.post.plots"
CLOSED_FORMS = tuple(
    f"fretsolve.reference.{name}"
    for name in ("hertz", "tangential", "cyclic_loading", "slip_from_rim", "layered", "line_slip", "worn_contact")
)


def materials() -> Iterator[str]:
    """Return a table of the library of materials."""
    rows = []
    for one in LIBRARY:
        limit = "" if one.yield_stress is None else f"{one.yield_stress:g}"
        names = "`" + "`, `".join((one.name, *one.others)) + "`"
        rows.append((names, f"{1e-3 * one.young_modulus:g}", f"{one.poisson_ratio:g}", limit, one.source))
    yield from table(("name", "E (GPa)", "nu", "yield (MPa)", "source"), rows)


def history() -> Iterator[str]:
    """Return the columns of ``/history``."""
    yield from _quantities((*HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *RIG_HISTORY))


def errors() -> Iterator[str]:
    """Return the columns of the error bars: columns of many quantities in one line, then the others."""
    of, others = {ending: list[str]() for ending in ERROR_ENDINGS}, list[Quantity]()
    for quantity in ERRORS:
        ending = next((ending for ending in ERROR_ENDINGS if quantity.name.endswith(ending)), None)
        if ending is None:
            others.append(quantity)
        else:
            of[ending].append(f"`{quantity.name.removesuffix(ending)}`")
    yield from (f"- `NAME{ending}`: {ERROR_ENDINGS[ending]} {', '.join(names)}" for ending, names in of.items())
    yield from _quantities(others)


def cycles() -> Iterator[str]:
    """Return the columns of ``/cycles``."""
    yield from _quantities(CYCLES)


def fields() -> Iterator[str]:
    """Return the datasets of ``/fields``."""
    yield from _quantities((*FIELDS, *DERIVED_FIELDS))


def _quantities(quantities: Sequence[Quantity]) -> Iterator[str]:
    for quantity in quantities:
        units = "" if quantity.units == "1" else f" ({quantity.units})"
        yield f"- `{quantity.name}`{units}: {quantity.long_name}"


def commands(group: click.Group = main, name: str = "fretsolve", shown: Shown | None = None) -> Iterator[str]:
    """Return a section for each command: usage, what it does, its options but for those that `shown` has."""
    context, shown = click.Context(group), Shown() if shown is None else shown
    for word in group.list_commands(context):
        command = group.get_command(context, word)
        if command is None or command.hidden:
            continue
        yield f"## {name} {word}\n"
        if isinstance(command, click.Group):
            yield f"{_paragraphs(command.help or '')}\n"
            yield from commands(command, f"{name} {word}", shown)
        else:
            yield from _command(command, f"{name} {word}", shown)


def _command(command: click.Command, name: str, shown: Shown) -> Iterator[str]:
    arguments = [_value_of(each) for each in command.params if isinstance(each, click.Argument)]
    yield f"`{' '.join([name, '[OPTIONS]', *arguments])}`\n"
    yield f"{_paragraphs(command.help or '')}\n"
    options = [each for each in command.params if isinstance(each, click.Option) and not each.hidden]
    lines, rows = shown.split([(_option(each), _meaning(each)) for each in options])
    yield from lines
    if rows:
        yield from (f"- {option}: {meaning}" for option, meaning in rows)
        yield ""
    for row in rows:
        shown.setdefault(row, f"[{name}](#{name.replace(' ', '-')})")


def _value_of(parameter: click.Parameter) -> str:
    """Return what stands for the value of an option or argument."""
    if parameter.metavar:
        return parameter.metavar
    if isinstance(parameter.type, click.Choice):
        return "|".join(parameter.type.choices)
    return "N" if isinstance(parameter, click.Option) else str(parameter.name).upper()


def _option(option: click.Option) -> str:
    names = ", ".join(f"`{name}`" for name in option.opts)
    return names if option.is_flag else f"{names} {_value_of(option)}"


def _meaning(option: click.Option) -> str:
    default = f" The default is {option.default}." if option.show_default and not option.is_flag else ""
    return _paragraphs((option.help or "") + default)


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
    """Return what all functions that draw have in common, and how to call each."""
    module = importlib.import_module(PICTURES)
    yield _paragraphs(inspect.getdoc(module) or "") + "\n"
    yield "[fretsolve plot](commands.md#fretsolve-plot) says what each draws, `help(fretsolve.post.plots.loop)` how.\n"
    for name in module.__all__:
        if name[0].islower():
            yield f"- `{name}{_signature(_found(PICTURES, name)).partition(' -> ')[0]}`"


def python_closed_forms() -> Iterator[str]:
    """Return a table of the modules of the closed forms, with their functions and the classes that these return."""
    rows = []
    for name in CLOSED_FORMS:
        module = importlib.import_module(name)
        names = [
            f"`{each}`"
            for each, subject in vars(module).items()
            if callable(subject) and subject.__module__ == name and each[0] != "_"
            if not getattr(subject, "_is_protocol", False)
        ]
        rows.append((f"`{name.rpartition('.')[2]}`", _in_a_cell(_first_paragraph(module)), ", ".join(names)))
    yield from table(("module", "subject", "functions and classes"), rows)


def python_errors() -> Iterator[str]:
    """Return the errors."""
    waiting: list[type[FretsolveError]] = [FretsolveError]
    while waiting:
        kind = waiting.pop(0)
        waiting = [*kind.__subclasses__(), *waiting]
        if kind.__module__ == FretsolveError.__module__:
            base = kind.__bases__[0].__name__
            yield f"- `{kind.__name__}` (a kind of `{base}`): {_paragraphs(_first_paragraph(kind))}"


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
        if len(names) <= MOST_NAMED:  # those of the history are on its page
            yield f"Attributes: {', '.join(f'`{name}`' for name in names)}.\n"
    if inspect.isclass(subject):
        yield from (f"- {member}: {meaning}" for member, meaning in _members(subject))
        yield ""


def _members(subject: type) -> Iterator[tuple[str, str]]:
    if issubclass(subject, enum.Enum):
        yield from ((f"`{member.name}`", str(member.value)) for member in subject)
    for name, member in vars(subject).items():
        text = inspect.getdoc(member)
        if name[0] == "_" or not text:
            continue
        if isinstance(member, property):
            yield f"`{name}`", " ".join(_paragraphs(text).split())
        elif inspect.isfunction(member):
            yield f"`{name}{_signature(member)}`", " ".join(_paragraphs(text).split())


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
