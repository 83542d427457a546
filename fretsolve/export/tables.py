"""Write the history as CSV, and all of a result as an ``.npz`` of NumPy."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.result import Result
from fretsolve.system import atomic_files


def write_history_csv(result: Result, path: Path, *, exclusive: bool) -> None:
    """Write the history: a row per increment, units in the header, every digit of every number. Raises OSError."""
    units = {name: result.units(name) for name in result.history}
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(csv_heading(units))
    writer.writerows(zip(*(column.tolist() for column in result.history.values()), strict=True))
    atomic_files.write_text(path, text.getvalue(), exclusive=exclusive)


def csv_heading(units: Mapping[str, str]) -> list[str]:
    """Return names with their units, such as ``P (N)``, as the first row of a table."""
    return [name if unit == "1" else f"{name} ({unit})" for name, unit in units.items()]


def write_npz(result: Result, steps: Sequence[int], path: Path, *, exclusive: bool) -> None:
    """Write the columns of the history and the fields of `steps`, ``(steps, nx, ny)``, by their names.

    Further arrays are `x`, `y` (mm), `field_steps`, and as text `units` (JSON: that of each name), `effective_case`
    (JSON) and `case_yaml`. Holds one increment of one field at a time. Raises OSError, FileError.
    """
    names = [*result.history, *result.fields, "x", "y"]
    arrays: dict[str, NDArray[Any]] = {
        **result.history,
        "x": result.x,
        "y": result.y,
        "field_steps": np.array(steps, np.int64),
        "units": np.array(json.dumps({name: result.units(name) for name in names})),
        "effective_case": np.array(str(result.attributes["effective_case"])),
        "case_yaml": np.array(result.case_yaml),
    }
    with (
        atomic_files.new_file(path, durable=False, exclusive=exclusive) as file,
        # most of a field is zeros outside the contact, which the fastest level shrinks as well
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, values in arrays.items():
            _write_array(archive, name, values.shape, values.dtype, [values])
        shape = len(steps), len(result.x), len(result.y)
        for name in result.fields:
            planes = (result.field(name, step) for step in steps)
            _write_array(archive, name, shape, result.field_type(name), planes)


def _write_array(
    archive: zipfile.ZipFile, name: str, shape: tuple[int, ...], dtype: np.dtype[Any], parts: Iterable[NDArray[Any]]
) -> None:
    """Write one array in NumPy's format, from parts that follow one another in memory."""
    header = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
        np.lib.format.write_array_header_2_0(member, header)
        for part in parts:
            member.write(np.ascontiguousarray(part, dtype).data)
