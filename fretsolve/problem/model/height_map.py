"""Measured height maps: reading them from a file, and interpolating them onto the cell centres of a grid.

Files are HDF5 (``.h5``, ``.hdf5``, ``.hdf``), NumPy (``.npy``, ``.npz``) or text (``.txt``, ``.csv``, ``.dat``,
``.xyz``: numbers separated by white space, commas or semicolons; ``#`` begins a comment). The first index, in text the
row, runs along x, the second along y. Text of three columns that lists every point x, y, z of a regular grid once is
read as such points, all three in the unit of the heights. The case gives the spacing, or else the points do, or the
attributes `spacing`, or `dx` and `dy`, of an HDF5 dataset (mm). The map is centred on the surface's centre. Values that
are not finite are holes.

Interpolation is bilinear. Measured maps are rough and have holes; a spline would overshoot and carry the effect of a
hole or a step across the map. It is exact at the points of the map; between them it lies above a paraboloid of radius R
by up to spacing^2/8R per direction.
"""

from __future__ import annotations

import itertools
import math
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.keys.body_specs import HDF5_SUFFIXES, HeightsSurface
from fretsolve.case.quantities import LARGEST_MAGNITUDE, LEAST_MAGNITUDE, QuantityError, to_internal
from fretsolve.errors import CaseError, FileError, FretsolveError, KeyPath, shortened
from fretsolve.system.arrays import BoolArray, DoubleArray
from fretsolve.system.files import require_regular
from fretsolve.system.hdf5_files import LARGEST_RATIO, dataset_names, open_hdf5, own_dataset, try_attributes

NUMPY_SUFFIXES = (".npy", ".npz")
TEXT_SUFFIXES = (".txt", ".csv", ".dat", ".xyz")

LONGEST_LINE, MOST_HEIGHTS = 2**24, 2**26
"""Characters of a line, and heights of a map: 8192 x 8192."""

MOST_BYTES = 16 * MOST_HEIGHTS
"""Bytes of the heights as they are stored."""

SNAP = 1e-6
"""Slack for rounding, in spacings, at the border of the map and at the reach of a hole."""


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
    return result


