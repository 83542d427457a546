"""The sweep file, and the points of a sweep: the values of its axes, each with its place in the file."""

from __future__ import annotations

import csv
import itertools
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, StrictBool, StrictFloat, StrictInt, Tag, model_validator

from fretsolve.case.base import CaseModel, Count, refused_at
from fretsolve.case.loading import EVERY_STAGE
from fretsolve.case.quantities import QuantityError, shown, split_quantity
from fretsolve.case.source import CaseSource, parse
from fretsolve.errors import CaseError, CaseErrors, FileError, KeyPath, dotted, together
from fretsolve.sweep import MOST_CASES
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import require_regular

Number = StrictInt | StrictFloat | str
"""A number, or text of a number with its unit."""


class Interval(CaseModel):
    """The interval from which a key of a Latin hypercube is drawn."""

    start: Number = Field(alias="from", description="first value, such as 100 N")
    to: Number = Field(description="last value, in the same unit")
    spacing: Literal["linear", "log"] = Field(default="linear", description="of the values: linear or log")


class Range(Interval):
    """Values between two ends, both included."""

    count: Annotated[int, Field(strict=True, ge=2, le=MOST_CASES)] = Field(description="how many values, such as 5")


class LatinHypercube(CaseModel):
    """Points that fill a box of several keys evenly, drawn at random from a seed."""

    samples: Annotated[int, Field(strict=True, ge=1, le=MOST_CASES)] = Field(description="how many points, such as 100")
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(default=0, description="of the random numbers")
    over: dict[str, Interval] = Field(min_length=1, description="keys, each with from, to and spacing")


class CsvAxis(CaseModel):
    """Points from a CSV file: a column per key, a row per point, an empty cell for the case's own value."""

    csv: str = Field(description="name of the CSV file, relative to the sweep file")


class LatinHypercubeAxis(CaseModel):
    """Points of a Latin hypercube."""

    latin_hypercube: LatinHypercube


def _values_tag(value: object) -> str:
    return "(range)" if isinstance(value, dict | Range) else "(list)"


Values = Annotated[
    Annotated[Range, Tag("(range)")] | Annotated[tuple[Any, ...], Field(min_length=1), Tag("(list)")],
    Discriminator(_values_tag),
]


def _axis_tag(value: object) -> str:
    if isinstance(value, dict) and "csv" in value:
        return "(csv)"
    return "(latin hypercube)" if isinstance(value, dict) and "latin_hypercube" in value else "(keys)"


Axis = Annotated[
    Annotated[CsvAxis, Tag("(csv)")]
    | Annotated[LatinHypercubeAxis, Tag("(latin hypercube)")]
    | Annotated[dict[str, Values], Field(min_length=1), Tag("(keys)")],
    Discriminator(_axis_tag),
]
"""Keys that go together, value by value; a file or a random sample of such points."""


class SlurmSpec(CaseModel):
    """Resources of a task of a Slurm job array, and how many tasks there are."""

    cases_per_task: Count = Field(default=1, description="cases that a task runs one after another")
    at_once: Count | None = Field(default=None, description="tasks that may run at the same time")
    time: str | StrictInt | None = Field(default=None, description="limit of a task, such as '02:00:00' or minutes")
    memory: str | None = Field(default=None, description="of a task, such as 2G")
    warning: Count = Field(default=60, description="seconds before the limit at which a task stops and requeues")
    options: tuple[str, ...] = Field(default=(), description="more options of sbatch, such as --partition=main")
    setup: tuple[str, ...] = Field(default=(), description="lines of the script before fretsolve, such as module load")

    @model_validator(mode="after")
    def _options_are_words(self) -> Self:
        wrong = [(i, text) for i, text in enumerate(self.options) if not text.startswith("-") or "\n" in text]
        refused_at(
            (("options", i), f"{shown(text)} is not an option of sbatch; one such as --partition=main is needed")
            for i, text in wrong
        )
        return self


