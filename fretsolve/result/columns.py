"""The columns of a history as an HDF5 file in memory, with which a result begins.

HDF5 takes 0.1 ms to create a small dataset with its attributes and as long to fill it, several milliseconds for a
history: much, where a sweep has thousands of small cases. So the columns are created once, and each history's
numbers are put where the chunks lie, with the checksums of HDF5's Fletcher32 filter behind them.
"""

from __future__ import annotations

import functools
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5d, h5ds, h5p, h5s, h5t
from numpy.typing import NDArray

from fretsolve.result.layout import ERRORS, HISTORY, STEP, Quantity
from fretsolve.result.state import Summary, SummaryErrors
from fretsolve.system.atomic_files import LIBRARY_VERSIONS

_TEXT = h5py.string_dtype()


@dataclass(frozen=True)
class _Form:
    """A file whose columns are to be filled. offsets: of their chunks in it, none where there is no increment."""

    image: bytes
    offsets: tuple[int, ...]


def history_image(summaries: Sequence[Summary], errors: Sequence[SummaryErrors] | None) -> bytes:
    """An HDF5 file with the group ``history`` alone, whose columns have a number per increment.

    errors: the error bars of all increments, None for no such columns.
    """
    form = _form(len(summaries), errors is not None)
    columns = _columns((STEP, *HISTORY), summaries) + (_columns(ERRORS, errors) if errors else [])
    image = bytearray(form.image)
    for column, offset in zip(columns if summaries else (), form.offsets, strict=True):
        data = column.tobytes()
        chunk = data + _checksum(data)
        image[offset : offset + len(chunk)] = chunk
    return bytes(image)


def add_scale(group: Any, quantity: Quantity, values: Any) -> h5d.DatasetID:
    """A dimension scale of some numbers."""
    scale = _add_column(group, quantity, values)
    h5ds.set_scale(scale, quantity.name.encode())
    return scale


def attach(dataset: h5d.DatasetID, *scales: h5d.DatasetID) -> None:
    """Give the axes of a dataset their scales."""
    for axis, scale in enumerate(scales):
        h5ds.attach_scale(dataset, scale, axis)


def add_text(target: h5d.DatasetID, name: str, value: str) -> None:
    """An attribute, by HDF5's own calls: the objects of h5py would take three times as long."""
    kind = h5t.py_create(_TEXT, logical=True)
    h5a.create(target, name.encode(), kind, h5s.create(h5s.SCALAR)).write(np.array(value, _TEXT))


@functools.lru_cache(maxsize=2)
def _form(increments: int, with_errors: bool) -> _Form:
    memory = io.BytesIO()  # the image of an open file would not do: HDF5 1.14 leaves a wrong checksum in it
    zeros = np.zeros(increments)
    with h5py.File(memory, "w", libver=LIBRARY_VERSIONS) as file:
        group = file.create_group("history")
        scale = add_scale(group, STEP, zeros)
        columns = [scale]
        for quantity in HISTORY + (ERRORS if with_errors else ()):
            columns.append(_add_column(group, quantity, zeros))
            attach(columns[-1], scale)
        offsets = tuple(column.get_chunk_info(0).byte_offset for column in columns) if increments else ()
    return _Form(memory.getvalue(), offsets)


def _columns(quantities: Sequence[Quantity], rows: Sequence[Any]) -> list[NDArray[Any]]:
    return [np.array([getattr(row, quantity.name) for row in rows], quantity.dtype) for quantity in quantities]


def _checksum(data: bytes) -> bytes:
    """Fletcher's checksum of an even number of bytes in HDF5's form: sums modulo 65535, which are 0 of zeros alone."""
    words = np.frombuffer(data, ">u2").astype(np.uint64)
    sums = int(words.sum()), int(words @ np.arange(len(words), 0, -1, dtype=np.uint64))
    low, high = ((total - 1) % 65535 + 1 if total else 0 for total in sums)
    return (high << 16 | low).to_bytes(4, "little")


def _add_column(group: Any, quantity: Quantity, values: Any) -> h5d.DatasetID:
    """A dataset of some numbers in a chunk with a checksum, by HDF5's own calls."""
    data = np.asarray(values, quantity.dtype)
    layout = h5p.create(h5p.DATASET_CREATE)
    layout.set_obj_track_times(False)
    if data.size:
        layout.set_chunk(data.shape)
        layout.set_fletcher32()
    kind, space = h5t.py_create(data.dtype, logical=True), h5s.create_simple(data.shape)
    dataset = h5d.create(group.id, quantity.name.encode(), kind, space, layout)
    dataset.write(h5s.ALL, h5s.ALL, data)
    for name, value in (("units", quantity.units), ("long_name", quantity.long_name)):
        add_text(dataset, name, value)
    return dataset
