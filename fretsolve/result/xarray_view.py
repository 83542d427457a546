"""Datasets of xarray whose fields are read when their values are asked for (extra ``xarray``)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from fretsolve.result.layout import ERRORS, FIELDS, HISTORY, STEP, ZONE_ATTRIBUTES, Quantity, X, Y
from fretsolve.system.arrays import DoubleArray

_BY_NAME: dict[str, Quantity] = {quantity.name: quantity for quantity in (STEP, *HISTORY, *ERRORS, X, Y, *FIELDS)}

Read = Callable[[str, int], NDArray[Any]]
"""Return a field, by its name and its increment, ``(nx, ny)``."""


class StoredField(BackendArray):
    """A field of all stored increments, ``(steps, nx, ny)``, read one increment after another."""

    def __init__(self, read: Read, name: str, steps: Sequence[int], shape: tuple[int, int], dtype: np.dtype[Any]):
        self._read_plane, self._name, self._steps = read, name, steps
        self.shape = (len(steps), *shape)
        self.dtype = dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        which, rows, columns = key
        steps = np.asarray(self._steps)[which]
        if steps.ndim == 0:
            return self._plane(int(steps), rows, columns)
        planes = [self._plane(int(step), rows, columns) for step in steps]
        empty = np.empty(self.shape[1:], self.dtype)[rows][..., columns]
        return np.stack(planes) if planes else np.empty((0, *empty.shape), self.dtype)

    def _plane(self, step: int, rows: Any, columns: Any) -> NDArray[Any]:
        return np.asarray(self._read_plane(self._name, step)[rows][..., columns])


def history_dataset(history: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]) -> xarray.Dataset:
    """Return the columns of a history over `step`."""
    columns = {name: ("step", column, _meaning(name)) for name, column in history.items()}
    return xarray.Dataset(columns, attrs=attributes)


def fields_dataset(
    read: Read,
    types: Mapping[str, np.dtype[Any]],
    steps: Sequence[int],
    x: DoubleArray,
    y: DoubleArray,
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """Return the fields, whose names and types are `types`, over `step`, `x` and `y`."""
    axes = {"step": np.asarray(steps, STEP.dtype), "x": x, "y": y}
    shape = len(x), len(y)
    fields = {name: StoredField(read, name, steps, shape, dtype) for name, dtype in types.items()}
    return xarray.Dataset(
        {name: (tuple(axes), indexing.LazilyIndexedArray(field), _meaning(name)) for name, field in fields.items()},
        {name: (name, values, _meaning(name)) for name, values in axes.items()},
        attributes,
    )


def _meaning(name: str) -> dict[str, Any]:
    """Return units and meaning, as the file has them."""
    quantity = _BY_NAME[name]
    meaning = {"units": quantity.units, "long_name": quantity.long_name}
    return {**meaning, **ZONE_ATTRIBUTES} if name == "zone" else meaning
