"""Tables as files: CSV, HDF5 and Parquet; and the results of a sweep as one table, with settings and error bars."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from fretsolve import __version__
from fretsolve.case.dimensions import DIMENSIONS
from fretsolve.case.quantities import QuantityError, split_quantity, to_internal
from fretsolve.errors import CaseError, FileError
from fretsolve.result.cycles.table import CYCLE_NAMES
from fretsolve.result.layout import described
from fretsolve.sweep.manifest import CaseState, Manifest, ManifestRow, states
from fretsolve.sweep.outcome import CaseOutcome, read_outcome
from fretsolve.sweep.quantity import LAST_STAGE, plain, read_quantity
from fretsolve.system import atomic_files
from fretsolve.system.files import require_regular, writing
from fretsolve.system.hdf5_files import open_hdf5

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of a text that a spreadsheet takes for a formula."""

_FIRST_COLUMNS = b"index,id,status,", b"seeds,"
"""Beginnings of a sweep's table as CSV, and of the means over its seeds."""

NOT_OWN = "is not {}, so it is not replaced: move it away, or give another {} with -o"


def _is_quantity(text: str) -> bool:
    """Return whether a text is a number, alone or with a unit that there is."""
    for dimension in DIMENSIONS:
        with suppress(QuantityError):
            unit = split_quantity(text)[1]
            if unit:
                to_internal(unit, dimension, bare_unit=True)
            return True
    return False


@dataclass(frozen=True, eq=False)
class Column:
    """Values ``(rows,)`` under a name: texts, or numbers (NaN if there is none) in `units`.

    meaning: for HDF5, the name by default; attributes: more of them there.
    """

    name: str
    units: str
    values: NDArray[Any]
    meaning: str = ""
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def heading(self) -> str:
        """The name with the units, as in CSV."""
        return self.name if self.units in ("", "1") else f"{self.name} ({self.units})"


def column(name: str, values: ArrayLike, units: str = "", meaning: str = "", **attributes: Any) -> Column:
    """Return a column; texts become objects, as HDF5 and CSV need them."""
    array = np.asarray(values)
    return Column(name, units, array.astype(object) if array.dtype.kind == "U" else array, meaning, attributes)


def write_table_csv(
    path: Path, columns: Iterable[Column], first: Sequence[Any] = (), *, exclusive: bool = False
) -> None:
    """Write a row per case, units in the heading; what is not known is empty, a bar or a life without a bound is inf.

    first: one more row; exclusive: replace no file. Raises FileError.
    """

    def cell(value: Any) -> str:
        if isinstance(value, float):
            return f"{value:.10g}" if not np.isnan(value) else ""
        text = str(value)
        # A spreadsheet takes such a text for a formula. In tables, "-36 N" is a value of a setting.
        return f"'{text}" if text.startswith(FORMULA) and not _is_quantity(text) else text

    columns = list(columns)
    rows = zip(*(column.values.tolist() for column in columns), strict=True)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([cell(column.heading) for column in columns])
    writer.writerows(map(cell, row) for row in ([first, *rows] if first else rows))
    with writing(path):
        atomic_files.write_text(path, text.getvalue(), exclusive=exclusive)


def write_table_hdf5(
    path: Path,
    columns: Mapping[str, Iterable[Column]],
    attributes: Mapping[str, Any],
    links: Mapping[str, Any] = {},
    *,
    exclusive: bool = False,
) -> None:
    """Write each column as a dataset in its group, with units and meaning. Raises FileError.

    columns: by group, empty for none; links: by their names in the file; exclusive: replace no file.
    """
    with writing(path), atomic_files.new_hdf5(path, exclusive=exclusive) as file:
        file.attrs.update({"fretsolve_version": __version__, **attributes})
        for group, members in columns.items():
            for one in members:
                values = one.values.astype(np.uint8) if one.values.dtype == bool else one.values
                kind = h5py.string_dtype() if values.dtype == object else None
                dataset = file.create_dataset(f"{group}/{one.name}" if group else one.name, data=values, dtype=kind)
                dataset.attrs.update({**described(one.units, one.meaning or one.name), **one.attributes})
        for name, link in links.items():
            file[name] = link


def write_table_parquet(path: Path, columns: Iterable[Column], *, exclusive: bool = False) -> None:
    """Write the columns of the CSV file, with types. Raises CaseError without pyarrow, FileError."""
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise CaseError(f"Parquet needs pyarrow, which cannot be imported ({error}): pip install pyarrow") from error
    content = io.BytesIO()
    arrays = {column.heading: pyarrow.array(column.values.tolist()) for column in columns}
    pyarrow.parquet.write_table(pyarrow.table(arrays), content)
    with writing(path), atomic_files.new_file(path, exclusive=exclusive) as file:
        file.write(content.getvalue())


@dataclass(frozen=True, eq=False)
class Table:
    """One row per case. settings, found, errors: columns of varied keys, quantities and their error bars, if any."""

    manifest: Manifest
    states: tuple[CaseState, ...]
    outcomes: tuple[CaseOutcome, ...]
    settings: tuple[Column, ...]
    found: tuple[Column, ...]
    errors: tuple[Column, ...]