class SweepSpec(CaseModel):
    """Sweep file of fretsolve: a case, and the points of its keys at which it runs."""

    title: str | None = Field(default=None, description="for people")
    case: str = Field(description="name of the case file, relative to the sweep file")
    set: dict[str, Any] = Field(default={}, description="keys that are the same at all points, with their values")
    axes: tuple[Axis, ...] = Field(
        min_length=1, description="a list; keys of one entry go together, entries are crossed with one another"
    )
    quantities: tuple[str, ...] = Field(
        default=(),
        description="what is collected: NAME or NAME@STAGE, such as delta_x@2; by default responses to the load path",
    )
    threads: Count = Field(default=1, description="threads of each case")
    error_bars: StrictBool = Field(default=False, description="whether each case estimates its errors")
    slurm: SlurmSpec = Field(default=SlurmSpec(), description="resources under Slurm")


MOST_SHOWN = 10
"""Problems that are reported one by one."""


@dataclass(frozen=True)
class Value:
    """A value of a varied key, both as text, and its place: a file, the key there and the line."""

    name: str
    text: str
    file: Path | str
    key: KeyPath
    line: int | None = None

    def problem(self, message: str, inside: KeyPath = ()) -> CaseError:
        """Return the error of this value, or of something `inside` it."""
        return CaseError(message, (*self.key, *inside), self.file, self.line)


Point = tuple[Value, ...]


def overrides_of(name: str, text: str, stages: Sequence[KeyPath]) -> list[str]:
    """Return a varied key and its value as `--set` takes them; stages: the keys of all stages."""
    if not name.startswith(EVERY_STAGE):
        return [f"{name}={text}"]
    rest = name.split(".", 2)[2]
    return [f"{dotted(stage)}.{rest}={text}" for stage in dict.fromkeys(stages)]


def problem_of(name: str) -> str:
    """Return what is wrong with the name of a varied key, empty if nothing is."""
    if "*" in name and (not name.startswith(EVERY_STAGE) or name.count("*") > 1 or name in EVERY_STAGE):
        return "* stands for every stage, as in stage.*.increments=5,10,20, and for nothing else"
    if "=" in name or not all(name.split(".")):
        return f"{shown(name)} is not a key of a case; one such as grid.points is needed"
    return ""


def all_of(found: Iterable[CaseError]) -> CaseError:
    """Return one error for several problems, of which it lists the first `MOST_SHOWN`."""
    problems = list(found)
    if len(problems) > MOST_SHOWN:
        more = CaseError(f"and {len(problems) - MOST_SHOWN} more problems", (), problems[-1].file)
        problems = [*problems[:MOST_SHOWN], more]
    return together(problems)


def common_values(spec: SweepSpec, source: CaseSource) -> Point:
    """Return the values that all points share. Raises CaseError."""
    return tuple(_value(key, text_of(value), source, ("set", key)) for key, value in spec.set.items())


def points_of(spec: SweepSpec, source: CaseSource) -> list[Point]:
    """Return all points; the points of the last axis are neighbours. Raises CaseError, FileError."""
    axes: list[list[Point]] = []
    problems: list[CaseError] = []
    for index, axis in enumerate(spec.axes):
        try:
            axes.append(_axis_points(axis, source, ("axes", index)))
        except CaseError as error:
            problems += error.problems if isinstance(error, CaseErrors) else [error]
    if problems:
        raise all_of(problems)
    count = math.prod(map(len, axes))
    if count > MOST_CASES:
        raise source.problem(f"the axes cross to {count} cases; at most {MOST_CASES} are possible", ("axes",))
    return crossed(axes)


def crossed(axes: Iterable[Sequence[Point]]) -> list[Point]:
    """Return all combinations of a point of each axis; the points of the last axis are neighbours."""
    return [tuple(itertools.chain.from_iterable(parts)) for parts in itertools.product(*axes)]


def text_of(value: object) -> str:
    """Return a value of the sweep file as `--set` takes it: text stays as it is if YAML reads it so."""
    if isinstance(value, str):
        with suppress(CaseError):
            if parse(value).value == value:
                return value
    return json.dumps(value, ensure_ascii=False)


