"""Measured maps of a case: read, brought to mm, and prepared as the case asks.

What a file says of its own units and spacing counts; the case gives what is missing. Where both speak they must agree
to 1 %, unless the case says `override`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import in_small_unit
from fretsolve.case.keys.map_keys import HDF5_SUFFIXES, HeightsSurface, MapKeys
from fretsolve.case.quantities import LARGEST_MAGNITUDE, LEAST_MAGNITUDE, shown
from fretsolve.errors import CaseError, FileError, FretsolveError, KeyPath, shortened
from fretsolve.problem.surface.files.array_map import is_hdf5, read_hdf5, read_numpy
from fretsolve.problem.surface.files.instrument_map import read_instrument
from fretsolve.problem.surface.files.raw_map import AGREEMENT, NUMPY_SUFFIXES, TEXT_SUFFIXES, RawMap
from fretsolve.problem.surface.files.text_map import read_text
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_steps import prepared
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import require_regular

LARGEST_SPACING = 1.0
"""mm between the points of a map, if a file is to be believed: a contact is hardly wider."""


def height_map_separation(source: HeightsSurface, x: DoubleArray, y: DoubleArray, key: KeyPath) -> DoubleArray:
    """Return the separation (nx, ny) in mm at ascending `x` (nx,), `y` (ny,) in mm from the map's centre.

    It is +inf off the map and around its holes. key: place of the source in the case. Raises as `load_height_map`, and
    CaseError if no cell lies on the map.
    """
    height_map = load_height_map(source, key)
    result = height_map.sample(x, y)
    if not np.isfinite(result).any():
        spans = " x ".join(f"{span:g}" for span in height_map.span)
        message = f"no cell of the grid lies on the map {source.file.name!r} of {spans} mm"
        raise CaseError(f"{message} or all lie in its holes; move its center or the grid", key)
    for name, cells, step in zip("xy", (x, y), height_map.spacing, strict=True):
        if len(cells) > 1 and step > (area := float(cells[-1] - cells[0])):
            raise CaseError(
                f"the points of the map are {_length(step)} apart along {name}, the grid is {_length(area)} long: no"
                " point of the map need lie in the contact; is the spacing right?",
                (*key, "spacing"),
            )
    return result


def load_height_map(source: HeightsSurface, key: KeyPath) -> HeightMap:
    """Read the height map `source`, whose place in the case is `key`, and prepare it as the case asks.

    Raises FileError if the file is missing or cannot be read, and CaseError (at `key` or below) if it does not hold a
    map, contradicts the case, or cannot be prepared.
    """
    return _prepared(source, key, *_state(source.file))


@lru_cache(maxsize=4)
def _prepared(source: HeightsSurface, key: KeyPath, size: int, changed: int) -> HeightMap:
    """Return a map that does not change as long as its file does not: a run needs it several times."""
    raw = _oriented(read_map(source.file, source, key, line=source.of_line), source)
    _require_length("heights", raw.stated, source.unit, (*key, "unit"))
    unit = _agreed("the unit of its values", source.unit, raw.unit, source, (*key, "unit")) or 1.0
    doubts = raw.doubts
    if source.unit is None and raw.unit is None:
        doubts = (*doubts, "the values count as mm, since neither the file nor the case gives their unit")
    values = _checked(raw.values, source.file, (*key, "file"), line=source.of_line)
    if source.lost is not None:
        values[values == source.lost] = np.nan
        _require_heights(values, source.file, (*key, "lost"))
    spacing = _spacing(raw, unit, source, source.file, key)
    values *= -unit if source.invert else unit
    _require_plausible(values, spacing, source, key)
    done = prepared(HeightMap(values, spacing, source.resample == "mean", raw.remarks, doubts), source, key)
    done.values.flags.writeable = False
    return done


def load_value_map(file: Path, keys: MapKeys, key: KeyPath, *, line: bool) -> HeightMap:
    """Read a map of plain numbers, such as coefficients of friction; raises as `load_height_map`."""
    raw = _oriented(read_map(file, keys, key, line=line), keys)
    if raw.unit is not None and not keys.override:
        message = f"the file states lengths (in units of {_length(raw.unit)}), coefficients have no unit"
        raise CaseError(f"{message}; give a file of coefficients, or add override: true if it is one", (*key, "map"))
    values = _checked(raw.values, file, (*key, "file"), line=line)
    return HeightMap(values, _spacing(raw, 1.0, keys, file, key), remarks=raw.remarks, doubts=raw.doubts)


def read_map(file: Path, keys: MapKeys, key: KeyPath, *, line: bool) -> RawMap:
    """Return what a file holds; line: whether a profile is wanted. Raises FileError, CaseError."""
    suffix = file.suffix.lower()
    try:
        require_regular(file, 2**30 if suffix in TEXT_SUFFIXES else 2**33)
        if suffix in HDF5_SUFFIXES or (suffix == ".nc" and is_hdf5(file)):
            return read_hdf5(file, keys.dataset, (*key, "dataset"))
        if suffix in NUMPY_SUFFIXES:
            return read_numpy(file, keys.dataset, (*key, "dataset"))
        if suffix in TEXT_SUFFIXES:
            return read_text(file, line=line)
        return read_instrument(file, keys.dataset, key)
    except FretsolveError:
        raise
    except Exception as error:  # whatever the libraries raise on a damaged file
        reason = (isinstance(error, OSError) and error.strerror) or shortened(str(error)) or type(error).__name__
        raise FileError(f"the height map cannot be read: {reason}", file) from error


def _state(file: Path) -> tuple[int, int]:
    """Return size and time of the last change, 0 where there is no file, which reading it reports."""
    try:
        found = file.stat()
    except OSError:
        return 0, 0
    return found.st_size, found.st_mtime_ns


def _oriented(raw: RawMap, keys: MapKeys) -> RawMap:
    """Return what a file holds, with x and y exchanged and mirrored as the case asks."""
    values, spacing = raw.values, raw.spacing
    if keys.transpose:
        values, spacing = values.T, None if spacing is None else spacing[::-1]
    for axis in keys.flip or ():
        values = np.flip(values, "xy".index(axis))
    return replace(raw, values=values, spacing=spacing)


def _agreed(what: str, of_case: float | None, of_file: float | None, keys: MapKeys, key: KeyPath) -> float | None:
    """Return a length (mm) that the file or the case gives, by the case if both do. Raises CaseError if they differ."""
    if of_case is None or of_file is None or keys.override:
        return of_file if of_case is None else of_case
    if abs(of_file - of_case) > AGREEMENT * of_case:
        raise CaseError(
            f"{what} is {_length(of_file)} by the file, {_length(of_case)} by the case; remove the key,"
            " or add override: true if the file is wrong",
            key,
        )
    return of_file


def _require_length(what: str, stated: str, of_case: float | None, key: KeyPath) -> None:
    """Refuse a file that states a unit that is no length, unless the case gives one."""
    if stated and of_case is None:
        raise CaseError(f"the file states its {what} in {shown(stated)}, which is no length; give {key[-1]}", key)


def _length(value: float) -> str:
    return in_small_unit(value)


def _spacing(raw: RawMap, unit: float, keys: MapKeys, file: Path, key: KeyPath) -> tuple[float, float]:
    """Return the spacing (mm) that the file or the case gives; unit: of the values (mm)."""
    example = "give that of the map's points, such as [1 um, 1 um]"
    place = (*key, "spacing")
    if raw.spacing is None:
        if keys.spacing is None:
            raise CaseError(f"spacing is missing, and {file.name!r} has none; {example}", place)
        return keys.spacing
    if keys.spacing is not None and keys.override and raw.xy_stated:
        return keys.spacing
    _require_length("x and y", raw.xy_stated, keys.xy_unit, (*key, "xy_unit"))
    scale = _agreed("the unit of x and y", keys.xy_unit, raw.xy_unit, keys, (*key, "xy_unit")) or unit
    found = tuple(scale * step for step in raw.spacing)
    pair = found * 2 if len(found) == 1 else found
    if len(pair) != 2 or not all(LEAST_MAGNITUDE <= step <= LARGEST_MAGNITUDE for step in pair):
        if keys.spacing is not None and keys.override:
            return keys.spacing
        raise CaseError(f"the spacing in {file.name!r} is {list(raw.spacing)}; {example}", place)
    if max(pair) > LARGEST_SPACING and not keys.override:
        raise CaseError(
            f"the points in {file.name!r} are {_length(max(pair))} apart by what it says, more than"
            f" {_length(LARGEST_SPACING)}; check its units, and {example} with override: true",
            place,
        )
    own = keys.spacing or (None, None)
    names = ("its spacing along x", "its spacing along y")
    x, y = (_agreed(*words, keys, place) for words in zip(names, own, pair, strict=True))
    assert x is not None and y is not None
    return x, y


def _checked(values: NDArray[Any], file: Path, key: KeyPath, *, line: bool) -> DoubleArray:
    """Return `values` as floats (mx, my), NaN where not finite; a profile of a line contact as (n, 1)."""
    shape = " x ".join(map(str, values.shape)) or "scalar"
    if line:
        column = values if values.ndim == 1 else values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else None
        if column is None:
            raise CaseError(f"{file.name!r} holds a {shape} array; plane: strain takes one column of heights", key)
        values = column[:, None]
    if values.ndim != 2 or min(values.shape) < (1 if line else 2) or max(values.shape) < 2:
        held = f"{values.size} values in a row" if values.ndim == 1 else f"a {shape} array"
        raise CaseError(f"{file.name!r} holds {held}; at least {'2' if line else '2 x 2'} heights are needed", key)
    if values.dtype.kind not in "iuf":
        raise CaseError(f"{file.name!r} holds values of type {values.dtype}; real numbers are needed", key)
    checked: DoubleArray = np.array(values, np.float64, order="C")
    checked[~np.isfinite(checked)] = np.nan
    _require_heights(checked, file, key)
    return checked


def _require_heights(values: DoubleArray, file: Path, key: KeyPath) -> None:
    """Refuse a map of lost points alone."""
    if np.isnan(values).all():
        raise CaseError(f"{file.name!r} holds no finite height; at least one is needed", key)


def _require_plausible(values: DoubleArray, spacing: Sequence[float], source: HeightsSurface, key: KeyPath) -> None:
    """Refuse heights (mm) that no case may have, that the case contradicts, or that range over more than the map."""
    name, place = source.file.name, (*key, "file")
    largest, least = float(np.nanmax(values)), float(np.nanmin(values))
    if max(largest, -least) > LARGEST_MAGNITUDE:
        message = (
            f"{name!r} holds a height of {max(largest, -least):.2g} mm, at most {LARGEST_MAGNITUDE:g} mm is possible"
        )
        raise CaseError(f"{message}; write nan for missing points", place)
    found, span = largest - least, max((n - 1) * step for n, step in zip(values.shape, spacing, strict=True))
    if source.height_range is not None:
        if abs(found - source.height_range) > AGREEMENT * source.height_range:
            raise CaseError(
                f"the heights in {name!r} range over {_length(found)}, not over {_length(source.height_range)}; check"
                " unit, and lost points that stand as numbers",
                (*key, "height_range"),
            )
    elif found > span and not source.override:
        raise CaseError(
            f"the heights in {name!r} range over {_length(found)} on a map of {_length(span)}; give their unit,"
            " or lost where lost points stand as numbers, or override: true if that is so",
            (*key, "unit"),
        )
