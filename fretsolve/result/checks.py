"""Refuse what cannot be the history, the grid or a field of a result, whatever has happened to its file.

All functions raise ValueError or KeyError, which `damage_reported` turns into a message.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.history import EXTENTS
from fretsolve.result.layout import ERRORS, HISTORY, QUANTITIES, STEP, Quantity, optional_among
from fretsolve.result.state import ZONE_NAMES
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.foreign_files import own_dataset

_MAY_BE_UNKNOWN = frozenset((*(quantity.name for quantity in ERRORS), *EXTENTS))
"""Columns in which NaN stands for what is not known or does not exist."""

MOST_SMALL_BYTES, MOST_STEP_BYTES, USUAL_RATIO = 2**28, 2**24, 32
"""Bytes of the history or an axis, and of the increments of fields, that a small file may hold; and bytes of numbers
for a stored byte, beyond that. Histories of runs compress to a third."""

UNKNOWN_OF_A_LINE = ("delta_z", "delta_x", "delta_y")
"""Columns that a line contact leaves unknown throughout."""


def require(holds: object, name: str, what: str) -> None:
    """Raise ValueError unless `holds`; name: of the dataset; what: it must hold that."""
    if not holds:
        raise ValueError(f"{name} must hold {what}")


def require_modest(datasets: Mapping[str, Any], most: int = MOST_SMALL_BYTES) -> None:
    """Raise ValueError if `datasets` together take more than `most` bytes, of which the file has but a small part."""
    size = sum(dataset.nbytes for dataset in datasets.values())
    shapes = {dataset.shape for dataset in datasets.values()} if "step" in datasets else set()
    require(len(shapes) < 2, "the history", "as many numbers in each column")
    if size > max(most, USUAL_RATIO * sum(dataset.id.get_storage_size() for dataset in datasets.values())):
        raise ValueError(f"{', '.join([*datasets][:2])} would take {size} bytes, far more than there are in the file")


def checked_plane(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """Return a field of one increment. Raises ValueError if its values cannot be those of the field."""
    kinds = ("uint8",) if name == "zone" else ("float32", "float64")
    require(values.ndim == 2 and values.size and values.dtype in kinds, name, "a number per cell")
    if name == "zone":
        require(values.max() < len(ZONE_NAMES), name, "zones")
    elif name == "gap":
        require((values > -np.inf).all(), name, "numbers, infinite only off a body")  # False for NaN
    else:
        require(np.isfinite(values).all(), name, "finite numbers")
    return values


def read_column(dataset: Any) -> NDArray[Any]:
    """Return a column of numbers. Raises ValueError if it is none."""
    name = getattr(dataset, "name", "a column")
    require(dataset.ndim == 1 and dataset.dtype.kind in "iuf", name, "numbers, one per increment")
    return np.asarray(dataset[:])


def row_type(errors: bool, optional: Sequence[Quantity]) -> np.dtype[Any]:
    """Return the type of a record of the history, the step first, error bars and corrected values last.

    errors: whether there are any; optional: the columns that not every result has.
    """
    quantities = (STEP, *HISTORY, *optional, *(ERRORS if errors else ()))
    return np.dtype([(quantity.name, quantity.dtype) for quantity in quantities])


def row_records(columns: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
    """Return columns as a record per increment.

    Raises KeyError or ValueError if one is missing, too short, or has no number where there must be one.
    """
    rows = np.empty(columns["step"].shape, row_type(ERRORS[0].name in columns, optional_among(columns.keys())))
    for name in rows.dtype.names or ():
        column = columns[name]
        whole = rows.dtype[name].kind == "i"
        require(column.shape == rows.shape, name, f"{len(rows)} numbers, one per increment")
        require(column.dtype.kind in ("iu" if whole else "iuf"), name, "whole numbers" if whole else "numbers")
        rows[name] = column
        unknown = name in UNKNOWN_OF_A_LINE and np.isnan(rows[name]).all()
        if name not in _MAY_BE_UNKNOWN and not unknown:
            require(np.isfinite(rows[name]).all(), name, "finite numbers, NaN is damage")
    first = rows["step"][0] if len(rows) else 0
    require((rows["step"] == first + np.arange(len(rows))).all(), "step", "numbers that follow each other")
    return rows


def content_of(
    rows: NDArray[Any], x: DoubleArray, y: DoubleArray, steps: Sequence[int], names: Sequence[str]
) -> dict[str, Any]:
    """Return 16 digits of the SHA-256 of each column and axis of a result, and the names of its fields."""
    arrays = {name: rows[name] for name in rows.dtype.names or ()}
    arrays |= {"x": x, "y": y, "step of fields": np.array(steps, STEP.dtype)}
    return {"columns": digests_of(arrays), "fields": list(names)}


def digests_of(columns: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    """Return 16 digits of the SHA-256 of each column."""
    return {name: hashlib.sha256(column.tobytes()).hexdigest()[:16] for name, column in columns.items()}


def read_columns(group: Any, digests: Mapping[str, str]) -> dict[str, NDArray[Any]]:
    """Return the columns of an HDF5 group. Raises ValueError or KeyError unless they have these `digests_of`."""
    datasets = {name: own_dataset(group, name) for name in digests}
    for dataset in datasets.values():
        require_modest({"column": dataset})
    columns = {name: read_column(dataset) for name, dataset in datasets.items()}
    for name, digest in digests_of(columns).items():
        require(digest == digests[name], name, "what the header says, it was changed")
    return columns


def changed_content(stored: Mapping[str, Any], found: Mapping[str, Any]) -> list[str]:
    """Return the names of what differs between two of `content_of`. A newer version may have more columns."""
    columns = [name for name, digest in found["columns"].items() if stored["columns"].get(name) != digest]
    return columns + sorted({name for name in stored["fields"] if name in QUANTITIES} ^ set(found["fields"]))