@dataclass(frozen=True)
class HeightMap:
    """Separation `values` (mx, my) in mm, NaN in holes, at points `spacing` (mm) apart about the origin."""

    values: DoubleArray
    spacing: tuple[float, float]

    @property
    def span(self) -> tuple[float, float]:
        """Distances between the outermost points (mm)."""
        mx, my = self.values.shape
        return (mx - 1) * self.spacing[0], (my - 1) * self.spacing[1]

    def sample(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Return the separation (nx, ny) at ascending `x` (nx,), `y` (ny,) in mm, +inf off the map and around holes."""
        from scipy.ndimage import map_coordinates

        (u, rows), (v, columns) = self._coordinates(x, 0), self._coordinates(y, 1)
        points, holes = np.array(np.meshgrid(u, v, indexing="ij")), ~np.isfinite(self.values)
        heights = map_coordinates(np.where(holes, 0.0, self.values), points, order=1, mode="nearest")
        if holes.any():
            heights[map_coordinates(holes.astype(np.float64), points, order=1, mode="nearest") > SNAP] = np.inf
        result = np.full((x.size, y.size), np.inf)
        result[rows, columns] = heights
        return result

    def border(self, x: DoubleArray, y: DoubleArray) -> BoolArray:
        """Return the cells (nx, ny) at `x` (nx,), `y` (ny,) that are the last before the map ends within the grid."""
        from scipy.ndimage import binary_erosion

        on_map = np.zeros((x.size, y.size), dtype=bool)
        on_map[self._coordinates(x, 0)[1], self._coordinates(y, 1)[1]] = True
        inner: BoolArray = binary_erosion(on_map, border_value=1)  # beyond the grid counts as on the map
        return on_map & ~inner

    def _coordinates(self, positions: DoubleArray, axis: int) -> tuple[DoubleArray, slice]:
        """Return the `positions` that lie on the map, in spacings from its first point, and which ones they are."""
        last = self.values.shape[axis] - 1
        index = positions / self.spacing[axis] + last / 2
        there = slice(*np.searchsorted(index, [-SNAP, last + SNAP]))
        return np.clip(index[there], 0.0, last), there


def load_height_map(source: HeightsSurface, key: KeyPath) -> HeightMap:
    """Read the height map `source`, whose place in the case is `key`.

    Raises FileError if the file is missing or cannot be read, and CaseError (at `key` or below) if it does not hold a
    map: wrong dimensions, no such dataset, no spacing, no finite value.
    """
    file, suffix = source.file, source.file.suffix.lower()
    try:
        require_regular(file, 2**30 if suffix in TEXT_SUFFIXES else 2**33)
        if suffix in HDF5_SUFFIXES:
            content = _read_hdf5(file, source.dataset, (*key, "dataset"))
        elif suffix in NUMPY_SUFFIXES:
            content = _read_numpy(file, source.dataset, (*key, "dataset"))
        elif suffix in TEXT_SUFFIXES:
            content = _read_text(file, source.unit)
        else:
            known = ", ".join(HDF5_SUFFIXES + NUMPY_SUFFIXES + TEXT_SUFFIXES)
            raise CaseError(f"{file.name!r} has an unknown ending; one of {known} is needed", (*key, "file"))
    except FretsolveError:
        raise
    except Exception as error:  # whatever the libraries raise on a damaged file
        reason = (isinstance(error, OSError) and error.strerror) or shortened(str(error)) or type(error).__name__
        raise FileError(f"the height map cannot be read: {reason}", file) from error
    _require_unit(content.units, source, (*key, "unit"))
    values = _as_columns(content.values, source, (*key, "file"))
    values = _checked(values, file, (*key, "file"))
    _require_possible(values, source, (*key, "file"))
    values *= -source.unit if source.invert else source.unit
    return HeightMap(values, _spacing(source, content, (*key, "spacing")))


@dataclass(frozen=True)
class _Content:
    """The array in a file, as it is there, with the spacing (mm) and units if the file gives them."""

    values: NDArray[Any]
    spacing: tuple[float, ...] | None = None
    units: str = ""


def _require_unit(units: str, source: HeightsSurface, key: KeyPath) -> None:
    """Refuse a map whose file states another unit of length than the case; ignore texts that are not such a unit."""
    try:
        stated = to_internal(units, LENGTH, bare_unit=True)
    except QuantityError:
        return
    if not math.isclose(stated, source.unit, rel_tol=1e-9):
        raise CaseError(
            f"the heights in {source.file.name!r} are in {units}, but the case gives their unit as {source.unit:g} mm;"
            f" unit: {units} would be right",
            key,
        )


def _as_columns(values: NDArray[Any], source: HeightsSurface, key: KeyPath) -> NDArray[Any]:
    """Return the one column of a line contact's profile twice, as a map that is the same along y; other maps as is."""
    if not source.of_line:
        return values
    column = values if values.ndim == 1 else values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else None
    if column is None:
        shape = " x ".join(map(str, values.shape)) or "scalar"
        raise CaseError(f"{source.file.name!r} holds a {shape} array; plane: strain takes one column of heights", key)
    return np.stack([column, column], axis=1)


def _checked(values: NDArray[Any], file: Path, key: KeyPath) -> DoubleArray:
    """Return `values` as floats, NaN where not finite."""
    if values.ndim != 2 or min(values.shape) < 2:
        shape = " x ".join(map(str, values.shape)) or "scalar"
        held = f"{values.size} values in a row" if values.ndim == 1 else f"a {shape} array"
        raise CaseError(f"{file.name!r} holds {held}; at least 2 x 2 heights are needed", key)
    if values.dtype.kind not in "iuf":
        raise CaseError(f"{file.name!r} holds values of type {values.dtype}; real numbers are needed", key)
    checked = values.astype(np.float64, copy=not values.flags.writeable)  # a second copy of a large map may not fit
    finite = np.isfinite(checked)
    if not finite.any():
        raise CaseError(f"{file.name!r} holds no finite height; at least one is needed", key)
    checked[~finite] = np.nan
    return checked


def _require_possible(values: DoubleArray, source: HeightsSurface, key: KeyPath) -> None:
    """Refuse heights beyond the lengths that a case may have. Programs write such numbers for missing points."""
    largest = float(max(np.nanmax(values), -np.nanmin(values))) * source.unit
    if largest > LARGEST_MAGNITUDE:
        message = (
            f"{source.file.name!r} holds a height of {largest:.2g} mm, at most {LARGEST_MAGNITUDE:g} mm is possible"
        )
        raise CaseError(f"{message}; write nan for missing points", key)


def _spacing(source: HeightsSurface, content: _Content, key: KeyPath) -> tuple[float, float]:
    """Return the case's spacing (mm), or else the file's spacing."""
    if source.spacing is not None:
        return source.spacing
    example = "give that of the map's points, such as [1 um, 1 um]"
    if content.spacing is None:
        raise CaseError(f"spacing is missing, and {source.file.name!r} has none; {example}", key)
    pair = content.spacing * 2 if len(content.spacing) == 1 else content.spacing
    if len(pair) != 2 or not all(LEAST_MAGNITUDE <= step <= LARGEST_MAGNITUDE for step in pair):
        raise CaseError(f"the spacing in {source.file.name!r} is {list(content.spacing)}; {example}", key)
    return pair[0], pair[1]


def _read_hdf5(file: Path, dataset: str | None, key: KeyPath) -> _Content:
    """Read a dataset, with the spacing from its attributes `spacing`, or `dx` and `dy` (mm)."""
    try_attributes(file)
    with open_hdf5(file) as stored:
        name = _chosen(dataset and dataset.strip("/"), dataset_names(stored), file, key)
        node = own_dataset(stored, name)
        _require_plausible(node.shape, node.dtype)
        separate = [node.attrs[name] for name in ("dx", "dy") if name in node.attrs]
        spacing = tuple(float(step) for step in np.ravel(node.attrs.get("spacing", separate)))
        units = node.attrs.get("units", "")
        return _Content(np.asarray(node[()]), spacing or None, units if isinstance(units, str) else "")


def _require_plausible(shape: Sequence[int], dtype: np.dtype[Any]) -> None:
    """Raise ValueError for more heights than a map has."""
    if math.prod(shape) > MOST_HEIGHTS or math.prod(shape) * dtype.itemsize > MOST_BYTES:
        sides = " x ".join(map(str, shape))
        raise ValueError(f"it has {sides} heights, at most {MOST_HEIGHTS} in all are read; give a part of it")


def _read_numpy(file: Path, dataset: str | None, key: KeyPath) -> _Content:
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
    return _Content(values)


def _read_text(file: Path, unit: float) -> _Content:
    """Read a matrix, or points x, y, z (all in `unit`) of a regular grid."""
    try:
        with file.open(encoding="utf-8-sig") as text:
            lines = _lines_of(text)
            first = next((line for line in lines if line.split("#")[0].strip()), None)
            if first is None:
                raise ValueError("it holds no numbers")
            numbers = first.split("#")[0]
            delimiter = next((mark for mark in ",;" if mark in numbers), None)
            rows = MOST_HEIGHTS // len(numbers.split(delimiter))
            values = np.loadtxt(_at_most(rows, itertools.chain([first], lines)), delimiter=delimiter, ndmin=2)
    except UnicodeDecodeError as error:
        raise ValueError(f"{error.object[error.start : error.start + 1]!r} in it is not UTF-8 text") from None
    return _gridded(values, unit) or _Content(values)


def _lines_of(text: TextIO) -> Iterator[str]:
    """Yield the lines of a file. Raises ValueError at one that is too long for the memory that reading it takes."""
    while line := text.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise ValueError(f"a line of it has more than {LONGEST_LINE} characters")
        yield line


def _at_most(rows: int, lines: Iterable[str]) -> Iterator[str]:
    """Yield up to so many `lines`; raises ValueError if there are more."""
    for number, line in enumerate(lines):
        if number >= rows:
            raise ValueError(f"it has more than {MOST_HEIGHTS} heights; give a part of it")
        yield line


def _gridded(points: DoubleArray, unit: float) -> _Content | None:
    """Return the map whose points x, y, z the rows list in any order; None if they are not a regular grid."""
    if points.shape[1] != 3:
        return None
    x, column = np.unique(points[:, 0], return_inverse=True)
    y, row = np.unique(points[:, 1], return_inverse=True)
    if min(x.size, y.size) < 2 or x.size * y.size != len(points):
        return None
    values = np.full((x.size, y.size), np.inf)
    values[column, row] = points[:, 2]
    steps = [np.diff(axis) for axis in (x, y)]
    if np.isposinf(values).any() or any(np.ptp(step) > 1e-3 * step.mean() for step in steps):
        return None
    return _Content(values, tuple(float(step.mean()) * unit for step in steps))


def _chosen(dataset: str | None, names: list[str], file: Path, key: KeyPath) -> str:
    """Return the name of the dataset asked for, or of the only one."""
    if dataset is None and len(names) == 1:
        return names[0]
    if dataset in names:
        return dataset
    wanted = "dataset is missing" if dataset is None else f"there is no dataset {dataset!r} in {file.name!r}"
    raise CaseError(f"{wanted}; {file.name!r} has {', '.join(sorted(names)) or 'none'}", key)
