"""Fields for datasets of xarray, which are read when their values are asked for (extra ``xarray``)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing


class StoredField(BackendArray):
    """A field of all stored increments, ``(steps, nx, ny)``, of which `read` returns one at a time."""

    def __init__(
        self, read: Callable[[int], NDArray[Any]], steps: Sequence[int], shape: tuple[int, int], dtype: np.dtype[Any]
    ):
        self._plane, self._steps = read, np.array(steps, np.int64)
        self.shape = (len(steps), *shape)
        self.dtype = dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        which, rows, columns = key
        steps = self._steps[which]
        planes: Any = [self._plane(int(step))[rows][..., columns] for step in steps.flat]
        if not planes:
            planes = np.empty((0, *self.shape[1:]), self.dtype)[:, rows][..., columns]
        return np.asarray(planes if steps.ndim else planes[0])
