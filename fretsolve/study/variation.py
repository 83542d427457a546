"""The varied keys of a study: keys of the case with their values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from fretsolve.case.loading import EVERY_STAGE
from fretsolve.errors import CaseError
from fretsolve.sweep.points import Point, Value, problem_of


def changes_the_problem(key: str) -> bool:
    """Return whether the exact solution depends on `key`, so that differences are not errors."""
    first, _, rest = key.partition(".")
    return first in ("bodies", "surface", "friction") or (
        first in ("load_path", "stage") and rest.rpartition(".")[2] not in ("increments", "spacing")
    )


def points_along(key: str, values: Iterable[str]) -> list[Point]:
    """Return the values of a key as an axis of a sweep."""
    return [(Value(key, value, f"--vary {key}={value}", tuple(key.split("."))),) for value in values]


def words(settings: Mapping[str, str], *, line: bool = False) -> str:
    """Return settings for a sentence, such as ``64 x 64, 10 increments per stage, tolerance 1e-4``.

    line: of a line contact, ``64 points``.
    """
    return ", ".join(_words(key, value, line) for key, value in settings.items())


def short(settings: Mapping[str, str]) -> str:
    """Return the values alone, for a label."""
    return ", ".join(settings.values())


def read_variation(text: str) -> tuple[str, tuple[str, ...]]:
    """Read ``KEY=A,B,C``. Commas within brackets or quotes separate nothing. Raises CaseError.

    The key is dotted as `--set` takes it, or begins with one of `EVERY_STAGE`; the values are texts.
    """
    key, equals, rest = (part.strip() for part in text.partition("="))
    if not equals or not all(key.split(".")) or not rest:
        raise _refused("KEY=A,B,C is needed, such as grid.points=32,64,128", text)
    if problem := problem_of(key):
        raise _refused(problem, text)
    values = tuple(_split(rest))
    if not all(values):
        raise _refused("a value is missing between two commas, or at an end", text)
    for value in values:
        if values.count(value) > 1:
            raise _refused(f"the value {value} is given twice; once is enough", text)
    return key, values


def _words(key: str, value: str, line: bool) -> str:
    stage, _, name = key.rpartition(".")
    if key == "grid.points" and line:
        return f"{value} points"
    if key == "grid.points":
        sides = value.strip("[] ").split(",")
        return " x ".join(side.strip() for side in (sides if len(sides) == 2 else 2 * sides))
    if name == "increments" and value.isdecimal():
        place = "per stage" if key.startswith(EVERY_STAGE) else f"in {stage}"
        return f"{value} increment{'' if int(value) == 1 else 's'} {place}"
    return f"{name.replace('_', ' ')} {value}"


def _split(text: str) -> Iterator[str]:
    start, depth, quote = 0, 0, ""
    for index, character in enumerate(text):
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character == "," and not depth:
            yield text[start:index].strip()
            start = index + 1
        else:
            depth += (character in "[{(") - (character in "]})")
    yield text[start:].strip()


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--vary {text if text.isprintable() else repr(text)}")
