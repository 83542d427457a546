"""Datasets of xarray whose fields are read when their values are asked for (extra ``xarray``)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from fretsolve.result.layout import QUANTITIES, STEP
from fretsolve.system.arrays import DoubleArray

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
        planes: Any = [self._read_plane(self._name, int(step))[rows][..., columns] for step in steps.flat]
        if not planes:
            planes = np.empty((0, *self.shape[1:]), self.dtype)[:, rows][..., columns]
        return np.asarray(planes if steps.ndim else planes[0])


def history_dataset(history: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]) -> xarray.Dataset:
    """Return the columns of a history over `step`."""
    columns = {name: ("step", column, QUANTITIES[name].attributes) for name, column in history.items()}
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
    variables: dict[str, Any] = {n: (n, values, QUANTITIES[n].attributes) for n, values in axes.items()}
    for name, dtype in types.items():
        field = indexing.LazilyIndexedArray(StoredField(read, name, steps, (len(x), len(y)), dtype))
        variables[name] = tuple(axes), field, QUANTITIES[name].attributes
    return xarray.Dataset(variables, attrs=attributes)
