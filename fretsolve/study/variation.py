"""What a study varies: keys of the case over values, crossed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fretsolve.errors import CaseError, KeyPath, dotted

EVERY_STAGE = "load_path.*."
"""What a key begins with that stands for that of every stage, those of cycles included."""

STRAY_STAR = "* stands for every stage, as in load_path.*.increments=5,10,20, and for nothing else"

_OPENING, _CLOSING, _QUOTES = "[{(", "]})", "'\""


@dataclass(frozen=True)
class Variation:
    """A key, dotted as `--set` takes it or with `EVERY_STAGE`, and the texts of its values."""

    key: str
    values: tuple[str, ...]

    @property
    def changes_the_problem(self) -> bool:
        """Whether the exact solution depends on the key, so that differences are no errors."""
        first, _, rest = self.key.partition(".")
        return first in ("bodies", "surface", "friction") or (
            first == "load_path" and rest.rpartition(".")[2] not in ("increments", "spacing")
        )


@dataclass(frozen=True)
class Setting:
    """One value of a varied key."""

    key: str
    value: str

    @property
    def origin(self) -> str:
        """As it could stand on the command line."""
        return f"--vary {self.key}={self.value}"

    @property
    def words(self) -> str:
        """For a sentence, such as ``64 x 64`` or ``tolerance 1e-4``."""
        name = self.key.rpartition(".")[2]
        if self.key == "grid.points":
            sides = self.value.strip("[] ").split(",")
            return " x ".join(side.strip() for side in (sides if len(sides) == 2 else 2 * sides))
        if name == "increments" and self.value.isdecimal():
            noun = "increment" if int(self.value) == 1 else "increments"
            place = "per stage" if self.key.startswith(EVERY_STAGE) else f"in {self.key.rpartition('.')[0]}"
            return f"{self.value} {noun} {place}"
        return f"{name.replace('_', ' ')} {self.value}"

    def overrides(self, stages: Sequence[KeyPath]) -> list[str]:
        """What `--set` takes; `stages`: the keys of all stages."""
        if not self.key.startswith(EVERY_STAGE):
            return [f"{self.key}={self.value}"]
        rest = self.key.removeprefix(EVERY_STAGE)
        return [f"{dotted(stage)}.{rest}={self.value}" for stage in dict.fromkeys(stages)]


@dataclass(frozen=True)
class Combination:
    """A setting for each of the varied keys."""

    settings: tuple[Setting, ...]

    @property
    def words(self) -> str:
        """For a sentence, such as ``64 x 64, 10 increments per stage, tolerance 1e-4``."""
        return ", ".join(setting.words for setting in self.settings)

    def is_first_problem(self, variations: Sequence[Variation]) -> bool:
        """Whether all keys that change the problem have their first values; `variations`: of the settings, in turn."""
        pairs = zip(variations, self.settings, strict=True)
        return all(one.value == key.values[0] for key, one in pairs if key.changes_the_problem)

    @property
    def short(self) -> str:
        """The values alone, for a label."""
        return ", ".join(setting.value for setting in self.settings)


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
    """Read ``KEY=A,B,C``: commas within brackets or quotes separate nothing. Raises CaseError."""
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


def has_stray_star(key: str) -> bool:
    """Whether a star in `key` stands for something else than every stage."""
    return "*" in key and (not key.startswith(EVERY_STAGE) or key.count("*") > 1 or key == EVERY_STAGE)


def crossed(variations: Sequence[Variation]) -> list[Combination]:
    """All combinations, the last key's values next to one another."""
    settings = [[Setting(variation.key, value) for value in variation.values] for variation in variations]
    return [Combination(chosen) for chosen in itertools.product(*settings)]


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
