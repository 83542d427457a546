"""The points of a sweep: the values of its axes, each with its place in the sweep file."""

from __future__ import annotations

import csv
import itertools
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretsolve.case.problems import CaseErrors
from fretsolve.case.quantities import QuantityError, shown, split_quantity
from fretsolve.case.source import CaseSource, parse
from fretsolve.errors import CaseError, FileError, KeyPath, dotted
from fretsolve.sweep.spec import (
    LARGEST_SWEEP,
    Axis,
    CsvAxis,
    Interval,
    LatinHypercube,
    LatinHypercubeAxis,
    Range,
    SweepSpec,
)
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import reason_of

EVERY_STAGE = "load_path.*."
"""Beginning of a key that stands for that of every stage, those of cycles included."""

STRAY_STAR = "* stands for every stage, as in load_path.*.increments=5,10,20, and for nothing else"

DIGITS = 10
"""Digits of the numbers in ranges and samples, so that 0.1 is written as 0.1."""


@dataclass(frozen=True)
class Setting:
    """One value of a varied key, both as text."""

    key: str
    value: str

    def overrides(self, stages: Sequence[KeyPath]) -> list[str]:
        """Return the setting as `--set` takes it; stages: the keys of all stages."""
        if not self.key.startswith(EVERY_STAGE):
            return [f"{self.key}={self.value}"]
        rest = self.key.removeprefix(EVERY_STAGE)
        return [f"{dotted(stage)}.{rest}={self.value}" for stage in dict.fromkeys(stages)]


def has_stray_star(key: str) -> bool:
    """Return whether a star in `key` stands for anything but every stage."""
    return "*" in key and (not key.startswith(EVERY_STAGE) or key.count("*") > 1 or key == EVERY_STAGE)


@dataclass(frozen=True)
class Value:
    """A setting and its place: a file, the key there and the line."""

    setting: Setting
    file: Path
    key: KeyPath
    line: int | None

    def problem(self, message: str, inside: KeyPath = ()) -> CaseError:
        """Return the error of this value, or of something `inside` it."""
        return CaseError(message, (*self.key, *inside), self.file, self.line)


Point = tuple[Value, ...]


def common_values(spec: SweepSpec, source: CaseSource) -> Point:
    """Return the values that all points share. Raises CaseError."""
    return tuple(_value(key, text_of(value), source, ("set", key)) for key, value in spec.set.items())


def points_of(spec: SweepSpec, source: CaseSource) -> list[Point]:
    """Return all points; those of the last axis are neighbours. Raises CaseError, FileError."""
    axes: list[list[Point]] = []
    problems: list[CaseError] = []
    for index, axis in enumerate(spec.axes):
        try:
            axes.append(_axis_points(axis, source, ("axes", index)))
        except CaseError as error:
            problems += error.problems if isinstance(error, CaseErrors) else [error]
    if problems:
        raise problems[0] if len(problems) == 1 else CaseErrors(problems)
    _refuse_repeated_keys(axes, source)
    count = math.prod(map(len, axes))
    if count > LARGEST_SWEEP:
        raise source.problem(f"the axes cross to {count} cases; at most {LARGEST_SWEEP} are possible", ("axes",))
    return [tuple(itertools.chain.from_iterable(parts)) for parts in itertools.product(*axes)]


def text_of(value: object) -> str:
    """Return a value of the sweep file as `--set` takes it: text stays as it is if YAML reads it as the same text."""
    if isinstance(value, str):
        try:
            if parse(value).value == value:
                return value
        except CaseError:
            pass
    return json.dumps(value, ensure_ascii=False)


def _refuse_repeated_keys(axes: Sequence[Sequence[Point]], source: CaseSource) -> None:
    keys = [{value.setting.key for point in axis for value in point} for axis in axes]
    for index, names in enumerate(keys):
        for name in sorted(names & set().union(*keys[:index])):
            raise source.problem(f"{name} is varied by an earlier entry as well; keep one of the two", ("axes", index))


