"""The table of a sweep as a file: CSV, HDF5 or Parquet."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretsolve import __version__
from fretsolve.errors import CaseError
from fretsolve.sweep.table import Column, Table
from fretsolve.system import atomic_files


def write_csv(path: Path, table: Table) -> None:
    """A row per case, units in the heading; empty cells for what is not known. Raises FileError."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = list(_columns(table))
    writer.writerow([column.heading for column in columns])
    writer.writerows(zip(*(map(_cell, column.values.tolist()) for column in columns), strict=True))
    with atomic_files.reported(path):
        atomic_files.write_text(path, text.getvalue())


def write_hdf5(path: Path, table: Table, *, fields: bool) -> None:
    """A dataset per column in the groups case, settings, values and errors, with units and meaning.

    fields: link each result as ``results/ID``, relative to this file. Raises FileError.
    """
    manifest = table.manifest
    with atomic_files.reported(path), atomic_files.new_hdf5(path, path.parent) as file:
        file.attrs["fretsolve_version"] = __version__
        file.attrs["title"] = manifest.title
        file.attrs["case"] = str(manifest.case)
        for group, columns in (
            ("case", _about(table)),
            ("settings", table.settings),
            ("values", table.found),
            ("errors", table.errors),
        ):
            for column in columns:
                _put(file, f"{group}/{column.name}", column)
        for row in manifest.unique if fields else ():
            if manifest.result(row).exists():
                target = os.path.relpath(manifest.result(row), path.absolute().parent)
                file[f"results/{row.id}"] = h5py.ExternalLink(target, "/")


def write_parquet(path: Path, table: Table) -> None:
    """As the CSV file, with types; needs pyarrow. Raises CaseError without it, FileError."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise CaseError(f"Parquet needs pyarrow, which cannot be imported ({error}): pip install pyarrow") from error
    columns = {column.heading: pyarrow.array(column.values.tolist()) for column in _columns(table)}
    content = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(columns), content)
    with atomic_files.reported(path), atomic_files.new_file(path, path.parent) as file:
        file.write(content.getvalue())


def writer_of(path: Path, *, fields: bool) -> Callable[[Table], None]:
    """What writes a file of the name `path`. Raises CaseError where its ending is of no known format."""
    ending = path.suffix.lower()
    if ending in (".h5", ".hdf5"):
        return lambda table: write_hdf5(path, table, fields=fields)
    if fields:
        raise CaseError("--fields links results, which only HDF5 can; a name that ends on .h5 is needed", (), path)
    if ending == ".csv":
        return lambda table: write_csv(path, table)
    if ending == ".parquet":
        return lambda table: write_parquet(path, table)
    raise CaseError("no known format; a name that ends on .csv, .h5 or .parquet is needed", (), path)


def _about(table: Table) -> Iterator[Column]:
    """What every sweep tells of its cases."""
    found = table.states
    yield Column("index", "", np.array([state.row.index for state in found]))
    yield Column("id", "", np.array([state.row.id for state in found], object))
    yield Column("status", "", np.array([state.status for state in found], object))
    yield Column("regime", "", np.array(table.regimes, object))
    yield Column("increments", "", table.increments)
    yield Column("time", "s", table.seconds)
    yield Column("reason", "", np.array([state.reason for state in found], object))


def _columns(table: Table) -> Iterator[Column]:
    first, second, third, *rest = _about(table)
    yield from (first, second, third, *table.settings, *table.found, *table.errors, *rest)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.10g}" if np.isfinite(value) else ""
    return str(value)


def _put(file: Any, name: str, column: Column) -> None:
    kind = h5py.string_dtype() if column.values.dtype == object else None
    dataset = file.create_dataset(name, data=column.values, dtype=kind)
    dataset.attrs["units"], dataset.attrs["long_name"] = column.units, column.name
