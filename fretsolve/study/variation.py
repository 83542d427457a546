"""The varied keys of a study: keys of the case with their values, crossed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fretsolve.errors import CaseError
from fretsolve.sweep.points import EVERY_STAGE, STRAY_STAR, Setting, has_stray_star

_OPENING, _CLOSING, _QUOTES = "[{(", "]})", "'\""


@dataclass(frozen=True)
class Variation:
    """A key, dotted as `--set` takes it or with `EVERY_STAGE`, and its values as text."""

    key: str
    values: tuple[str, ...]

    @property
    def changes_the_problem(self) -> bool:
        """Whether the exact solution depends on the key, so that differences are not errors."""
        first, _, rest = self.key.partition(".")
        return first in ("bodies", "surface", "friction") or (
            first in ("load_path", "stage") and rest.rpartition(".")[2] not in ("increments", "spacing")
        )


def words(settings: Sequence[Setting]) -> str:
    """Return settings for a sentence, such as ``64 x 64, 10 increments per stage, tolerance 1e-4``."""
    return ", ".join(map(_words, settings))


def short(settings: Sequence[Setting]) -> str:
    """Return the values alone, for a label."""
    return ", ".join(setting.value for setting in settings)


def is_first_problem(settings: Sequence[Setting], variations: Sequence[Variation]) -> bool:
    """Return whether all keys that change the problem have their first values."""
    pairs = zip(variations, settings, strict=True)
    return all(one.value == key.values[0] for key, one in pairs if key.changes_the_problem)


def read_variations(texts: Sequence[str]) -> tuple[Variation, ...]:
    """Read all of ``KEY=A,B,C``. Raises CaseError."""
    variations: dict[str, Variation] = {}
    for text in texts:
        variation = read_variation(text)
        if variation.key in variations:
            raise _refused(f"{variation.key} is varied twice; give all of its values at once", text)
        variations[variation.key] = variation
    return tuple(variations.values())


def read_variation(text: str) -> Variation:
    """Read ``KEY=A,B,C``. Commas within brackets or quotes separate nothing. Raises CaseError."""
    key, equals, rest = (part.strip() for part in text.partition("="))
    if not equals or not all(key.split(".")) or not rest:
        raise _refused("KEY=A,B,C is needed, such as grid.points=32,64,128", text)
    if has_stray_star(key):
        raise _refused(STRAY_STAR, text)
    values = tuple(_split(rest))
    if not all(values):
        raise _refused("a value is missing between two commas, or at an end", text)
    repeated = next((value for value in values if values.count(value) > 1), None)
    if repeated is not None:
        raise _refused(f"the value {repeated} is given twice; once is enough", text)
    return Variation(key, values)


def crossed(variations: Sequence[Variation]) -> list[tuple[Setting, ...]]:
    """Return all combinations; the values of the last key are neighbours."""
    settings = [[Setting(variation.key, value) for value in variation.values] for variation in variations]
    return list(itertools.product(*settings))


def _words(setting: Setting) -> str:
    name = setting.key.rpartition(".")[2]
    if setting.key == "grid.points":
        sides = setting.value.strip("[] ").split(",")
        return " x ".join(side.strip() for side in (sides if len(sides) == 2 else 2 * sides))
    if name == "increments" and setting.value.isdecimal():
        noun = "increment" if int(setting.value) == 1 else "increments"
        place = "per stage" if setting.key.startswith(EVERY_STAGE) else f"in {setting.key.rpartition('.')[0]}"
        return f"{setting.value} {noun} {place}"
    return f"{name.replace('_', ' ')} {setting.value}"


def _split(text: str) -> Iterator[str]:
    start, depth, quote = 0, 0, ""
    for index, character in enumerate(text):
        if quote:
            quote = "" if character == quote else quote
        elif character in _QUOTES:
            quote = character
        elif character == "," and not depth:
            yield text[start:index].strip()
            start = index + 1
        else:
            depth += (character in _OPENING) - (character in _CLOSING)
    yield text[start:].strip()


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--vary {text if text.isprintable() else repr(text)}")