def collect(manifest: Manifest, quantities: Sequence[str] = ()) -> Table:
    """Return the table of what there is by now; quantities: ``NAME`` or ``NAME@STAGE``, by default the manifest's.

    A result that cannot be read counts as an error of its case. Raises CaseError for a stage that no case has.
    """
    wanted = {plain(text): read_quantity(text) for text in quantities or manifest.quantities}
    nothing = np.full(len(wanted), np.nan)
    known: dict[str, CaseOutcome] = {}
    found: list[CaseState] = []
    outcomes: list[CaseOutcome] = []
    for state in states(manifest):
        if state.has_result and state.row.id not in known:
            try:
                known[state.row.id] = read_outcome(manifest.result(state.row), list(wanted.values()))
            except FileError as error:
                state = CaseState(state.row, "error", error.exit_code, str(error))
        found.append(state)
        outcomes.append(known.get(state.row.id) or CaseOutcome(nothing, nothing, state.increments))
    stages = max((outcome.stages for outcome in outcomes), default=0)
    for one in wanted.values():
        if one.name not in CYCLE_NAMES and stages and stages < one.stage < LAST_STAGE:
            raise CaseError(f"--quantity {one}: there is no stage {one.stage}; the cases have stages 1 to {stages}")
    values, errors = (np.array(rows) for rows in zip(*((one.values, one.errors) for one in outcomes), strict=True))
    units = {one.name: one.units for one in wanted.values()}
    units |= next((outcome.units for outcome in outcomes if outcome.units), {})
    bars = [Column(f"{text} error", units[one.name], errors[:, i]) for i, (text, one) in enumerate(wanted.items())]
    return Table(
        manifest,
        tuple(found),
        tuple(outcomes),
        tuple(setting_column(key, [state.row for state in found]) for key in manifest.keys),
        tuple(Column(text, units[one.name], values[:, i]) for i, (text, one) in enumerate(wanted.items())),
        tuple(one for one in bars if not np.isnan(one.values).all()),
    )


def setting_column(key: str, rows: Sequence[ManifestRow]) -> Column:
    """Return the values of a key: numbers if all are numbers in one unit, else texts, empty for none."""
    texts = [row.settings.get(key, "") for row in rows]
    with suppress(QuantityError):
        numbers, units = zip(*map(split_quantity, texts), strict=True)
        if len(set(units)) == 1:
            return column(key, numbers, units[0])
    return column(key, texts)


def writer_of(path: Path, *, fields: bool, exclusive: bool) -> Callable[[Table], None]:
    """Return what writes a table as the file `path`: a function that may raise CaseError or FileError.

    fields: link each result in HDF5 as ``results/ID``; exclusive: replace no file. Raises CaseError if the ending of
    the name is not known.
    """
    ending = path.suffix.lower()
    if ending in (".h5", ".hdf5"):
        return lambda table: _write_sweep_hdf5(path, table, fields=fields, exclusive=exclusive)
    if fields:
        raise CaseError("--fields links results, which only HDF5 can; a name ending in .h5 is needed", (), path)
    if ending == ".csv":
        return lambda table: write_table_csv(path, _columns(table), exclusive=exclusive)
    if ending == ".parquet":
        return lambda table: write_table_parquet(path, _columns(table), exclusive=exclusive)
    raise CaseError("the format is not known; a name ending in .csv, .h5 or .parquet is needed", (), path)


def require_tables(paths: Iterable[Path]) -> None:
    """Raise FileError if one of `paths`, tables of a sweep, exists and is none."""
    for path in paths:
        if path.suffix != ".csv":
            require_own_hdf5(path, ("case/index", "case/id", "case/status"), "the table of a sweep", "name")
        elif os.path.lexists(path):
            own = False
            with suppress(OSError, FileError):
                require_regular(path)
                with path.open("rb") as file:
                    own = file.read(20).startswith(_FIRST_COLUMNS)
            if not own:
                raise FileError(NOT_OWN.format("the table of a sweep", "name"), path)


def require_own_hdf5(path: Path, names: Iterable[str], what: str, other: str) -> None:
    """Raise FileError if a file is there without the members `names` that `what` has; other: what to give instead."""
    own = not os.path.lexists(path)
    with suppress(OSError, FileError):
        if not own:
            with open_hdf5(path) as file:
                own = all(name in file for name in names)
    if not own:
        raise FileError(NOT_OWN.format(what, other), path)


def _write_sweep_hdf5(path: Path, table: Table, *, fields: bool, exclusive: bool) -> None:
    manifest, links = table.manifest, dict[str, Any]()
    for row in manifest.unique if fields else ():
        if manifest.result(row).exists():
            target = os.path.relpath(manifest.result(row), path.absolute().parent)
            links[f"results/{row.id}"] = h5py.ExternalLink(target, "/")
    groups = {"case": _about(table), "settings": table.settings, "values": table.found, "errors": table.errors}
    write_table_hdf5(path, groups, {"title": manifest.title, "case": str(manifest.case)}, links, exclusive=exclusive)


def _about(table: Table) -> Iterator[Column]:
    yield column("index", [state.row.index for state in table.states])
    yield column("id", [state.row.id for state in table.states])
    yield column("status", [state.status for state in table.states])
    yield column("running_condition", [outcome.running_condition for outcome in table.outcomes])
    yield column("increments", [outcome.increments for outcome in table.outcomes])
    yield column("time", [outcome.seconds for outcome in table.outcomes], "s")
    yield column("reason", [state.reason for state in table.states])


def _columns(table: Table) -> Iterator[Column]:
    first, second, third, *rest = _about(table)
    yield from (first, second, third, *table.settings, *table.found, *table.errors, *rest)
