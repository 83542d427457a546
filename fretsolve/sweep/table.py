"""The results of a sweep as one table: settings, quantities at the ends of stages, and their error bars."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import h5py
import numpy as np
from numpy.typing import NDArray

from fretsolve.case.quantities import QuantityError, split_quantity
from fretsolve.errors import CaseError, FileError, SlidingError
from fretsolve.result import Result, open_result
from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.sweep.manifest import Manifest, ManifestRow
from fretsolve.sweep.quantity import StageQuantity
from fretsolve.sweep.status import CaseState, states
from fretsolve.sweep.table_files import Column, column, write_csv, write_hdf5, write_parquet
from fretsolve.system.arrays import DoubleArray

RunningCondition = Literal["", "stick", "partial slip", "gross slip"]


@dataclass(frozen=True, eq=False)
class Table:
    """One row per case. settings, found, errors: columns of varied keys, quantities and their error bars, if any.

    running_conditions: of each case, empty if it has none; increments, seconds: solved, and the time they took.
    """

    manifest: Manifest
    states: tuple[CaseState, ...]
    settings: tuple[Column, ...]
    found: tuple[Column, ...]
    errors: tuple[Column, ...]
    running_conditions: tuple[str, ...]
    increments: NDArray[np.int64]
    seconds: DoubleArray


@dataclass(frozen=True)
class _Reading:
    """What one result says. stages: of the whole path, 0 if the run did not reach its end."""

    values: tuple[float, ...]
    errors: tuple[float, ...]
    running_condition: str = ""
    increments: int = 0
    seconds: float = 0.0
    stages: int = 0


def collect(manifest: Manifest, quantities: Sequence[str] = ()) -> Table:
    """Return the table of what there is by now; quantities: ``NAME`` or ``NAME@STAGE``, by default the manifest's.

    A result that cannot be read counts as an error of its case. Raises CaseError for a stage that no case has.
    """
    texts = tuple(dict.fromkeys(quantities or manifest.quantities))
    wanted = [_split(text) for text in texts]
    nothing = (math.nan,) * len(wanted)
    known: dict[str, _Reading] = {}
    found: list[CaseState] = []
    readings: list[_Reading] = []
    for state in states(manifest):
        if state.has_result and state.row.id not in known:
            try:
                with open_result(manifest.result(state.row)) as result:
                    known[state.row.id] = _read(result, wanted)
            except FileError as error:
                state = CaseState(state.row, "error", error.exit_code, str(error))
        found.append(state)
        readings.append(known.get(state.row.id) or _Reading(nothing, nothing, increments=state.increments))
    stages = max((reading.stages for reading in readings), default=0)
    for text, (_, stage) in zip(texts, wanted, strict=True):
        if stages and stage is not None and stage > stages:
            raise CaseError(f"--quantity {text}: there is no stage {stage}; the cases have stages 1 to {stages}")
    shape = len(found), len(texts)
    values = np.array([reading.values for reading in readings], np.float64).reshape(shape)
    errors = np.array([reading.errors for reading in readings], np.float64).reshape(shape)
    heads = [(text, StageQuantity(name, 1).units) for text, (name, _) in zip(texts, wanted, strict=True)]
    return Table(
        manifest,
        tuple(found),
        tuple(setting_column(key, [state.row for state in found]) for key in manifest.keys),
        tuple(Column(text, unit, values[:, i]) for i, (text, unit) in enumerate(heads)),
        tuple(
            Column(f"{text} error", unit, errors[:, i])
            for i, (text, unit) in enumerate(heads)
            if np.isfinite(errors[:, i]).any()
        ),
        tuple(reading.running_condition for reading in readings),
        np.array([reading.increments for reading in readings]),
        np.array([reading.seconds for reading in readings]),
    )


def running_condition(result: Result) -> RunningCondition:
    """Return whether all of the contact slips at some time, a part of it does, or none; empty without shear.

    A run that ended because a force exceeded what friction carries is one of gross slip.
    """
    history = result.history
    if result.attributes.get("failure_kind") == SlidingError.kind:
        return "gross slip"
    if not result.increments or not history["max_shear"].any():
        return ""
    touching, sticking = history["contact_cells"], history["stick_cells"]
    if ((sticking == 0) & (touching > 0) & (history["max_shear"] > 0.0)).any():
        return "gross slip"
    return "partial slip" if (sticking < touching).any() else "stick"


def setting_column(key: str, rows: Sequence[ManifestRow]) -> Column:
    """Return the values of a key: numbers if all are numbers in the same unit, else texts, empty for none."""
    texts = [next((setting.value for setting in row.settings if setting.key == key), "") for row in rows]
    try:
        numbers, units = zip(*map(split_quantity, texts), strict=True)
    except QuantityError:
        return column(key, texts)
    return column(key, numbers, units[0]) if len(set(units)) == 1 else column(key, texts)


def writer_of(path: Path, *, fields: bool) -> Callable[[Table], None]:
    """Return what writes a table as the file `path`: a function that may raise CaseError or FileError.

    fields: link each result in HDF5 as ``results/ID``. Raises CaseError if the ending of the name is not known.
    """
    ending = path.suffix.lower()
    if ending in (".h5", ".hdf5"):
        return lambda table: _write_hdf5(path, table, fields=fields)
    if fields:
        raise CaseError("--fields links results, which only HDF5 can; a name ending in .h5 is needed", (), path)
    if ending == ".csv":
        return lambda table: write_csv(path, _columns(table))
    if ending == ".parquet":
        return lambda table: write_parquet(path, _columns(table))
    raise CaseError("the format is not known; a name ending in .csv, .h5 or .parquet is needed", (), path)


def _write_hdf5(path: Path, table: Table, *, fields: bool) -> None:
    manifest, links = table.manifest, {"case/regime": h5py.SoftLink("/case/running_condition")}  # its name before
    for row in manifest.unique if fields else ():
        if manifest.result(row).exists():
            target = os.path.relpath(manifest.result(row), path.absolute().parent)
            links[f"results/{row.id}"] = h5py.ExternalLink(target, "/")
    groups = {"case": _about(table), "settings": table.settings, "values": table.found, "errors": table.errors}
    write_hdf5(path, groups, {"title": manifest.title, "case": str(manifest.case)}, links)


def _about(table: Table) -> Iterator[Column]:
    """Yield the columns that every sweep has."""
    yield column("index", [state.row.index for state in table.states])
    yield column("id", [state.row.id for state in table.states])
    yield column("status", [state.status for state in table.states])
    yield column("running_condition", table.running_conditions)
    yield column("increments", table.increments)
    yield column("time", table.seconds, "s")
    yield column("reason", [state.reason for state in table.states])


def _columns(table: Table) -> Iterator[Column]:
    first, second, third, *rest = _about(table)
    yield from (first, second, third, *table.settings, *table.found, *table.errors, *rest)


def _read(result: Result, wanted: Sequence[tuple[str, int | None]]) -> _Reading:
    return _Reading(
        tuple(_at_end(result, name, stage) for name, stage in wanted),
        tuple(_at_end(result, name + ERROR_SUFFIX, stage) for name, stage in wanted),
        running_condition(result),
        result.increments,
        float(result.history["wall_time"].sum()),
        int(result.history["stage"][-1]) if result.status == "complete" else 0,
    )


def _split(text: str) -> tuple[str, int | None]:
    name, _, stage = (part.strip() for part in text.partition("@"))
    return name, int(stage) if stage else None


def _at_end(result: Result, name: str, stage: int | None) -> float:
    """Return a column of the history at the end of a stage (None: the last); NaN if the run did not reach it."""
    stages = result.history["stage"]
    complete = result.status == "complete"
    if name not in result.history or not len(stages):
        return math.nan
    if stage is None:
        return float(result.history[name][-1]) if complete else math.nan
    steps = np.flatnonzero(stages == stage)
    if not len(steps) or (steps[-1] == len(stages) - 1 and not complete):
        return math.nan
    return float(result.history[name][steps[-1]])
