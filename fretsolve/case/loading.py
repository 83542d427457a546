"""Read a case: from the file and its overrides to a validated `Case`, or to the problems with their lines."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.unrolled_path import stage_key, stage_keys
from fretsolve.case.models import Case
from fretsolve.case.quantities import shown
from fretsolve.case.schema import model_schema, nearest_key, translated
from fretsolve.case.source import CaseSource, Override, Place, parse, read_text
from fretsolve.errors import CaseError, CaseErrors, FileError, KeyPath, dotted, together

File = TypeVar("File", bound=BaseModel)

EVERY_STAGE = ("stage.*.", "load_path.*.")
"""Beginnings of a key that sets the key of every stage, stages of cycles included."""

MATERIALS: tuple[KeyPath, ...] = (("output", "fatigue", "material"), ("output", "crack", "material"))
"""The keys that may name a file of constants."""


@dataclass(frozen=True)
class CaseText:
    """A case file, read and parsed once for any number of cases that differ in overrides.

    data: plain values as written; problems: parts of the YAML that cannot be used.
    """

    data: Any
    source: CaseSource
    problems: tuple[CaseError, ...] = ()

    def require_mapping(self, needed: Sequence[str]) -> None:
        """Raise `CaseError` if the file holds anything but a mapping and has no other problem. needed: keys."""
        if not self.problems and not isinstance(self.data, dict):
            what = "the file is empty" if self.data is None else "the file does not hold a mapping"
            raise self.source.problem(f"{what}; one with the keys {', '.join(needed)} is needed")

    def overridden(self, overrides: Sequence[str], given: str = "--set") -> CaseText:
        """Return the text with `overrides` (see `load_case`) if it holds a mapping; their faults join its problems.

        given: by what, for messages.
        """
        if not isinstance(self.data, dict):
            return self
        # One constant of a file of a material may be overridden, too.
        problems, source, data = list(self.problems), self.source, self._with_material()
        for override in overrides:
            try:
                data, source = _overridden(data, source, override, given)
            except CaseError as problem:
                problems += problem.problems if isinstance(problem, CaseErrors) else [problem]
        # Of two overrides of one key the last one holds, unless different names hide that they mean the same.
        names: dict[KeyPath, str] = {}
        for one in source.overrides[len(self.source.overrides) :]:
            first = names.get(one.key, one.name)
            if first.startswith(EVERY_STAGE):  # which a stage of its own may follow
                first = one.name
            names[one.key] = first
            if first != one.name:
                message = f"{names[one.key]} and {one.name} are two names of one key; keep one of the two"
                problems.append(CaseError(message, (), one.origin))
        return CaseText(data, source, tuple(problems))

    def case(self, overrides: Sequence[str] = (), given: str = "--set") -> Case:
        """Return the case with `overrides` (see `load_case`; given: by what, for messages). Raises `CaseError`."""
        self.require_mapping([key for key, field in Case.model_fields.items() if field.is_required() or key == "grid"])
        if isinstance(self.data, dict) and {"case", "axes"} <= self.data.keys():
            raise self.source.problem("this is a sweep file; `fretsolve sweep run` takes it")
        text = self.overridden(overrides, given)
        case = validated(case_model(text.data), text._with_material(), text.source, text.problems)
        case._source = text.source
        return case

    def _with_material(self) -> Any:
        """Return the data with constants in place of the names of files of them, as `MATERIALS` may have.

        Raises CaseError, also for what is wrong in such a file.
        """
        data = self.data
        for key in MATERIALS:
            name = self.data
            for part in key:
                name = name.get(part) if isinstance(name, dict) else None
            if not isinstance(name, str):
                continue
            try:
                found = read_case(self.source.path.parent / name)
            except FileError as error:
                raise self.source.problem(str(error), key) from None
            found.require_mapping(list(Material.model_fields))
            validated(Material, found.data, found.source, found.problems)
            data = replaced(data, key, found.data)
        return data


def read_case(path: str | Path, *, pipe: bool = False) -> CaseText:
    """Read and parse a case file. Raises `CaseError` if it is not YAML, `FileError` if it cannot be read.

    pipe: the file may be a pipe, as on a command line; not where it is named in a file or read again.
    """
    path = Path(path)
    text = read_text(path, pipe=pipe)
    try:
        parsed = parse(text)
    except CaseError as error:
        raise CaseError(error.message, (), path, error.line) from None
    source = CaseSource(path, text, parsed.place, data=parsed.value)
    problems = [CaseError(flaw.message, source.typed(flaw.key), path, flaw.line) for flaw in parsed.flaws]
    return CaseText(parsed.value, source, tuple(problems))


def load_case(path: str | Path, overrides: Sequence[str] = ()) -> Case:
    """Read and validate a case file.

    overrides: ``KEY=VALUE`` texts, the key dotted and the value YAML, applied in order before validation;
    ``stage.*.increments`` sets the increments of every stage.
    Raises `CaseError` for what is wrong in the file or an override (`CaseErrors` for several problems, one
    line each), `FileError` if the file cannot be read.
    """
    return read_case(path, pipe=True).case((overrides,) if isinstance(overrides, str) else overrides, "override")


def case_from_dict(data: Mapping[str, Any], folder: str | Path = ".") -> Case:
    """Validate a case that is given as a dict, with the keys and values of a case file.

    Values are texts with units, numbers in mm, N, MPa, rad, lists and dicts; numbers of NumPy and paths count as such.
    folder: where the files that the case names are. Raises `CaseError` (`CaseErrors` for several problems), which names
    keys, TypeError for other types of values.
    """
    plain = json.loads(json.dumps(data, default=_plain))
    text = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    source = CaseSource(Path(folder) / "case.yaml", text, Place(1), data=plain)
    try:
        case = CaseText(plain, source).case()
    except CaseError as error:
        problems = error.problems if isinstance(error, CaseErrors) else (error,)
        found = [CaseError(one.message, one.key) for one in problems]
        raise together(found) from None
    return case


def _plain(value: Any) -> Any:
    """Return a path as text, and a number or an array of NumPy as numbers."""
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{value!r} cannot stand in a case; texts, numbers, lists and dicts can")


def case_model(data: Any) -> type[Case]:
    """Return the model of the case in `data`, plain values as in a file or in an effective case."""
    if not isinstance(data, dict) or data.get("plane") != "strain":
        return Case
    from fretsolve.case.line_case import LineCase  # other cases need not build its validators

    return LineCase


def stored_case(effective_case: Any) -> Case | None:
    """Return the case that an effective case says, None if this version does not understand it."""
    try:
        return case_model(effective_case).model_validate(effective_case)
    except ValidationError:
        return None


def _present_keys(key: KeyPath, data: dict[str, Any]) -> Sequence[KeyPath]:
    """Return the keys that an override means: one, or with ``stage.*`` one for each stage. Raises `LookupError`."""
    if key[:2] not in (("stage", "*"), ("load_path", "*")):
        return [_present_key(key, data)]
    if len(key) < 3 or "*" in key[2:]:
        raise LookupError("* stands for every stage, as in stage.*.increments=20, and for nothing else")
    return [(*stage, *key[2:]) for stage in stage_keys(data.get("load_path"))]


def _present_key(key: KeyPath, data: dict[str, Any]) -> KeyPath:
    """Return the key that an override means. Raises `LookupError` for the user if there is no such stage.

    `stage.N` is where stage N stands, counted from 1 as in results; `surface.0` is also a surface that stands alone.
    """
    if key[0] == "stage" and len(key) > 1:
        place = stage_key(data.get("load_path"), key[1])
        if place[-1] == "cycle" and key[2:] not in (("increments",), ("spacing",)):
            part = key[2] if len(key) > 2 else "Qx"
            message = f"stage {key[1]} belongs to a cycle with an amplitude, so it has increments and spacing alone"
            raise LookupError(f"{message}; {dotted(place)}.amplitude.{part} sets what moves")
        if key[2:3] == ("cycle",) and "cycle" in place:
            innermost = place[: len(place) - place[::-1].index("cycle")]
            raise LookupError(f"stage {key[1]} is within a cycle; {dotted((*innermost, *key[3:]))} is of the cycle")
        return place + key[2:]
    if key[:2] == ("surface", 0) and isinstance(data.get("surface"), dict):
        return key[:1] + key[2:]
    return key


def _overridden(data: Any, source: CaseSource, text: str, given: str) -> tuple[Any, CaseSource]:
    """Return data and source with one override. Raises `CaseError`, which names the override."""
    origin = Override((), text, given).origin
    _, equals, value_text = text.partition("=")
    parts = Override((), text).name.split(".")
    if not equals or not all(parts):
        raise CaseError("KEY=VALUE is needed, such as grid.points=64", (), origin)
    key: KeyPath = tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in parts)
    try:
        parsed = parse(value_text)
        if parsed.value is None and not parsed.flaws:
            raise CaseError("no value is given; KEY=VALUE is needed, such as grid.points=64")
        keys = _present_keys(key, data)
    except (CaseError, LookupError) as error:
        raise CaseError(str(error.args[0]), key, origin) from None
    for key in keys:
        source = replace(source, overrides=(*source.overrides, Override(key, text, given)))
        if parsed.flaws:
            raise CaseErrors([source.problem(flaw.message, (*key, *flaw.key)) for flaw in parsed.flaws])
        try:
            data = replaced(_without_constants(data, key, source), key, parsed.value)
            source = replace(source, data=data)
        except LookupError as error:
            known = (*Case.model_fields, "stage")
            unknown = f"unknown key {shown(key[0])}; {nearest_key(str(key[0]), known, model_schema(Case))}"
            raise source.problem(str(error.args[0]) if key[0] in known else unknown, key) from None
    return data, source


def _without_constants(data: Any, key: KeyPath, source: CaseSource) -> Any:
    """Return data without what the file says of the body of which an override, the last of `source`, names a material.

    Else the constants of the file would hold beside the name. Constants from other overrides stay.
    """
    if len(key) != 3 or (key[0], key[2]) != ("bodies", "material"):
        return data
    bodies, given = data.get("bodies"), {one.key for one in source.overrides}
    body = dict(enumerate(bodies)).get(key[1]) if isinstance(bodies, list) and isinstance(key[1], int) else None
    if not isinstance(body, dict):
        return data
    return replaced(data, key[:2], {name: value for name, value in body.items() if (*key[:2], name) in given})


def validated(model: type[File], data: Any, source: CaseSource, problems: Sequence[CaseError] = ()) -> File:
    """Validate `data` from `source` by `model`. Raises `CaseError` for `problems` and for what the model refuses."""
    problems = list(problems)
    flawed = {problem.key for problem in problems}
    read = None
    try:
        read = model.model_validate(data, context=source.path.parent)
    except ValidationError as error:
        found = translated(error, data, model_schema(model), source)
        problems += [problem for problem in found if problem.key not in flawed]
    if read is None or problems:
        in_order = sorted(problems, key=lambda problem: problem.line or 0)
        once = list({str(problem): problem for problem in in_order}.values())
        raise together(once)
    return read


VALUE_ALONE = {"friction": "coefficient", "accuracy": "target"}
"""Keys whose value may stand alone, and the key within that it stands for."""


def replaced(data: Any, key: Sequence[str | int], value: Any) -> Any:
    """Return a copy of `data` with `value` at `key`, and new mappings on the way. A `LookupError` is for the user.

    Beside a value that stands alone, other keys are added.
    """
    if not key:
        return value
    part, rest = key[0], key[1:]
    if isinstance(data, list):
        if not isinstance(part, int) or part >= len(data):
            entries = f"0 to {len(data) - 1}" if data else "none"
            raise LookupError(f"the list has no entry {shown(part)}; its entries are {entries}")
        return [replaced(item, rest, value) if index == part else item for index, item in enumerate(data)]
    if isinstance(part, int):
        raise LookupError(f"this is not a list with an entry {part}; give the whole list, as in grid.points=[64, 64]")
    mapping = data if isinstance(data, dict) else {}
    inner = mapping.get(part)
    if rest and part in VALUE_ALONE and isinstance(inner, str | int | float):
        inner = {VALUE_ALONE[part]: inner}
    return {**mapping, part: replaced(inner, rest, value)}
