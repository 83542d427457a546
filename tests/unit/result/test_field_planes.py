"""Planes of fields come back as they were, through the filters of HDF5 alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fretsolve.result import storage
from fretsolve.result.layout import FIELDS
from fretsolve.result.planes import write_planes
from fretsolve.result.layout import create_field
from fretsolve.system.arrays import FloatArray

PRESSURE, ZONE = (next(one for one in FIELDS if one.name == name) for name in ("pressure", "zone"))
SHAPE = (50, 37)


def dome() -> FloatArray:
    """Return a plane of zeros around a field, as that of a contact. Without symmetry no number comes twice."""
    x, y = np.linspace(-2.1, 1.9, SHAPE[0])[:, None], np.linspace(-1.8, 2.3, SHAPE[1])
    return np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))


@pytest.mark.parametrize("rows", [1, 7, 50])
@pytest.mark.parametrize(("quantity", "dtype"), [(PRESSURE, "float64"), (PRESSURE, "float32"), (ZONE, "uint8")])
def test_planes_come_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int, quantity: Any, dtype: str
) -> None:
    monkeypatch.setattr(storage, "CHUNK_BYTES", 8 * SHAPE[1] * rows)
    planes = [dome(), np.full(SHAPE, 2.0), np.broadcast_to(0.0, SHAPE), dome().T.copy().T]
    planes = [plane.astype(dtype) if plane.strides[0] else plane for plane in planes]
    with h5py.File(tmp_path / "planes.h5", "w") as file:
        dataset = create_field(file, replace(quantity, dtype=dtype), 5, SHAPE)
        write_planes(dataset, 1, planes)
    with h5py.File(tmp_path / "planes.h5") as file:
        stored = file[quantity.name]
        assert (stored.compression, stored.shuffle, stored.dtype) == ("gzip", True, np.dtype(dtype))
        assert not stored[0].any()
        for number, plane in enumerate(planes, start=1):
            assert np.array_equal(stored[number], plane.astype(dtype))


def test_fields_take_about_as_many_bytes_as_by_hdf5(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "planes.h5", "w") as file:
        dataset, by_hdf5 = (create_field(file.create_group(name), PRESSURE, 1, SHAPE) for name in ("own", "hdf5"))
        write_planes(dataset, 0, [dome()])
        by_hdf5[0] = dome()
        file.flush()
        assert dataset.id.get_storage_size() < 1.1 * by_hdf5.id.get_storage_size()


def test_damage_is_found(tmp_path: Path) -> None:
    path = tmp_path / "planes.h5"
    with h5py.File(path, "w") as file:
        dataset = create_field(file, PRESSURE, 1, SHAPE)
        write_planes(dataset, 0, [dome()])
        place, size = dataset.id.get_chunk_info(0).byte_offset, dataset.id.get_chunk_info(0).size
    content = bytearray(path.read_bytes())
    content[place + size // 2] ^= 1
    path.write_bytes(content)
    with h5py.File(path) as file, pytest.raises(OSError, match="filter"):
        file["pressure"][0]