def _axis_points(axis: Axis, source: CaseSource, key: KeyPath) -> list[Point]:
    if isinstance(axis, CsvAxis):
        return list(_read_csv(source.path.parent / axis.csv, source, (*key, "csv")))
    if isinstance(axis, LatinHypercubeAxis):
        return _sampled(axis.latin_hypercube, source, (*key, "latin_hypercube"))
    columns = [_column(name, values, source, (*key, name)) for name, values in axis.items()]
    if len(set(map(len, columns))) > 1:
        counts = ", ".join(f"{name} has {len(column)}" for name, column in zip(axis, columns, strict=True))
        raise source.problem(
            f"keys of one entry go together and need equally many values: {counts}; separate entries are crossed", key
        )
    return list(zip(*columns, strict=True))


def _column(name: str, values: object, source: CaseSource, key: KeyPath) -> list[Value]:
    if isinstance(values, Range):
        return _spread(name, values, np.linspace(0.0, 1.0, values.count), source, key)
    assert isinstance(values, tuple)
    return [_value(name, text_of(value), source, (*key, index)) for index, value in enumerate(values)]


def _value(name: str, text: str, source: CaseSource, key: KeyPath) -> Value:
    if problem := problem_of(name):
        raise source.problem(problem, key)
    return Value(name, text, source.path, key, source.locate(key))


def _spread(name: str, interval: Interval, shares: DoubleArray, source: CaseSource, key: KeyPath) -> list[Value]:
    """Return the values at `shares` of the way from one end of an interval to the other. Raises CaseError."""
    try:
        (low, unit), (high, other) = split_quantity(interval.start), split_quantity(interval.to)
    except QuantityError as error:
        raise source.problem(str(error), key) from None
    log = interval.spacing == "log"
    if unit != other:
        message = f"from is in {unit or 'no unit'}, to in {other or 'no unit'}; the same unit is needed"
        raise source.problem(message, key)
    if low == high:
        raise source.problem(f"from and to are both {shown(interval.start)}; two values are needed", key)
    if log and not low * high > 0.0:
        raise source.problem("log spacing needs two ends above 0, or two below", key)
    with np.errstate(over="ignore", invalid="ignore"):
        numbers = low * (high / low) ** shares if log else low + (high - low) * shares
    if not np.isfinite(numbers).all():
        raise source.problem(f"from {shown(interval.start)} to {shown(interval.to)} is too wide for numbers", key)
    # 10 digits, so that 0.1 is written as 0.1
    return [_value(name, f"{number:.10g} {unit}".rstrip(), source, key) for number in numbers.tolist()]


def _sampled(sample: LatinHypercube, source: CaseSource, key: KeyPath) -> list[Point]:
    from scipy.stats import qmc  # takes most of a second to import

    unit_cube = qmc.LatinHypercube(len(sample.over), seed=sample.seed).random(sample.samples)
    axes = zip(sample.over.items(), unit_cube.T, strict=True)
    columns = [_spread(name, interval, shares, source, (*key, "over", name)) for (name, interval), shares in axes]
    return list(zip(*columns, strict=True))


def _read_csv(path: Path, source: CaseSource, key: KeyPath) -> Iterator[Point]:
    """Yield the points of a CSV file. Raises CaseError with its line, FileError."""
    try:
        require_regular(path, 2**28)
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [(reader.line_num, row) for reader in [csv.reader(file)] for row in reader if any(row)]
    except (OSError, ValueError) as error:  # ValueError: not UTF-8, or a NUL in the name
        raise FileError(f"cannot be read: {getattr(error, 'strerror', None) or error}", path) from None
    except csv.Error as error:
        raise CaseError(f"not a CSV file: {error}", (), path) from None
    if len(lines) < 2:
        raise source.problem(f"{path.name} has no points; a line of keys and one line per point are needed", key)
    (head, names), *rows = lines
    names = [name.strip() for name in names]
    for name in names:
        if problem_of(name) or names.count(name) > 1:
            raise CaseError(f"{shown(name)} is not a key of a case, or stands twice", (), path, head)
    for line, row in rows:
        if len(row) != len(names):
            raise CaseError(f"the line has {len(row)} cells, the heading {len(names)}", (), path, line)
        cells = zip(names, map(str.strip, row), strict=True)
        yield tuple(Value(name, text, path, (name,), line) for name, text in cells if text)
