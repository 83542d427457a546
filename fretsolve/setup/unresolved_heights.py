"""Height maps that are finer than the cells: how much of their slopes the cells miss, and which cells would do.

A cell takes the height at its centre, so waves of less than some cells are lost, or appear as longer ones. Of a wave of
length w, cells of side h see the share sin(pi h/w) / (pi h/w) of its slope.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fretsolve.case.surface_specs import Surface
from fretsolve.model.grid import Grid
from fretsolve.model.height_map import HeightMap
from fretsolve.model.surface import height_maps
from fretsolve.system.arrays import DoubleArray

LARGEST_SHARE = 0.4
"""Share of a map's root mean square slope that cells may miss: that of a wave of 4.4 cells."""

FINER = 1.1
"""Factor between the cells that are tried one after another."""

Pair = tuple[float, float]


def flattening_pressure(surfaces: Sequence[Surface], grid: Grid, contact_modulus: float) -> float:
    """Return the root mean square pressure (MPa) that would flatten what the cells of `grid` miss of height maps.

    0 where they miss little. Waves of a root mean square slope s need E* s / 2 (Johnson, Contact Mechanics, 13.2).
    Raises FileError or CaseError where a map cannot be read.
    """
    missed = 0.0
    for place, height_map in height_maps(surfaces):
        part = _part(height_map, place, grid.center, grid.size)
        lost, too_much = _lost_slope(part, height_map.spacing, (grid.dx, grid.dy))
        missed += lost * too_much
    return 0.5 * contact_modulus * math.sqrt(missed)


def resolving_points(surfaces: Sequence[Surface], center: Pair, size: Pair, points: tuple[int, int]) -> tuple[int, int]:
    """Return the points along x and y, at least `points`, with which cells on `size` see the slopes of all maps."""
    nx, ny = points
    for place, height_map in height_maps(surfaces):
        part = _part(height_map, place, center, size)
        while _lost_slope(part, height_map.spacing, (size[0] / nx, size[1] / ny))[1]:
            nx, ny = math.ceil(FINER * nx), math.ceil(FINER * ny)
    return nx, ny


def _lost_slope(part: DoubleArray, spacing: Pair, cell: Pair) -> tuple[float, bool]:
    """Return the mean square slope that cells of sides `cell` miss, and whether it is too much of the whole."""
    whole, lost = _mean_squares(part, spacing, cell)
    return lost, lost > LARGEST_SHARE**2 * whole


def _part(height_map: HeightMap, place: Pair, center: Pair, size: Pair) -> DoubleArray:
    """Return the heights of a map, centred at `place`, on the area of a grid."""
    cut = []
    for axis in (0, 1):
        count, step = height_map.values.shape[axis], height_map.spacing[axis]
        middle = (center[axis] - place[axis]) / step + 0.5 * (count - 1)
        reach = 0.5 * size[axis] / step
        cut.append(slice(max(math.floor(middle - reach), 0), max(math.ceil(middle + reach) + 1, 0)))
    return height_map.values[cut[0], cut[1]]


def _mean_squares(part: DoubleArray, spacing: Pair, cell: Pair) -> Pair:
    """Return the mean square of the slopes of heights, and the part of it that cells of sides `cell` miss."""
    whole = lost = 0.0
    for axis, (step, side) in enumerate(zip(spacing, cell, strict=True)):
        heights = part if axis == 0 else part.T
        between = max(side / step, 1.0)
        if len(heights) < between + 2.0:
            continue
        own, seen = (_mean_square_slope(heights, count) / step**2 for count in (1.0, between))
        whole, lost = whole + own, lost + max(own - seen, 0.0)
    return whole, lost


def _mean_square_slope(heights: DoubleArray, between: float) -> float:
    """Return the mean square slope along the first axis, per point, of points `between` points apart."""
    low = math.floor(between)
    share = between - low
    ahead = heights[low:] if share == 0.0 else (1.0 - share) * heights[low:-1] + share * heights[low + 1 :]
    slopes = (ahead - heights[: len(ahead)]) / between
    known = np.isfinite(slopes)
    return float(np.mean(slopes[known] ** 2)) if known.any() else 0.0
