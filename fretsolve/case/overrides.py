"""Values given by ``--set KEY=VALUE`` in place of the file's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..errors import KeyPath
from .quantities import shown
from .source import Override, Parsed, YamlSyntaxError, case_error, parse


def split_override(text: str) -> tuple[KeyPath, Parsed]:
    """Read ``KEY=VALUE``. Raises `CaseError` naming the override if it is no such text."""
    origin = Override((), text).origin
    name, equals, value_text = text.partition("=")
    parts = name.strip().split(".")
    if not equals or not all(parts):
        raise case_error("KEY=VALUE is needed, such as grid.points=64", (), origin)
    key: KeyPath = tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in parts)
    try:
        parsed = parse(value_text)
    except YamlSyntaxError as error:
        raise case_error(str(error), key, origin) from None
    if parsed.value is None and not parsed.flaws:
        raise case_error("no value is given; KEY=VALUE is needed, such as grid.points=64", key, origin)
    return key, parsed


def replaced(data: Any, key: Sequence[str | int], value: Any) -> Any:
    """A copy of `data` with `value` at `key`; mappings on the way are made where there are none.

    Raises `LookupError`, whose text is for the user, where a list has no such entry.
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
        raise LookupError(
            f"there is no list with an entry {part}; give the whole list, as in grid.points=[64, 64]"
        )
    mapping = data if isinstance(data, dict) else {}
    return {**mapping, part: replaced(mapping.get(part), rest, value)}
