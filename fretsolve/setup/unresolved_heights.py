"""Height maps that are finer than the cells: the slopes that the cells miss, and the points that would see them.

A cell takes the height at its centre, so waves of less than some cells are lost, or appear as longer ones. Of a wave of
length w, points h apart see the share sin(pi h/w) / (pi h/w) of its slope. What is missed matters by the pressure that
would flatten it, E* s/2 for waves of the root mean square slope s (Johnson, Contact Mechanics, section 13.2).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.surface_specs import Surface
from fretsolve.model.height_map import HeightMap
from fretsolve.model.surface import height_maps
from fretsolve.system.arrays import DoubleArray

LEAST_GROWTH = 3.3
"""Waves are resolved if cells twice as long miss this many times the mean square slope, or more: 4 for long waves, 3.3
for waves of 4.4 cells, 1 where all is missed. Tilts and smooth forms do not count."""

ADVISED_GROWTH = 3.75
"""The same for the points that are advised and picked: waves of 8 cells."""

LARGEST_FLATTENING, LOAD_UNKNOWN = 0.01, 1e-4
"""Flattening pressure, over the mean pressure on the grid's area, up to which it does not matter; and what stands for
that mean pressure, over E*, where no force is imposed."""

PROFILES = 128
"""Profiles along each axis that a map's slopes are taken from."""

MOST_POINTS = 2048
"""Points per side that an accuracy takes for the sake of a height map, at most."""

Pair = tuple[float, float]


@dataclass(frozen=True)
class HeightProfiles:
    """Profiles of a height map on a grid's area.

    along: x and y, arrays (points, profiles) in mm, NaN in holes; spacing: of the points, mm.
    """

    along: tuple[DoubleArray, DoubleArray]
    spacing: Pair

    def slope(self, axis: int) -> float:
        """Return the root mean square slope between neighbours along `axis`, 0 if no neighbours are known."""
        slopes = np.diff(self.along[axis], axis=0) / self.spacing[axis]
        known = slopes[np.isfinite(slopes)]
        return float(np.sqrt(np.mean(known**2))) if known.size else 0.0

    def _missed(self, axis: int, between: int) -> float:
        """Return the mean square slope that points `between` points apart miss: its variance between them."""
        heights = self.along[axis] / self.spacing[axis]
        if between < 2 or len(heights) <= between:
            return 0.0
        slopes = np.diff(heights, axis=0)
        known = np.isfinite(slopes)
        squares, counts = (_sums(part, between) for part in (np.where(known, slopes, 0.0) ** 2, known.astype(float)))
        seen = (heights[between:] - heights[:-between]) / between
        whole = counts == between
        return float(np.mean(squares[whole] / between - seen[whole] ** 2)) if whole.any() else 0.0

    def unresolved(self, axis: int, side: float, negligible: float, growth: float) -> float:
        """Return the mean square slope along `axis` that cells of `side` (mm) miss, 0 if they resolve the waves.

        They do if they miss up to `negligible`, or if cells twice as long miss `growth` times as much.
        """
        between = round(side / self.spacing[axis])
        missed = self._missed(axis, between)
        if missed <= negligible or len(self.along[axis]) <= 2 * between:
            return 0.0
        return 0.0 if self._missed(axis, 2 * between) >= growth * missed else missed


@dataclass(frozen=True)
class HeightMaps:
    """All height maps of a case on the area of a grid, by their profiles.

    contact_modulus: E*; load: the pressure (MPa) that flattening pressures are measured against.
    """

    maps: tuple[HeightProfiles, ...]
    contact_modulus: float
    load: float

    @classmethod
    def of(
        cls,
        surfaces: Sequence[Surface],
        center: Pair,
        size: Pair,
        loads: Sequence[Mapping[str, float]],
        contact_modulus: float,
    ) -> HeightMaps:
        """Read the maps; loads: imposed at the ends of stages. Raises FileError or CaseError for a wrong map."""
        found = tuple(_profiles(height_map, place, center, size) for place, height_map in height_maps(surfaces))
        forces = [load["P"] / math.prod(size) for load in loads if "P" in load]
        return cls(found, contact_modulus, max(forces, default=LOAD_UNKNOWN * contact_modulus))

    def slope(self) -> float:
        """Return the largest root mean square slope of a map along an axis, on the grid's area."""
        return max((one.slope(axis) for one in self.maps for axis in (0, 1)), default=0.0)

    def flattening_pressure(self, cell: Pair) -> float:
        """Return the root mean square pressure (MPa) that would flatten what cells of sides `cell` miss.

        0 where they resolve the waves, since coarse runs show the rest, or where it does not matter.
        """
        missed = [
            one.unresolved(axis, side, self._negligible, LEAST_GROWTH)
            for one in self.maps
            for axis, side in enumerate(cell)
        ]
        return 0.5 * self.contact_modulus * math.sqrt(math.fsum(missed))

    def resolving_points(self, size: Pair, points: tuple[int, int]) -> tuple[int, int]:
        """Return the points along x and y, at least `points`, with which cells on `size` (mm) resolve all waves."""
        nx, ny = points
        for one in self.maps:
            nx, ny = self._points(one, 0, size[0], nx), self._points(one, 1, size[1], ny)
        return nx, ny

    def _points(self, one: HeightProfiles, axis: int, size: float, least: int) -> int:
        """Return the least points along an axis by bisection, up to those of the map itself."""
        low, high = least, max(least, math.ceil(size / one.spacing[axis]))
        while low < high:
            middle = (low + high) // 2
            if one.unresolved(axis, size / middle, self._negligible, ADVISED_GROWTH):
                low = middle + 1
            else:
                high = middle
        return low

    @property
    def _negligible(self) -> float:
        """Mean square slope whose flattening does not matter."""
        return (2.0 * LARGEST_FLATTENING * self.load / self.contact_modulus) ** 2


def _profiles(height_map: HeightMap, place: Pair, center: Pair, size: Pair) -> HeightProfiles:
    """Return profiles of a map that is centred at `place`."""
    cut = []
    for axis in (0, 1):
        count, step = height_map.values.shape[axis], height_map.spacing[axis]
        middle = (center[axis] - place[axis]) / step + 0.5 * (count - 1)
        reach = 0.5 * size[axis] / step
        cut.append(slice(max(math.floor(middle - reach), 0), max(math.ceil(middle + reach) + 1, 0)))
    part = height_map.values[cut[0], cut[1]]
    nx, ny = part.shape
    along_x, along_y = part[:, :: max(ny // PROFILES, 1)], part[:: max(nx // PROFILES, 1)].T
    return HeightProfiles((along_x.copy(), along_y.copy()), height_map.spacing)


def _sums(values: DoubleArray, count: int) -> DoubleArray:
    """Return the sums of `count` neighbours along the first axis."""
    total = np.cumsum(np.vstack([np.zeros_like(values[:1]), values]), axis=0)
    sums: DoubleArray = total[count:] - total[:-count]
    return sums
