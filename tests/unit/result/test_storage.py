"""How columns and fields are stored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fretsolve.result.layout import HISTORY, STEP
from fretsolve.result.layout import CHUNK_BYTES, SHORT_COLUMN, chunk_shape, create_column, create_columns


@pytest.mark.parametrize(("shape", "chunk"), [((6, 5), (6, 5)), ((512, 512), (256, 512)), ((1000, 1000), (125, 1000))])
def test_chunks_are_whole_rows_of_about_a_megabyte(shape: tuple[int, int], chunk: tuple[int, int]) -> None:
    assert chunk_shape(*shape) == chunk
    assert 8 * chunk[0] * chunk[1] <= CHUNK_BYTES


PRESSING_FORCE = next(one for one in HISTORY if one.name == "P")


def layout_of(column: Any) -> int:
    return int(column.id.get_create_plist().get_layout())


def described_as(column: Any) -> tuple[Any, ...]:
    """Return all that a reader may ask of a column."""
    filters = layout_of(column), column.chunks, column.compression, column.compression_opts, column.fletcher32
    texts = {name: (column.attrs[name], str(column.attrs.get_id(name).dtype)) for name in ("units", "long_name")}
    scales = [scale.name.rpartition("/")[2] for scale in column.dims[0].values()]
    return column.dtype, column[:].tolist(), filters, texts, scales, column.is_scale


@pytest.mark.parametrize("increments", [0, 1, 7, 600])
def test_columns_written_together_are_those_written_one_by_one(tmp_path: Path, increments: int) -> None:
    rng = np.random.default_rng(1)
    columns = [(STEP, np.arange(increments)), *((one, 1e3 * rng.normal(size=increments)) for one in HISTORY)]
    with h5py.File(tmp_path / "columns.h5", "x") as file:
        one_by_one, together = file.create_group("one by one"), file.create_group("together")
        scale = None
        for quantity, values in columns:
            column = create_column(one_by_one, quantity, values, scale)
            scale = scale or column
        create_columns(together, columns)
        assert list(together) == list(one_by_one)
        for name in one_by_one:
            assert described_as(together[name]) == described_as(one_by_one[name])


@pytest.mark.parametrize("longer", [0, 1])
def test_a_flipped_bit_is_found(tmp_path: Path, longer: int) -> None:
    values = np.linspace(10.0, 20.0, SHORT_COLUMN // 8 + longer)
    with h5py.File(tmp_path / "columns.h5", "x", libver=("v110", "v110")) as file:
        short = layout_of(create_column(file, PRESSING_FORCE, values)) == h5py.h5d.COMPACT
        assert short is not longer
    image = bytearray((tmp_path / "columns.h5").read_bytes())
    if short:
        offset = image.index(values.tobytes())
    else:
        with h5py.File(tmp_path / "columns.h5") as file:
            offset = file[PRESSING_FORCE.name].id.get_chunk_info(0).byte_offset
    image[offset + 5] ^= 1
    (tmp_path / "columns.h5").write_bytes(image)
    with (
        h5py.File(tmp_path / "columns.h5") as file,
        pytest.raises((KeyError, OSError), match=r"checksum|filter returned"),
    ):
        file[PRESSING_FORCE.name][:]
