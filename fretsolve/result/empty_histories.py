"""Histories without values, with which the results of many cases begin.

HDF5 takes 5.8 ms to create the 42 columns of 60 increments with their attributes and axes, and 1.9 ms to fill them in a
copy of a file that has them. For the cases of a sweep of 48 x 48 cells that is a quarter of what their results take.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from fretsolve.result.layout import Quantity
from fretsolve.result.storage import create_columns, is_short
from fretsolve.system.atomic_files import HDF5_VERSIONS


class EmptyHistories:
    """Keeps the file of the last empty history, since most cases of a sweep have the same columns and increments.

    It is made when they come a second time: where they differ from case to case, it would take more than it saves.
    """

    def __init__(self) -> None:
        self._key: Any = None
        self._file = b""

    def file(self, columns: Sequence[Quantity], increments: int) -> bytes:
        """Return the bytes of an HDF5 file with the columns of a history, all 0; empty where there is none.

        There is none of long columns, which are compressed: space for their values would be taken twice.
        """
        if self._key != (key := (*columns, increments)):
            self._key, self._file = key, b""
        elif not self._file and all(is_short(column.dtype, increments) for column in columns):
            self._file = _empty_history(columns, increments)
        return self._file


def _empty_history(columns: Sequence[Quantity], increments: int) -> bytes:
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=HDF5_VERSIONS) as file:
        zeros = np.zeros(increments)
        create_columns(file.create_group("history"), [(column, zeros) for column in columns])
    return memory.getvalue()
