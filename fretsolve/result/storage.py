"""How columns and fields are stored in HDF5: blocks, compression, checksums, attributes and scales of axes.

Compression makes nine fields of mode I.3 on 256 x 256 points take 22 ms and 1.8 MB instead of 2 ms and 4.3 MB
(`fretsolve.result.planes`). gzip levels above 1 gain nothing, and only h5py reads lzf.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.result.layout import FieldQuantity, Quantity

FIELD_FILTERS: dict[str, Any] = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
"""zlib has a checksum (Adler's), which is compared on reading. HDF5's own besides would take 1 % of an increment."""

CHUNK_BYTES = 2**20

COLUMN_FILTERS: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "fletcher32": True}
SHORT_COLUMN = 4096
"""Bytes up to which a column lies in its own header, whose checksum HDF5 compares. 45 columns of 60 increments take
5.5 ms that way, compressed each by itself 8.3 ms, and no less space, as blocks and their index take some, too."""

PLAIN_FILTERS: dict[str, Any] = {"compression": "gzip", "compression_opts": 0}
"""Not compressed. Fletcher's checksum alone would take words of zeros and of ones, as in NaN, for the same."""


def chunk_shape(nx: int, ny: int) -> tuple[int, int]:
    """Return the cells of one chunk of a field of ``(nx, ny)`` cells: whole rows, of about a megabyte."""
    most_rows = max(1, CHUNK_BYTES // (8 * ny))
    chunks = -(-nx // most_rows)
    return -(-nx // chunks), ny


def create_field(group: Any, quantity: FieldQuantity, steps: int, shape: tuple[int, int]) -> Any:
    """Create a dataset ``(steps, nx, ny)`` of `quantity` in the HDF5 `group`, no chunk across two increments."""
    layout = {"chunks": (1, *chunk_shape(*shape)), **FIELD_FILTERS} if steps else {}
    return group.create_dataset(quantity.name, (steps, *shape), quantity.dtype, **layout)


def create_column(group: Any, quantity: Quantity, values: Any, scale: Any = None) -> Any:
    """Store a column of numbers with units, meaning and the `scale` of its axis; without one it is itself a scale."""
    import h5py

    data = np.array(values, quantity.dtype)
    return h5py.Dataset(_create(group, quantity, data, _storage_of(data), None if scale is None else scale.id))


def create_columns(group: Any, columns: Sequence[tuple[Quantity, Any]]) -> None:
    """Store columns as `create_column` does, the first of which is the scale of the others, all of one length."""
    storage: dict[Any, _Storage] = {}
    scale = None
    for quantity, values in columns:
        data = np.array(values, quantity.dtype)
        how = storage.get(data.dtype) or storage.setdefault(data.dtype, _storage_of(data))
        column = _create(group, quantity, data, how, scale)
        scale = column if scale is None else scale


def fill_columns(group: Any, columns: Sequence[tuple[Quantity, Any]]) -> None:
    """Write the values of short columns that the HDF5 `group` has."""
    from h5py import h5d, h5s

    for quantity, values in columns:
        h5d.open(group.id, quantity.name.encode()).write(h5s.ALL, h5s.ALL, np.array(values, quantity.dtype))


def is_short(dtype: str | np.dtype[Any], length: int) -> bool:
    """Return whether a column of so many numbers of a type lies in its own header."""
    return np.dtype(dtype).itemsize * length <= SHORT_COLUMN


@dataclass(frozen=True)
class _Storage:
    """The storage of a column in HDF5: objects of h5py's interface to the C library."""

    number_type: Any
    space: Any
    properties: Any


def _storage_of(data: NDArray[Any]) -> _Storage:
    """Return how a column is stored: a short one in its own header, a long one compressed."""
    from h5py import h5d, h5p, h5s, h5t

    properties = h5p.create(h5p.DATASET_CREATE)
    properties.set_obj_track_times(False)  # equal runs give equal files
    if is_short(data.dtype, len(data)):
        properties.set_layout(h5d.COMPACT)
    else:
        properties.set_chunk(data.shape)
        properties.set_deflate(COLUMN_FILTERS["compression_opts"])
        properties.set_fletcher32()
    return _Storage(h5t.py_create(data.dtype), h5s.create_simple(data.shape), properties)


def _create(group: Any, quantity: Quantity, data: NDArray[Any], how: _Storage, scale: Any) -> Any:
    """Return a new column of the C library's interface, which takes half the time of h5py's datasets: a result has some
    45 columns. scale: of that interface, too, None for a column that is one itself.
    """
    from h5py import h5d, h5ds, h5s

    column = h5d.create(group.id, quantity.name.encode(), how.number_type, how.space, how.properties)
    column.write(h5s.ALL, h5s.ALL, data)
    if scale is None:
        h5ds.set_scale(column, quantity.name.encode())
    else:
        h5ds.attach_scale(column, scale, 0)
    write_texts(column, quantity.attributes)
    return column


def write_texts(node: Any, texts: Mapping[str, str]) -> None:
    """Write attributes to a node of the C library's interface, in half the time of h5py's."""
    from h5py import h5a

    dtype, stored, one = _text_storage()
    for name, text in texts.items():
        h5a.create(node, name.encode(), stored, one).write(np.array(text, dtype))


@cache
def _text_storage() -> tuple[np.dtype[Any], Any, Any]:
    """Return the type of texts in NumPy and in HDF5, and HDF5's space of one."""
    import h5py
    from h5py import h5s, h5t

    dtype = h5py.string_dtype()
    return dtype, h5t.py_create(dtype, logical=True), h5s.create(h5s.SCALAR)


def copy_chunks(source: Any, source_step: int, target: Any, target_step: int) -> None:
    """Copy one increment of a field as it is compressed: both datasets have the same chunks and filters."""
    rows = source.chunks[1]
    for row in range(0, source.shape[1], rows):
        mask, data = source.id.read_direct_chunk((source_step, row, 0))
        target.id.write_direct_chunk((target_step, row, 0), data, mask)
