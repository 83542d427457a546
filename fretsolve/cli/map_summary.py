"""A measured map in words, for ``fretsolve surface`` and ``fretsolve validate``."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fretsolve.case.dimensions import counted, in_small_unit
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_measures import measures_of

ROUND_OFF = 1e-9
"""Share of the range of a map below which a tilt or the mean of a side counts as 0."""


def map_lines(height_map: HeightMap, cell: float | None = None) -> Iterator[str]:
    """Yield what reading and preparing a map found and did, its size and roughness, and which side is where.

    cell: longer side of the grid's cells (mm), against which the shortest wave is held.
    """
    yield from height_map.remarks
    found = measures_of(height_map)
    is_profile = height_map.values.shape[1] == 1
    count = 1 if is_profile else 2
    points, spacing, span = (
        " x ".join(texts[:count])
        for texts in (
            [f"{number}" for number in found.points],
            [in_small_unit(step, 4) for step in found.spacing],
            [in_small_unit(side, 4) for side in found.span],
        )
    )
    yield f"{points} points, spacing {spacing}, span {span}"
    extent, sa, sq = (in_small_unit(value, 4) for value in (found.height_range, found.sa, found.sq))
    yield f"range {extent}, Sa {sa}, Sq {sq} (less a plane), Sdq {found.sdq:.4g}"
    # what is next to nothing against the range is round-off
    tilts = [
        f"{tilt if abs(tilt * side) > ROUND_OFF * found.height_range else 0.0:.3g} along {name}"
        for name, tilt, side in zip("xy", found.tilts, found.span, strict=False)
    ]
    radius = "no curvature" if math.isinf(found.radius) else f"radius of the best sphere {found.radius:.4g} mm"
    yield f"tilt {' and '.join(tilts[:count])}; {radius}"
    if found.lost_points:
        count_of = f"{counted(found.holes_inside, 'hole')} inside and {found.holes_at_rim} at the rim"
        yield f"{counted(found.lost_points, 'lost point')} in {count_of}, where there is no material"
    if math.isfinite(found.shortest_wave):
        in_points = found.shortest_wave / max(found.spacing[:count])
        in_cells = "" if cell is None else f", {found.shortest_wave / cell:.3g} cells of the grid"
        yield f"shortest wave {in_small_unit(found.shortest_wave, 3)}, {in_points:.3g} points of the map{in_cells}"
    yield from _sides(height_map, count)


def _sides(height_map: HeightMap, count: int) -> Iterator[str]:
    """Yield the mean separation at each side of the map, less the mean of the map."""
    values = height_map.values - np.nanmean(height_map.values)
    least = ROUND_OFF * float(np.nanmax(np.abs(values)))
    sides = []
    for axis, names in enumerate((("left, x < 0", "right, x > 0"), ("bottom, y < 0", "top, y > 0"))[:count]):
        half = range(values.shape[axis] // 2)
        parts = np.take(values, half, axis), np.take(np.flip(values, axis), half, axis)
        for name, part in zip(names, parts, strict=True):
            if np.isfinite(part).any():
                mean = float(np.nanmean(part))
                sides.append(f"{name}: {in_small_unit(mean if abs(mean) > least else 0.0, 3)}")
    yield f"mean separation by sides: {'; '.join(sides)}"
