"""Write a result as tables and arrays: the history as CSV, everything as an ``.npz``, worn surfaces as height maps."""

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

from fretsolve.errors import CaseError
from fretsolve.result import Result
from fretsolve.system import atomic_files


def write_history_csv(result: Result, path: Path, *, exclusive: bool) -> None:
    """Write the history: a row per increment, units in the header, every digit of every number. Raises OSError."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(csv_heading({name: result.units(name) for name in result.history}))
    writer.writerows(zip(*(column.tolist() for column in result.history.values()), strict=True))
    atomic_files.write_text(path, text.getvalue(), exclusive=exclusive)


def csv_heading(units: Mapping[str, str]) -> list[str]:
    """Return names with their units, such as ``P (N)``, as the first row of a table."""
    return [name if unit == "1" else f"{name} ({unit})" for name, unit in units.items()]


def write_npz(result: Result, steps: Sequence[int], path: Path, *, exclusive: bool) -> None:
    """Write the columns of the history and the fields of `steps`, ``(steps, nx, ny)``, by their names.

    Further arrays are `x`, `y` (mm), `field_steps`, and as text `units` (JSON: a unit per name), `effective_case`
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


def require_wear(result: Result, step: int) -> None:
    """Raise CaseError unless the worn depth at an increment is stored."""
    if "wear" not in result.effective_case:
        raise CaseError("nothing is worn, since the case has no wear", (), result.path)
    if "wear_depth" not in result.fields or step not in result.steps:
        message = "the worn depth is not stored; wear_depth in output.fields of the case file stores it"
        raise CaseError(message, (), result.path)


def write_heights(result: Result, step: int, path: Path, *, exclusive: bool) -> None:
    """Write the worn depth and the worn separation after an increment as maps in mm, with spacing and middle.

    `wear_depth` is the worn depth of both bodies together, which adds to the surfaces of the case; `separation` is the
    sum, NaN without material. Raises OSError, FileError, CaseError.
    """
    from fretsolve.problem.surface.separation import separation  # loads pydantic, which no other table needs

    depth = np.asarray(result.field("wear_depth", step), np.float64)
    maps = {"wear_depth": (depth, "worn depth of both bodies together, which adds to the separation")}
    if result.case is not None:
        worn = separation(result.case.surface, result.x, result.y) + depth
        worn[~np.isfinite(worn)] = np.nan
        maps["separation"] = (worn, "separation of the worn surfaces where they do not touch")
    spacing = [float(np.diff(axis).mean()) for axis in (result.x, result.y) if len(axis) > 1]
    middle = [0.5 * float(axis[0] + axis[-1]) for axis in (result.x, result.y)]
    with atomic_files.new_hdf5(path, exclusive=exclusive) as file:
        for name, (values, meaning) in maps.items():
            dataset = file.create_dataset(name, data=values, compression="gzip", shuffle=True)
            dataset.attrs.update({"units": "mm", "spacing": spacing, "center": middle, "long_name": meaning})