def _axis_points(axis: Axis, source: CaseSource, key: KeyPath) -> list[Point]:
    if isinstance(axis, CsvAxis):
        return list(_read_csv(source.path.parent / axis.csv, source, (*key, "csv")))
    if isinstance(axis, LatinHypercubeAxis):
        return _sampled(axis.latin_hypercube, source, (*key, "latin_hypercube"))
    columns = [_column(name, values, source, (*key, name)) for name, values in axis.items()]
    lengths = dict(zip(axis, map(len, columns), strict=True))
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{name} has {count}" for name, count in lengths.items())
        raise source.problem(
            f"keys of one entry go together and need equally many values: {counts}; separate entries are crossed", key
        )
    return list(zip(*columns, strict=True))


def _column(name: str, values: object, source: CaseSource, key: KeyPath) -> list[Value]:
    if isinstance(values, Range):
        try:
            low, high, unit = _ends(values)
        except QuantityError as error:
            raise source.problem(str(error), key) from None
        spread = np.geomspace if values.spacing == "log" else np.linspace
        return [_value(name, text, source, key) for text in _texts(spread(low, high, values.count), unit)]
    assert isinstance(values, tuple)
    return [_value(name, text_of(value), source, (*key, index)) for index, value in enumerate(values)]


def _value(name: str, text: str, source: CaseSource, key: KeyPath) -> Value:
    if has_stray_star(name):
        raise source.problem(STRAY_STAR, key)
    if "=" in name or not all(name.split(".")):
        raise source.problem(f"{shown(name)} is not a key of a case; one such as grid.points is needed", key)
    return Value(Setting(name, text), source.path, key, source.locate(key))


def _ends(interval: Range | Interval) -> tuple[float, float, str]:
    """Return both ends and their unit. Raises QuantityError."""
    low, unit = split_quantity(interval.start)
    high, other = split_quantity(interval.to)
    if unit != other:
        raise QuantityError(f"from is in {unit or 'no unit'}, to in {other or 'no unit'}; the same unit is needed")
    if low == high:
        raise QuantityError(f"from and to are both {shown(interval.start)}; two values are needed")
    if interval.spacing == "log" and not low * high > 0.0:
        raise QuantityError("log spacing needs two ends above 0, or two below")
    return low, high, unit


def _texts(numbers: DoubleArray, unit: str) -> list[str]:
    return [f"{number:.{DIGITS}g} {unit}".rstrip() for number in numbers.tolist()]


def _sampled(sample: LatinHypercube, source: CaseSource, key: KeyPath) -> list[Point]:
    from scipy.stats import qmc  # takes most of a second to import

    unit_cube = qmc.LatinHypercube(len(sample.over), seed=sample.seed).random(sample.samples)
    columns = []
    for (name, interval), shares in zip(sample.over.items(), unit_cube.T, strict=True):
        place = (*key, "over", name)
        try:
            low, high, unit = _ends(interval)
        except QuantityError as error:
            raise source.problem(str(error), place) from None
        numbers = low * (high / low) ** shares if interval.spacing == "log" else low + (high - low) * shares
        columns.append([_value(name, text, source, place) for text in _texts(numbers, unit)])
    return list(zip(*columns, strict=True))


def _read_csv(path: Path, source: CaseSource, key: KeyPath) -> Iterator[Point]:
    """Yield the points of a CSV file. Raises CaseError with its line, FileError."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [(reader.line_num, row) for reader in [csv.reader(file)] for row in reader if any(row)]
    except (OSError, ValueError) as error:  # ValueError: not UTF-8, or a NUL in the name
        reason = reason_of(error) if isinstance(error, OSError) else str(error)
        raise FileError(f"cannot be read: {reason}", path) from None
    except csv.Error as error:
        raise CaseError(f"not a CSV file: {error}", (), path) from None
    if len(lines) < 2:
        raise source.problem(f"{path.name} has no points; a line of keys and one line per point are needed", key)
    (head, names), *rows = lines
    names = [name.strip() for name in names]
    for name in names:
        if has_stray_star(name) or "=" in name or not all(name.split(".")) or names.count(name) > 1:
            raise CaseError(f"{shown(name)} is not a key of a case, or stands twice", (), path, head)
    for line, row in rows:
        if len(row) != len(names):
            raise CaseError(f"the line has {len(row)} cells, the heading {len(names)}", (), path, line)
        cells = zip(names, map(str.strip, row), strict=True)
        yield tuple(Value(Setting(name, text), path, (name,), line) for name, text in cells if text)
