"""Read heights from arrays of HDF5 and NumPy files, [x, y] unless dimension scales say otherwise."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import in_small_unit
from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.surface.files.hdf5_notes import Attributes, Axis, axes_of, in_one_unit, is_scale, stated_spacing
from fretsolve.problem.surface.files.raw_map import AGREEMENT, MOST_HEIGHTS, RawMap
from fretsolve.system.hdf5_files import LARGEST_RATIO, dataset_names, open_hdf5, own_dataset, try_attributes

MOST_BYTES = 16 * MOST_HEIGHTS
"""Bytes of the heights as they are stored."""


def is_hdf5(file: Path) -> bool:
    """Return whether a file, of whatever ending, is an HDF5 file, as those of netCDF-4 are. Raises OSError."""
    file.stat()
    return bool(h5py.is_hdf5(file))


def read_hdf5(file: Path, dataset: str | None, key: KeyPath) -> RawMap:
    """Read a dataset, with what its attributes and dimension scales say of unit and spacing.

    An array whose scales or dimensions are named y, x in this order is turned to [x, y], and one whose coordinates
    descend is mirrored. Raises FileError, CaseError (at `key`) without such a dataset, ValueError.
    """
    try_attributes(file)
    with open_hdf5(file) as stored:
        names = dataset_names(stored)
        if dataset is None:
            names = [name for name in names if not is_scale(stored[name])]
        node = own_dataset(stored, _chosen(dataset and dataset.strip("/"), names, file, key))
        _require_plausible(node.shape, node.dtype)
        notes = Attributes(node)
        raw = _along_scales(RawMap(_scaled(np.asarray(node[()]), notes)), axes_of(node))
        unit, stated, of_unit = notes.unit("unit", "units", "z_unit")
        spacing, of_spacing = stated_spacing(notes)
        raw = replace(raw, unit=unit, stated=stated, remarks=(*raw.remarks, *of_unit, *of_spacing))
        return raw if spacing is None else _spaced(raw, *spacing)


def _spaced(raw: RawMap, spacing: tuple[float, ...], unit: float | None) -> RawMap:
    """Return the map with the spacing that attributes state, in `unit` (mm).

    Raises ValueError if the coordinates say another.
    """
    remarks = raw.remarks
    if raw.spacing is not None and raw.xy_unit is None:
        remarks = (*remarks, "its attributes give the spacing, not its coordinates, which have no unit")
    elif raw.spacing is not None and raw.xy_unit is not None:
        for axis, own, step in zip("xy", spacing * 2 if len(spacing) == 1 else spacing, raw.spacing, strict=False):
            one, other = own * (unit or 1.0), step * raw.xy_unit
            if abs(one - other) > AGREEMENT * other:
                raise ValueError(
                    f"its attributes say that the spacing along {axis} is {in_small_unit(one)}, its coordinates that it"
                    f" is {in_small_unit(other)}; remove what is wrong"
                )
    return replace(raw, spacing=spacing, xy_unit=unit, xy_stated="", remarks=remarks)


def _scaled(values: NDArray[Any], notes: Attributes) -> NDArray[Any]:
    """Return stored numbers as heights, by the netCDF attributes for lost points, scale and offset."""
    lost = [number for name in ("_FillValue", "missing_value") for number in notes.numbers(name)]
    factor, offset = notes.numbers("scale_factor"), notes.numbers("add_offset")
    if values.dtype.kind not in "iuf" or not (lost or factor or offset):
        return values
    heights = values.astype(np.float64)
    heights[np.isin(values, np.array(lost).astype(values.dtype))] = np.nan
    return heights * (factor[0] if factor else 1.0) + (offset[0] if offset else 0.0)


def _along_scales(raw: RawMap, axes: list[Axis]) -> RawMap:
    """Return the array as [x, y], both ascending, with the spacing of its coordinates."""
    values, remarks = raw.values, []
    if [axis.name for axis in axes] == ["y", "x"]:
        values, axes = values.T, axes[::-1]
        remarks.append("its dimensions are y, x: transposed to x, y")
    for number, (name, axis) in enumerate(zip("xy", axes, strict=False)):
        if axis.step is not None and axis.step < 0:
            values = np.flip(values, number)
            remarks.append(f"its {name} descends: mirrored in {name}")
    remarks += [remark for axis in axes for remark in axis.remarks]
    if not axes or any(axis.step is None for axis in axes):
        return replace(raw, values=values, remarks=tuple(remarks))
    spacing, unit = in_one_unit([(abs(axis.step or 0.0), axis.unit) for axis in axes])
    stated = next((axis.stated for axis in axes if axis.stated), "")
    return RawMap(values, spacing, xy_unit=unit, remarks=tuple(remarks), xy_stated=stated)


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
