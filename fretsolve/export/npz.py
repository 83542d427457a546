"""All of a result as an ``.npz`` of NumPy: history, axes, fields, units and case."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.system import atomic_files

if TYPE_CHECKING:
    from fretsolve.result import Result

COMPRESSION_LEVEL = 1
"""Most of a field is zeros outside of the contact, which any level shrinks."""


def write_npz(result: Result, steps: Sequence[int], path: Path) -> None:
    """Write the history by the names of its columns, the fields of `steps`, ``(steps, nx, ny)``, by theirs.

    Beside them: `x`, `y` (mm), `field_steps`, and as text `units` (JSON of each name's), `effective_case` (JSON) and
    `case_yaml`. Holds one increment of one field at a time. Raises OSError, FileError.
    """
    names = [*result.history, *result.fields, "x", "y"]
    texts = {
        "units": json.dumps({name: result.units(name) for name in names}),
        "effective_case": str(result.attributes["effective_case"]),
        "case_yaml": result.case_yaml,
    }
    arrays: dict[str, NDArray[Any]] = dict(result.history) | {"x": result.x, "y": result.y}
    arrays |= {"field_steps": np.array(steps, np.int64)} | {name: np.array(text) for name, text in texts.items()}
    with (
        atomic_files.new_file(path, durable=False) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=COMPRESSION_LEVEL) as archive,
    ):
        for name, values in arrays.items():
            _write_member(archive, name, values.shape, values.dtype, [values])
        for name in result.fields:
            planes = (result.field(name, step) for step in steps)
            dtype = result.field_type(name)
            shape = (len(steps), len(result.x), len(result.y))
            _write_member(archive, name, shape, dtype, planes)


def _write_member(
    archive: zipfile.ZipFile, name: str, shape: tuple[int, ...], dtype: np.dtype[Any], parts: Iterable[NDArray[Any]]
) -> None:
    """One array as NumPy's format has it, from parts that follow one another in memory."""
    header = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
        np.lib.format.write_array_header_2_0(member, header)
        for part in parts:
            member.write(np.ascontiguousarray(part, dtype).data)
