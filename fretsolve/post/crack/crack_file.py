"""The file of a crack: stress intensities over increment and length, range and threshold, and lives over length.

It lies beside the result, which stays as it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve import __version__
from fretsolve.case.models import Case
from fretsolve.post.crack.analysis import Crack, crack_of
from fretsolve.post.crack.request import case_request
from fretsolve.post.names import crack_path
from fretsolve.post.stress.computed_file import ComputedFile, create_values, opened_beside
from fretsolve.post.stress.cycles import cycles_as_text
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import Result
from fretsolve.result.header import write_sealed
from fretsolve.result.layout import STEP, Quantity, create_column
from fretsolve.result.part_reader import digests_of, read_columns, require
from fretsolve.system import atomic_files
from fretsolve.system.arrays import DoubleArray, IndexArray
from fretsolve.system.files import writing
from fretsolve.system.hdf5_files import own_dataset

FORMAT = "fretsolve crack 1"
"""Attribute `format` of the root; the number rises whenever an older fretsolve could misread a newer file."""

LENGTH = Quantity("length", "mm", "length of the crack, normal to the surface")
CYCLE = Quantity("cycle", "1", "number of the cycle, 0 for a whole load path without cycles", "int64")

_INTENSITY = "MPa m^0.5"
_OVER_STEPS = {
    "K_I": "stress intensity of mode I, negative where the crack is closed",
    "K_II": "stress intensity of mode II, an upper bound where the crack is closed",
}
_OVER_LENGTH = {
    "K_error": (_INTENSITY, "estimated error of K_I and K_II in all increments"),
    "range": (_INTENSITY, "range of K_I over a cycle, the largest of all cycles"),
    "range_error": (_INTENSITY, "estimated error of the range"),
    "threshold": (_INTENSITY, "range below which the crack does not grow"),
    "initiation_life": ("1", "cycles to a crack, from the fatigue parameter at the depth of the length"),
    "propagation_life": ("1", "cycles from a crack of the length to the end, NaN beyond it"),
    "total_life": ("1", "sum of initiation_life and propagation_life, NaN beyond the end"),
}
_OVER_CYCLES = "range of K_I over each cycle"


def write_crack(
    crack: Crack, result: Result, target: Path, *, folder: Path | None = None, exclusive: bool = False
) -> None:
    """Write a crack of a result to `target`.

    folder: where the file lies until it is whole, by default beside `target`; exclusive: replace no file. Raises
    OSError.
    """
    attributes = {
        "format": FORMAT,
        "fretsolve_version": __version__,
        "result": result.path.name,
        "material": crack.material.model_dump_json(exclude_none=True),
        "cycles": cycles_as_text(crack.cycles),
        "criterion": crack.criterion or "",
    }
    names = "title", "case_yaml", "effective_case"
    attributes |= {name: str(result.attributes[name]) for name in names if name in result.attributes}
    with atomic_files.new_hdf5(target, folder, exclusive=exclusive) as file:
        group = file.create_group(f"crack/body_{crack.body}")
        step = create_column(group, STEP, crack.steps)
        length = create_column(group, LENGTH, crack.lengths)
        of_crack = dict(zip(_OVER_STEPS, crack.K, strict=True))
        for name, values in of_crack.items():
            _store(group, name, [step, length], values, _INTENSITY, _OVER_STEPS[name])
        for name, column in _columns(crack):
            create_column(group, Quantity(name, *_OVER_LENGTH[name]), column, length)
        if len(crack.cycles) > 1:
            cycle = create_column(group, CYCLE, [one.number for one in crack.cycles])
            _store(group, "cycle_range", [cycle, length], crack.cycle_ranges, _INTENSITY, _OVER_CYCLES)
        known = {"x": crack.place.x, "y": crack.place.y, "verdict": crack.verdict, "values": crack.values}
        group.attrs.update({name: value for name, value in known.items() if isinstance(value, float | str)})
        group.attrs.update(crack.values)
        write_sealed(file, attributes, {str(crack.body): {**_digests(group), **known}})


def write_case_crack(result: Result, case: Case, folder: Path | None = None) -> Path:
    """Write the crack of a finished run beside its result, and return the name of the file.

    Raises CaseError, FileError.
    """
    target = crack_path(result.path)
    crack = crack_of(TractionHistory(result), case_request(case))
    with writing(target):
        write_crack(crack, result, target, folder=folder)
    return target


def _columns(crack: Crack) -> Iterator[tuple[str, DoubleArray]]:
    """Yield the columns over the length that are known, by their names."""
    growth = crack.growth
    ranges = crack.range, crack.range_error, crack.threshold
    values = crack.K_error, *ranges, crack.initiation, growth.propagation, growth.total
    for name, column in zip(_OVER_LENGTH, values, strict=True):
        if column is not None:
            yield name, column


def _store(group: Any, name: str, scales: list[Any], values: DoubleArray, units: str, meaning: str) -> None:
    dataset = create_values(group, name, scales, "float64", values.shape, units=units, long_name=meaning)
    dataset[:] = values


def _digests(group: Any) -> dict[str, Any]:
    """Return the digests of the columns, and of the datasets over two axes."""
    return {
        kind: digests_of({name: one[:] for name, one in group.items() if one.ndim == axes})
        for kind, axes in (("columns", 1), ("tables", 2))
    }


@dataclass(frozen=True, eq=False)
class BodyCrack:
    """The part of a file of a crack about one body.

    x, y: its place (mm); steps, lengths (mm): axes; cycles: numbers, an axis where there are several. columns: K_I,
    K_II (steps, lengths), cycle_range (cycles, lengths), and over the lengths K_error, range, range_error, threshold,
    initiation_life, propagation_life, total_life: those that are there. verdict: no crack, arrests or goes through,
    None without thresholds; values: what is known of arrest and life, with errors.
    """

    path: Path
    x: float
    y: float
    steps: IndexArray
    lengths: DoubleArray
    cycles: IndexArray
    columns: Mapping[str, DoubleArray]
    verdict: str | None
    values: Mapping[str, float]


def crack_bodies(computed: ComputedFile) -> dict[int, BodyCrack]:
    """Return the bodies of an open file of a crack. Raises FileError if it is not one, or is damaged."""
    return computed.bodies("crack", _read_body)


def read_crack(path: Path, result: Result | None = None) -> dict[str, tuple[float, float]]:
    """Return the length at which the crack in a file stops, and its life, each with its error; NaN for what is unknown.

    Raises FileError if the file is damaged, or was not computed from `result`.
    """
    unknown = math.nan, math.nan
    names = {"crack_arrest_length": "arrest_length", "crack_life": "life"}
    if not path.exists():
        return dict.fromkeys(names, unknown)
    with opened_beside(path, "crack", result) as file:
        (body,) = crack_bodies(file).values()
    return {
        name: (body.values[key], body.values[f"{key}_error"]) if key in body.values else unknown
        for name, key in names.items()
    }


def _read_body(path: Path, group: Any, known: Mapping[str, Any]) -> BodyCrack:
    columns = read_columns(group, known["columns"])
    tables = {name: _read_table(group, name) for name in known["tables"]}
    for name, digest in digests_of(tables).items():
        require(digest == known["tables"][name], name, "what the header says, it was changed")
    steps, lengths = columns.pop("step"), columns.pop("length")
    cycles = columns.pop("cycle", np.zeros(0, np.int64))
    for name, table in tables.items():
        right = len(cycles) if name == "cycle_range" else len(steps), len(lengths)
        require(table.shape == right, name, "the shape of its axes")
    for name, column in columns.items():
        require(column.shape == lengths.shape, name, "a number per length")
    values = {str(name): float(value) for name, value in known["values"].items()}
    place = float(known["x"]), float(known["y"])
    return BodyCrack(path, *place, steps, lengths, cycles, {**tables, **columns}, known["verdict"], values)


def _read_table(group: Any, name: str) -> NDArray[np.float64]:
    dataset = own_dataset(group, name)
    require(dataset.ndim == 2 and dataset.dtype == np.float64, name, "numbers over two axes")
    return np.asarray(dataset[()])
