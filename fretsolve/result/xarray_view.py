"""A result as datasets of xarray, whose fields are read when their values are asked for (extra ``xarray``)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from fretsolve.result.layout import ERRORS, FIELDS, HISTORY, STEP, ZONE_ATTRIBUTES, Quantity, X, Y

if TYPE_CHECKING:
    from fretsolve.result.reader import Result

Group = Literal["history", "fields"]

_BY_NAME: dict[str, Quantity] = {quantity.name: quantity for quantity in (STEP, *HISTORY, *ERRORS, X, Y, *FIELDS)}


class StoredField(BackendArray):
    """A field of all stored increments, ``(steps, nx, ny)``; one increment after another is read from the result."""

    def __init__(self, result: Result, name: str):
        self._result, self._name = result, name
        self.dtype = result.field_type(name)
        self.shape = (len(result.steps), len(result.x), len(result.y))

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        which, rows, columns = key
        steps = np.asarray(self._result.steps)[which]
        if steps.ndim == 0:
            return self._plane(int(steps), rows, columns)
        planes = [self._plane(int(step), rows, columns) for step in steps]
        empty = np.empty(self.shape[1:], self.dtype)[rows][..., columns]
        return np.stack(planes) if planes else np.empty((0, *empty.shape), self.dtype)

    def _plane(self, step: int, rows: Any, columns: Any) -> NDArray[Any]:
        return np.asarray(self._result.field(self._name, step)[rows][..., columns])


def as_xarray(result: Result, group: Group) -> xarray.Dataset:
    """See `Result.to_xarray`."""
    if group == "history":
        columns = {name: ("step", column, _meaning(name)) for name, column in result.history.items()}
        return xarray.Dataset(columns, attrs=result.attributes)
    if group != "fields":
        raise ValueError(f"a result has the groups history and fields, not {group!r}")
    axes = {"step": np.asarray(result.steps, STEP.dtype), "x": result.x, "y": result.y}
    fields = {
        name: (("step", "x", "y"), indexing.LazilyIndexedArray(StoredField(result, name)), _meaning(name))
        for name in result.fields
    }
    return xarray.Dataset(fields, {name: _scale(name, values) for name, values in axes.items()}, result.attributes)


def _scale(name: str, values: NDArray[Any]) -> tuple[str, NDArray[Any], dict[str, Any]]:
    return name, values, _meaning(name)


def _meaning(name: str) -> dict[str, Any]:
    """Units and meaning, as the file has them."""
    quantity = _BY_NAME[name]
    meaning = {"units": quantity.units, "long_name": quantity.long_name}
    return {**meaning, **ZONE_ATTRIBUTES} if name == "zone" else meaning
