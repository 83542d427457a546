"""Read heights from arrays of HDF5 and NumPy files, [x, y]."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.surface.raw_map import MOST_HEIGHTS, RawMap
from fretsolve.system.hdf5_files import LARGEST_RATIO, dataset_names, open_hdf5, own_dataset, try_attributes

MOST_BYTES = 16 * MOST_HEIGHTS
"""Bytes of the heights as they are stored."""


def read_hdf5(file: Path, dataset: str | None, key: KeyPath) -> RawMap:
    """Read a dataset, with the spacing from its attributes `spacing`, or `dx` and `dy` (mm)."""
    try_attributes(file)
    with open_hdf5(file) as stored:
        name = _chosen(dataset and dataset.strip("/"), dataset_names(stored), file, key)
        node = own_dataset(stored, name)
        _require_plausible(node.shape, node.dtype)
        separate = [node.attrs[name] for name in ("dx", "dy") if name in node.attrs]
        spacing = tuple(float(step) for step in np.ravel(node.attrs.get("spacing", separate)))
        return RawMap(np.asarray(node[()]), spacing or None)


def read_numpy(file: Path, dataset: str | None, key: KeyPath) -> RawMap:
    """Read the array of an ``.npy`` file, or the chosen one of an ``.npz`` file."""
    values: NDArray[Any]
    try:
        if not zipfile.is_zipfile(file):
            if dataset is not None:
                raise CaseError(f"{file.name!r} holds one array and no datasets; leave {dataset!r} out", key)
            values = np.lib.format.open_memmap(file, "r")  # mapped, so its size is known before it is read
        else:
            with zipfile.ZipFile(file) as archive:
                members = {one.filename.removesuffix(".npy"): one for one in archive.infolist()}
                member = members[_chosen(dataset, list(members), file, key)]
                if member.file_size > min(MOST_BYTES, LARGEST_RATIO * member.compress_size):
                    raise ValueError("more than the file can hold")
                with archive.open(member) as stream:
                    values = np.lib.format.read_array(stream, allow_pickle=False)
    except CaseError:
        raise
    except Exception as error:  # their texts give advice on pickle, or come from Python's parser
        raise ValueError("it is not a NumPy file of numbers, or it is cut short or damaged") from error
    _require_plausible(values.shape, values.dtype)
    return RawMap(values)


def _require_plausible(shape: Sequence[int], dtype: np.dtype[Any]) -> None:
    """Raise ValueError for more heights than a map has."""
    if math.prod(shape) > MOST_HEIGHTS or math.prod(shape) * dtype.itemsize > MOST_BYTES:
        sides = " x ".join(map(str, shape))
        raise ValueError(f"it has {sides} heights, at most {MOST_HEIGHTS} in all are read; give a part of it")


def _chosen(dataset: str | None, names: list[str], file: Path, key: KeyPath) -> str:
    """Return the name of the dataset asked for, or of the only one."""
    if dataset is None and len(names) == 1:
        return names[0]
    if dataset in names:
        return dataset
    wanted = "dataset is missing" if dataset is None else f"there is no dataset {dataset!r} in {file.name!r}"
    raise CaseError(f"{wanted}; {file.name!r} has {', '.join(sorted(names)) or 'none'}", key)
