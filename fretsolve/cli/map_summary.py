"""A measured map in words, for ``fretsolve surface`` and ``fretsolve validate``."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fretsolve.case.dimensions import counted, in_small_unit
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_measures import MapMeasures
from fretsolve.problem.surface.map_steps import holes
from fretsolve.system.arrays import DoubleArray

ROUND_OFF = 1e-9
"""Share of the range of a map below which a tilt or the mean of a side counts as 0."""


def map_lines(height_map: HeightMap, found: MapMeasures, cell: float | None = None) -> Iterator[str]:
    """Yield what reading and preparing a map found and did, its size and roughness, and which side is where.

    found: the measures of the map; cell: longer side of the grid's cells (mm), against which the shortest wave is held.
    """
    yield from _size_lines(height_map)
    is_profile = height_map.values.shape[1] == 1
    count = 1 if is_profile else 2
    extent, sa, sq = (in_small_unit(value, 4) for value in (found.height_range, found.sa, found.sq))
    letter, form = ("P", "line") if is_profile else ("S", "plane")  # ISO 21920 and 25178
    yield f"range {extent}, {letter}a {sa}, {letter}q {sq} (less a {form}), {letter}dq {found.sdq:.4g}"
    # what is next to nothing against the range is round-off
    tilts = [
        f"{tilt if abs(tilt * side) > ROUND_OFF * found.height_range else 0.0:.3g} along {name}"
        for name, tilt, side in zip("xy", found.tilts, found.span, strict=False)
    ]
    radius = "no curvature" if math.isinf(found.radius) else f"radius of the best sphere {found.radius:.4g} mm"
    yield f"tilt {' and '.join(tilts[:count])}; {radius}"
    if math.isfinite(found.shortest_wave):
        in_points = found.shortest_wave / max(found.spacing[:count])
        in_cells = "" if cell is None else f", {found.shortest_wave / cell:.3g} cells of the grid"
        yield f"shortest wave {in_small_unit(found.shortest_wave, 3)}, {in_points:.3g} points of the map{in_cells}"
    sides = (f"{name}: {in_small_unit(mean, 3)}" for name, mean in _sides(height_map.values, about_mean=True))
    yield f"mean separation by sides: {'; '.join(sides)}"


def value_lines(value_map: HeightMap) -> Iterator[str]:
    """Yield the size of a map of plain numbers, their range, and which side is where."""
    yield from _size_lines(value_map)
    yield f"values from {np.nanmin(value_map.values):.4g} to {np.nanmax(value_map.values):.4g}"
    sides = (f"{name}: {mean:.4g}" for name, mean in _sides(value_map.values, about_mean=False))
    yield f"mean value by sides: {'; '.join(sides)}"


def _size_lines(height_map: HeightMap) -> Iterator[str]:
    """Yield what the reader found and the steps did, points, spacing and span, and the lost points."""
    yield from height_map.remarks
    values, count = height_map.values, min(height_map.values.shape[1], 2)
    points = " x ".join(map(str, values.shape[:count]))
    spacing, span = (
        " x ".join(in_small_unit(length, 4) for length in lengths[:count])
        for lengths in (height_map.spacing, height_map.span)
    )
    yield f"{points} points, spacing {spacing}, span {span}"
    lost = int(np.count_nonzero(np.isnan(values)))
    if lost:
        _, inside, at_rim = holes(height_map)
        yield f"{counted(lost, 'lost point')} in {counted(inside, 'hole')} inside and {at_rim} at the rim"


def _sides(values: DoubleArray, *, about_mean: bool) -> Iterator[tuple[str, float]]:
    """Yield the names of the sides of a map with the means there, about the mean of the map if asked."""
    if about_mean:
        values = values - np.nanmean(values)
    least = ROUND_OFF * float(np.nanmax(np.abs(values)))
    names = ("left, x < 0", "right, x > 0"), ("bottom, y < 0", "top, y > 0")
    for axis in range(min(values.shape[1], 2)):
        half = range(values.shape[axis] // 2)
        parts = np.take(values, half, axis), np.take(np.flip(values, axis), half, axis)
        for name, part in zip(names[axis], parts, strict=True):
            if np.isfinite(part).any():
                mean = float(np.nanmean(part))
                yield name, mean if abs(mean) > least else 0.0
