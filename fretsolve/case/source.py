"""Read the YAML text of a case into plain values, and note the line of each key.

Scalars follow YAML 1.2's core schema rather than PyYAML's 1.1: ``1e-6`` is a number, ``yes`` and ``on`` are
text, ``010`` is ten and ``1:30`` is text.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from fretsolve.case.keys.unrolled_path import typed_key
from fretsolve.case.quantities import shown
from fretsolve.errors import CaseError, FileError, KeyPath
from fretsolve.system.files import read_bytes, read_pipe

_HDF5 = b"\x89HDF\r\n\x1a\n"
_LARGEST_FILE = 4 * 1024 * 1024
_DEEPEST_NESTING = 50
_TOO_DEEP = f"values are nested more than {_DEEPEST_NESTING} levels deep"
_LARGEST_SIZE = 100_000
_TAG = "tag:yaml.org,2002:"

try:
    from yaml import CSafeLoader as _BaseLoader
except ImportError:  # PyYAML without libyaml
    from yaml import SafeLoader as _BaseLoader  # type: ignore[assignment]


class _Loader(_BaseLoader):
    """PyYAML's safe loader with the scalars of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - PyYAML's interface


_Loader.add_implicit_resolver(_TAG + "null", re.compile(r"^(?:~|null|Null|NULL|)$"), ["~", "n", "N", ""])
_Loader.add_implicit_resolver(_TAG + "bool", re.compile(r"^(?:[Tt]rue|TRUE|[Ff]alse|FALSE)$"), list("tTfF"))
_Loader.add_implicit_resolver(_TAG + "int", re.compile(r"^[-+]?[0-9]+$"), list("-+0123456789"))
_Loader.add_implicit_resolver(
    _TAG + "float",
    re.compile(
        r"^(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$"
    ),
    list("-+.0123456789"),
)


@dataclass(frozen=True)
class Place:
    """The line of a key, and the places of the values inside."""

    line: int
    inside: dict[str | int, Place] = field(default_factory=dict)


@dataclass(frozen=True)
class Override:
    """A value given by ``--set KEY=VALUE`` in place of the file's. given: by what, for messages."""

    key: KeyPath
    text: str
    given: str = "--set"

    @property
    def name(self) -> str:
        """The key as it was written."""
        return self.text.partition("=")[0].strip()

    @property
    def origin(self) -> str:
        """The override as it was given, on one line."""
        return f"{self.given} {self.text if self.text.isprintable() else repr(self.text)}"


@dataclass(frozen=True)
class CaseSource:
    """The origin of a case: the file, its text as written, and where each key stands in it.

    data: the plain values, overrides included, or None.
    """

    path: Path
    text: str = field(repr=False)
    root: Place = field(repr=False)
    overrides: tuple[Override, ...] = ()
    data: Any = field(default=None, repr=False, compare=False)

    def locate(self, key: KeyPath) -> int | None:
        """Return the line (1-based) of `key` or of its nearest parent; None if an override gave the value."""
        if self._override(key) is not None:
            return None
        place = self.root
        for part in key:
            if part not in place.inside:
                break
            place = place.inside[part]
        return place.line

    def typed(self, key: KeyPath) -> KeyPath:
        """Return `key` as one types it: with the number of a stage, as `--set` counts, and as the file has it."""
        written = self._as_written(key)
        load_path = self.data.get("load_path") if isinstance(self.data, dict) else None
        return typed_key(load_path, written)

    def _as_written(self, key: KeyPath) -> KeyPath:
        """Return `key` without the index of a list of one, if the file has the entry itself there."""
        written: list[str | int] = []
        place = self.root
        for index, part in enumerate(key):
            if part in place.inside:
                place = place.inside[part]
            elif isinstance(part, int) and key[index + 1 : index + 2] and key[index + 1] in place.inside:
                continue
            written.append(part)
        return tuple(written)

    def problem(self, message: str, key: KeyPath = ()) -> CaseError:
        """Return the error of the value at `key`, with its file and line, or with the override that gave it."""
        override = self._override(key)
        if override is not None:
            return CaseError(message, self.typed(key), override.origin)
        written = self._as_written(key)
        within = [o.origin for o in self.overrides if key and o.key[: len(written)] == written]
        message += f" (with {', '.join(within)})" if within else ""
        return CaseError(message, self.typed(key), self.path, self.locate(written))

    def _override(self, key: KeyPath) -> Override | None:
        matching = (override for override in reversed(self.overrides) if key[: len(override.key)] == override.key)
        return next(matching, None)


