"""Write worn surfaces as height maps, with which another case goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fretsolve.errors import CaseError
from fretsolve.model.surface import separation
from fretsolve.result import Result
from fretsolve.system import atomic_files


def require_wear(result: Result, step: int) -> None:
    """Raise CaseError unless the worn depth at an increment is stored."""
    if "wear" not in result.effective_case:
        raise CaseError("nothing is worn, since the case has no wear", (), result.path)
    if "wear_depth" not in result.fields or step not in result.steps:
        message = "the worn depth is not stored; wear_depth in output.fields of the case file stores it"
        raise CaseError(message, (), result.path)


def write_heights(result: Result, step: int, path: Path, *, exclusive: bool) -> None:
    """Write the worn depth and the worn separation after an increment as maps in mm, with spacing and middle.

    `wear_depth` is that of both bodies together, which adds to the surfaces of the case; `separation` is the sum, NaN
    without material. Raises OSError, FileError, CaseError.
    """
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
