"""Read heights from files of instruments, by the library SurfaceTopography.

The library takes seconds to load, so only such a file loads it. An ending decides what a file is: the library's guesses
from the contents go wrong.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.keys.map_keys import HDF5_SUFFIXES
from fretsolve.case.quantities import shown
from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.surface.files.raw_map import MOST_HEIGHTS, NUMPY_SUFFIXES, TEXT_SUFFIXES, RawMap
from fretsolve.problem.surface.files.stated_units import length_unit
from fretsolve.system.environment import how_to_install

_NAMES = "al3d bcr datx di frt gwy lext mnt nc nms oir opd opdx os3d plu plux poir ps sdf sur tmd vk x3p zmg zon"
FORMATS = frozenset(_NAMES.split())
"""Formats that are read, by the library's names: of instruments, with units, and with rows as an image has them.

The library's other formats are tables without units, terrain, or not known to be right.
"""

ROWS_UPWARDS = frozenset({"nc", "sdf"})
"""Formats whose second index the library returns upwards; that of the others begins at the top row.

ISO 25178-71 gives y = (i - 1) Yscale for profile i of an sdf file, in a right-handed system: the first is the bottom.
"""

ROWS_TRIED = ROWS_UPWARDS | frozenset(["al3d", "bcr", "di", "frt", "gwy", "opd", "plu", "plux", "sur", "tmd", "vk"])
"""Formats whose top row is known, by files of instruments, by writers or by what is published.

x3p is none of them: editions of its standard are said to differ in the corner at which the rows begin.
"""


def read_instrument(file: Path, dataset: str | None, key: KeyPath) -> RawMap:
    """Read the channel `dataset` of a file, by default the first one of heights.

    key: place of the map in the case. Raises CaseError for an ending that is not read, and if the channel or the
    library is missing; whatever the library raises for a damaged file.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of packages that the library would like to have, and of odd contents
        name, opened = _library(file, key)
        with opened(str(file), format=name) as reader:
            try:
                raw = _read(reader, dataset, file, key, upwards=name in ROWS_UPWARDS)
            except KeyError as error:
                raise ValueError(f"{error} is missing in it") from error
    if name in ROWS_TRIED or raw.values.ndim == 1:
        return raw
    remark = "which row of this format is the top was not tried: compare the sides with the instrument's picture"
    return replace(raw, remarks=(*raw.remarks, remark))


def _library(file: Path, key: KeyPath) -> tuple[str, Any]:
    """Return the library's name of a file's format, and its function that opens files."""
    own = ", ".join((*TEXT_SUFFIXES, *NUMPY_SUFFIXES, *HDF5_SUFFIXES))
    try:
        from SurfaceTopography.IO import open_topography, readers
    except ImportError as error:
        message = f"{file.name!r} does not end in {own}; others are read by SurfaceTopography, which cannot be imported"
        raise CaseError(f"{message} ({error}): {how_to_install('surfaces')}", (*key, "file")) from error
    named = {f".{end}": one.format() for one in readers if one.format() in FORMATS for end in one.file_extensions()}
    name = named.get(file.suffix.lower())
    if name is None:
        others = ", ".join(sorted(named))
        raise CaseError(f"{file.name!r} has an unknown ending; {own} are read, and {others}", (*key, "file"))
    return name, open_topography


def _read(reader: Any, dataset: str | None, file: Path, key: KeyPath, *, upwards: bool) -> RawMap:
    """Return the heights of a channel as [x, y], y upwards."""
    channel, remarks = _channel(reader, dataset, file, key)
    if channel.is_uniform is False:
        raise ValueError("the points of its profile are unevenly spaced; give them as text, x and z in a line")
    points, size = channel.nb_grid_pts, channel.physical_sizes
    if math.prod(points) > MOST_HEIGHTS:
        sides = " x ".join(map(str, points))
        raise ValueError(f"it has {sides} heights, at most {MOST_HEIGHTS} in all are read; give a part of it")
    surface = channel.topography(**({"physical_sizes": points} if size is None else {}))
    heights = surface.heights()
    values = np.array(heights, np.float64)
    lost = np.ma.getmaskarray(heights)
    values[lost] = np.nan
    values[np.abs(values) > np.finfo(np.float32).max] = np.nan  # programs write such numbers for lost points
    if lost.any():
        remarks.append(f"{np.count_nonzero(lost)} of its points are masked: they count as lost")
    unit = length_unit(surface.unit)
    stated = str(surface.unit) if surface.unit and unit is None else ""
    if unit is None:
        remarks.append(f"its unit {shown(stated)} is not known" if stated else "it states no unit")
    spacing = None if size is None else tuple(float(a) / n for a, n in zip(surface.physical_sizes, points, strict=True))
    flipped = values if upwards or values.ndim == 1 else values[:, ::-1]
    return RawMap(flipped, spacing, unit, unit, tuple(remarks), (), stated, stated)


def _channel(reader: Any, dataset: str | None, file: Path, key: KeyPath) -> tuple[Any, list[str]]:
    """Return the channel of heights that is asked for, or the first one; and a remark if there are several."""
    channels = {one.channel_id: one for one in reader.channels if one.is_height_channel}
    if not channels:
        raise ValueError("it holds no heights")
    names = ", ".join(map(repr, channels))
    if dataset is None:
        first, chosen = next(iter(channels.items()))
        return chosen, [f"channel {first!r} is read, the first of {names}"] if len(channels) > 1 else []
    if dataset not in channels:
        raise CaseError(f"there is no channel {dataset!r} in {file.name!r}, which has {names}", (*key, "dataset"))
    return channels[dataset], []