@dataclass(frozen=True)
class Parsed:
    """Plain values (dict, list, str, int, float, bool, None) of a YAML text, their places, and what cannot be used."""

    value: Any
    place: Place
    flaws: tuple[CaseError, ...]


def read_text(path: Path, *, pipe: bool = False) -> str:
    """Return the text of a case file. Raises `FileError` if it cannot be read, `CaseError` if it cannot be a case.

    pipe: the file may be a pipe, which can be read once.
    """
    try:
        if pipe and path.is_fifo():
            content = read_pipe(path, _LARGEST_FILE)
        elif path.is_file() and path.stat().st_size > _LARGEST_FILE:
            raise CaseError(f"the file is larger than {_LARGEST_FILE // 1024**2} MiB; a case is needed", (), path)
        else:
            content = read_bytes(path, _LARGEST_FILE)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        raise FileError(f"cannot be read: {getattr(error, 'strerror', None) or error}{_meant(path)}", path) from None
    if content.startswith(_HDF5):
        raise CaseError("an HDF5 file, such as the result of a run; a case, a YAML text file, is needed", (), path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        message = f"byte 0x{content[error.start]:02x} is not UTF-8 text; a YAML text file in UTF-8 is needed"
        raise CaseError(message, (), path, line) from None


def _meant(path: Path) -> str:
    """Return a question for a file that does not exist, if one with the ending of a case does."""
    for ending in (".yaml", ".yml"):
        with suppress(OSError, ValueError):
            if not path.exists() and (near := path.with_name(path.name + ending)).is_file():
                return f"; did you mean {near}?"
    return ""


def parse(text: str) -> Parsed:
    """Parse YAML. Raises `CaseError` with the line if that is impossible; values that cannot be used become flaws."""
    try:
        _refuse_excess(text)
        loader = _Loader(text)
        try:
            node = loader.get_single_node()
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        raise _syntax_error(error) from None
    except yaml.reader.ReaderError as error:
        line = text.encode()[: error.position].count(b"\n") + 1
        raise CaseError(f"the control character #x{error.character:02x} is not allowed", line=line) from None
    except UnicodeEncodeError:
        raise CaseError("the text is not valid Unicode", line=1) from None
    if node is None:
        return Parsed(None, Place(1), ())
    builder = _Builder()
    built = builder.build(node, (), _line(node))
    return Parsed(built.value, Place(_line(node), built.inside), tuple(builder.flaws))


def _line(node: yaml.Node | yaml.Event) -> int:
    return node.start_mark.line + 1 if node.start_mark is not None else 1


def _refuse_excess(text: str) -> None:
    """Refuse deep nesting, for which libyaml's composer would overflow the C stack, and more values than are used."""
    depth = values = 0
    for event in yaml.parse(text, Loader=_Loader):
        values += isinstance(event, yaml.NodeEvent)
        if values > 2 * _LARGEST_SIZE:  # keys are such events as well
            raise CaseError(f"there are more than {_LARGEST_SIZE} values", line=_line(event))
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST_NESTING:
            raise CaseError(_TOO_DEEP, line=_line(event))


def _syntax_error(error: yaml.MarkedYAMLError) -> CaseError:
    mark = error.problem_mark or error.context_mark
    line = mark.line + 1 if mark is not None else 1
    problem = error.problem or ""
    if "nesting depth" in problem:  # the scanner's own limit, which newer releases of libyaml have
        return CaseError(_TOO_DEEP, line=line)
    message = f"not valid YAML: {problem or error.context}"
    if error.context and problem:
        begun = error.context_mark.line + 1 if error.context_mark is not None else line
        message += f", {error.context}" + (f" begun on line {begun}" if begun != line else "")
    if "tab character" in problem:
        message += "; indent with spaces"
    if "mapping values are not allowed" in problem:
        message += "; several keys on one line stand in braces, as in {Qx: 45 N, increments: 5}"
    if "cannot start any token" in problem:
        message += "; indent with spaces, not tabs, and quote text that begins with @, ` or %"
    return CaseError(" ".join(message.split()), line=line)


@dataclass(frozen=True)
class _Built:
    """The value of a node and the places inside; size and depth count each repetition by an alias."""

    value: Any
    inside: dict[str | int, Place] = field(default_factory=dict)
    size: int = 1
    depth: int = 1


class _Builder:
    """Turn YAML nodes into plain values; a node that aliases repeat is built once."""

    def __init__(self) -> None:
        self.flaws: list[CaseError] = []
        self._done: dict[int, _Built] = {}
        self._open: set[int] = set()

    def build(self, node: yaml.Node, key: KeyPath, line: int) -> _Built:
        """Return the value of `node`, whose key stands on `line`."""
        identity = id(node)
        if identity in self._open:
            return self._refused(key, line, "the alias contains itself; a value without a loop is needed")
        if identity not in self._done:
            self._open.add(identity)
            built = self._contents(node, key, line)
            self._open.discard(identity)
            if built.size > _LARGEST_SIZE or built.depth > _DEEPEST_NESTING:
                built = self._refused(
                    key, line, f"its aliases expand to more than {_LARGEST_SIZE} values or {_DEEPEST_NESTING} levels"
                )
            self._done[identity] = built
        return self._done[identity]

    def _contents(self, node: yaml.Node, key: KeyPath, line: int) -> _Built:
        if isinstance(node, yaml.MappingNode) and node.tag == _TAG + "map":
            return self._mapping(node, key)
        if isinstance(node, yaml.SequenceNode) and node.tag == _TAG + "seq":
            lines = [_line(item) for item in node.value]
            items = [self.build(item, (*key, i), lines[i]) for i, item in enumerate(node.value)]
            return _collected([item.value for item in items], dict(enumerate(items)), dict(enumerate(lines)))
        if isinstance(node, yaml.ScalarNode):
            return self._scalar(node, key, line)
        return self._refused(key, line, f"unknown tag {shown(node.tag)}; a value without a tag is needed")

    def _mapping(self, node: yaml.MappingNode, key: KeyPath) -> _Built:
        items: dict[str, _Built] = {}
        lines: dict[str, int] = {}
        for key_node, value_node in node.value:
            line, name = _line(key_node), key_node.value
            name = name if isinstance(key_node, yaml.ScalarNode) else "of several parts"
            if name[:1].isdigit() and value_node.tag == _TAG + "null":  # as in {P: 400,5 N}
                needed = "the decimal separator is a point, and thousands have none"
                self._refused(key, line, f"the key {shown(name)} is not a name; {needed}")
            elif not isinstance(key_node, yaml.ScalarNode) or key_node.tag not in (_TAG + "str", _TAG + "int"):
                self._refused(key, line, f"the key {shown(name)} is not a name; keys are text")
            elif name in items:
                message = f"duplicate key {shown(name)}, given first on line {lines[name]}; keep one of the two"
                self._refused((*key, name), line, message)
            else:
                items[name], lines[name] = self.build(value_node, (*key, name), line), line
        return _collected({name: item.value for name, item in items.items()}, items, lines)

    def _scalar(self, node: yaml.ScalarNode, key: KeyPath, line: int) -> _Built:
        kind, text = node.tag.removeprefix(_TAG), node.value
        try:
            if kind == "str":
                return _Built(text)
            if kind == "int":
                return _Built(int(text))
            if kind == "float":
                return _Built(float(text.lower().replace(".inf", "inf").replace(".nan", "nan")))
        except ValueError:
            return self._refused(key, line, f"{shown(text)} cannot be read as a number")
        if kind == "bool" and text.lower() in ("true", "false"):
            return _Built(text.lower() == "true")
        if kind == "null":
            return self._refused(key, line, "no value is given; give one or remove the key")
        return self._refused(key, line, f"unknown tag {shown(node.tag)}; a value without a tag is needed")

    def _refused(self, key: KeyPath, line: int, message: str) -> _Built:
        self.flaws.append(CaseError(message, key, line=line))
        return _Built(None)


def _collected(value: Any, items: Mapping[Any, _Built], lines: Mapping[Any, int]) -> _Built:
    inside = {key: Place(lines[key], item.inside) for key, item in items.items()}
    size = 1 + sum(item.size for item in items.values())
    return _Built(value, inside, size, 1 + max((item.depth for item in items.values()), default=0))
