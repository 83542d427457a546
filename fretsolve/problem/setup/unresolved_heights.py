"""Rough surfaces that are finer than the cells: the slopes that the cells miss, and the points that would see them.

A cell takes the height at its centre, so waves of less than some cells are lost, or appear as longer ones. Of a wave of
length w, points h apart see the share sin(pi h/w) / (pi h/w) of its slope. What is missed matters by the pressure that
would flatten it, E* s/2 for waves of the root mean square slope s (Johnson, Contact Mechanics, section 13.2). Waves of
the map near its own spacing are missed as well: between its points they count as smooth.

Between the points of a map lie facets. Where they meet at a ridge of the angle t, in contact, the pressure is
E* t/2 pi ln(2 a/x) at the distance x (a wedge, Johnson, section 5.2), which cells that are shorter than a facet show
the better the shorter they are.

The shortest wave of a surface by its spectrum is known, and its heights between any points. It is judged by points that
resolve this wave.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.body_specs import RoughnessSurface, Surface
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.separation import height_maps
from fretsolve.system.arrays import DoubleArray

LEAST_GROWTH = 3.3
"""Waves are resolved if cells twice as long miss this many times the mean square slope, or more: 4 for long waves, 3.3
for waves of 4.4 cells, 1 where all is missed. Tilts and smooth forms do not count."""

ADVISED_GROWTH = 3.75
"""The same for the points that are advised and picked: waves of 8 cells."""

FACET_CELLS, ADVISED_FACET_CELLS = 2.2, 2.5
"""Cells per spacing that resolve any map: 4.4 for its shortest wave, of two spacings. Those that are advised."""

CELLS_PER_WAVE, MOST_PROFILE_POINTS = 10.0, 4096
"""Cells in the shortest wave, where it is known, that resolve it: they see 98 % of its slope. Its profiles have as many
points in it, up to so many in all."""

LARGEST_FLATTENING, LOAD_UNKNOWN = 0.01, 1e-4
"""Flattening pressure, over the mean pressure on the grid's area, up to which it does not matter; and what stands for
that mean pressure, over E*, where no force is imposed."""

RIDGE = math.log(16.0)
"""Excess of a ridge's pressure over the cells' pressure, in parts of E* t/2 pi: the pressure of cells a sixteenth as
long. The pressure of a ridge has no limit, but facets are no real ridges either."""

Pair = tuple[float, float]


@dataclass(frozen=True)
class HeightProfiles:
    """Profiles of a height map, or of a rough surface by its spectrum, on a grid's area.

    along: x and y, arrays (points, profiles) in mm, NaN in holes; spacing: of the points, mm; shortest: the shortest
    wave (mm) of a spectrum, 0 of a map.
    """

    along: tuple[DoubleArray, DoubleArray]
    spacing: Pair
    shortest: float = 0.0

    def slope(self, axis: int) -> float:
        """Return the root mean square slope between neighbours along `axis`, 0 if no neighbours are known."""
        slopes = np.diff(self.along[axis], axis=0) / self.spacing[axis]
        known = slopes[np.isfinite(slopes)]
        return float(np.sqrt(np.mean(known**2))) if known.size else 0.0

    def unresolved(self, axis: int, side: float, negligible: float, *, advised: bool = False) -> float:
        """Return the mean square slope along `axis` that cells of `side` (mm) miss, 0 if they resolve the waves.

        They do if they miss up to `negligible`, if cells twice as long miss much more, or if no wave of the map is
        shorter than some cells. advised: whether the cells are to be advised, which takes more of them.
        """
        growth, facet_cells = (ADVISED_GROWTH, ADVISED_FACET_CELLS) if advised else (LEAST_GROWTH, FACET_CELLS)
        if facet_cells * side <= self.spacing[axis]:
            return 0.0
        finer = math.ceil(8 * self.spacing[axis] / side)  # at least 8 points of a profile per cell
        spacing, between = self.spacing[axis] / finer, round(finer * side / self.spacing[axis])
        heights = _refined(self.along[axis], finer) / spacing
        missed = _missed(heights, between)
        if missed <= negligible or len(heights) <= 2 * between:
            return 0.0
        if self.shortest:
            return 0.0 if self.shortest >= CELLS_PER_WAVE * side * (1.0 - 1e-9) else missed
        return 0.0 if _missed(heights, 2 * between) >= growth * missed else missed

    def ridge(self, axis: int, side: float) -> float:
        """Return the largest angle (rad) of a ridge along `axis` between facets longer than cells of `side` (mm)."""
        if self.spacing[axis] <= side or self.shortest:
            return 0.0
        angles = np.diff(self.along[axis], 2, axis=0) / self.spacing[axis]
        return float(np.max(angles, where=np.isfinite(angles), initial=0.0))

    def most_points(self, axis: int, size: float) -> int:
        """Return the points on `size` (mm) that resolve any wave of the map."""
        if self.shortest:
            return math.ceil(CELLS_PER_WAVE * size / self.shortest - 1e-9)
        return math.ceil(ADVISED_FACET_CELLS * size / self.spacing[axis])


@dataclass(frozen=True)
class HeightMaps:
    """All height maps and rough surfaces of a case on the area of a grid, by their profiles.

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
        found = [_profiles(height_map, place, center, size) for place, height_map in height_maps(surfaces)]
        found += [_profiles_of_waves(one, center, size) for one in surfaces if one.kind == "roughness"]
        forces = [load["P"] / math.prod(size) for load in loads if "P" in load]
        return cls(tuple(found), contact_modulus, max(forces, default=LOAD_UNKNOWN * contact_modulus))

    def slope(self) -> float:
        """Return the largest root mean square slope of a map along an axis, on the grid's area."""
        return max((one.slope(axis) for one in self.maps for axis in (0, 1)), default=0.0)

    def flattening_pressure(self, cell: Pair) -> float:
        """Return the root mean square pressure (MPa) that would flatten what cells of sides `cell` miss.

        0 where they resolve the waves, since coarse runs show the rest, or where it does not matter.
        """
        missed = [one.unresolved(axis, side, self._negligible) for one in self.maps for axis, side in enumerate(cell)]
        return 0.5 * self.contact_modulus * math.sqrt(math.fsum(missed))

    def ridge_pressure(self, cell: Pair) -> float:
        """Return by how much (MPa) ridges between facets may exceed the pressure of cells of sides `cell`."""
        angles = [math.hypot(*(one.ridge(axis, side) for axis, side in enumerate(cell))) for one in self.maps]
        return RIDGE * self.contact_modulus * sum(angles) / (2.0 * math.pi)

    def too_coarse(self) -> bool:
        """Return whether a map has waves near its own spacing: cells as long as the spacing would miss them."""
        return any(one.unresolved(axis, one.spacing[axis], self._negligible) for one in self.maps for axis in (0, 1))

    def resolving_points(self, size: Pair, points: tuple[int, int]) -> tuple[int, int]:
        """Return the points along x and y, at least `points`, with which cells on `size` (mm) resolve all waves."""
        nx, ny = points
        for one in self.maps:
            nx, ny = self._points(one, 0, size[0], nx), self._points(one, 1, size[1], ny)
        return nx, ny

    def _points(self, one: HeightProfiles, axis: int, size: float, least: int) -> int:
        """Return the least points along an axis by bisection."""
        low, high = least, max(least, one.most_points(axis, size))
        while low < high:
            middle = (low + high) // 2
            if one.unresolved(axis, size / middle, self._negligible, advised=True):
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
    along_x, along_y = part[:, :: max(ny // 128, 1)], part[:: max(nx // 128, 1)].T  # about 128 profiles along each
    return HeightProfiles((along_x.copy(), along_y.copy()), height_map.spacing)


def _profiles_of_waves(surface: RoughnessSurface, center: Pair, size: Pair) -> HeightProfiles:
    """Return profiles of a rough surface by its spectrum, along x and, unless it is of a line contact, along y."""
    from fretsolve.problem.surface.roughness import waves_of  # few cases have one

    waves, spacing = waves_of(surface), surface.cutoff / CELLS_PER_WAVE
    place = center[0] - surface.center[0], center[1] - surface.center[1]
    reach = [0.5 * min(side, surface.period, MOST_PROFILE_POINTS * spacing) for side in size]
    long = [middle + np.arange(-half, half, spacing) for middle, half in zip(place, reach, strict=True)]
    few = [middle + np.linspace(-half, half, 64) for middle, half in zip(place, reach, strict=True)]
    if surface.of_line:
        along = waves.heights(long[0], np.zeros(1)), np.zeros((1, 1))
    else:
        along = waves.heights(long[0], few[1]), waves.heights(few[0], long[1]).T
    return HeightProfiles(along, (spacing, spacing), surface.cutoff)


def _missed(heights: DoubleArray, between: int) -> float:
    """Return the mean square slope that points `between` points apart miss: its variance between them.

    heights: profiles (points, profiles) over their spacing.
    """
    if len(heights) <= between:
        return 0.0
    slopes = np.diff(heights, axis=0)
    known = np.isfinite(slopes)
    squares, counts = (_sums(part, between) for part in (np.where(known, slopes, 0.0) ** 2, known.astype(float)))
    seen = (heights[between:] - heights[:-between]) / between
    whole = counts == between
    return float(np.mean(squares[whole] / between - seen[whole] ** 2)) if whole.any() else 0.0


def _refined(heights: DoubleArray, finer: int) -> DoubleArray:
    """Return profiles with `finer` times the points, by cubics with the slopes between neighbours (Catmull-Rom).

    Straight lines between the points would have slopes that no cells resolve. Finer profiles are fewer.
    """
    if finer == 1 or len(heights) < 4:
        return heights
    few = heights[:, ::finer]
    before, start, end, after = (few[place : len(few) - 3 + place] for place in range(4))
    part = (np.arange(finer) / finer)[:, None]
    cubic, square = 3.0 * (start - end) + after - before, 2.0 * before - 5.0 * start + 4.0 * end - after
    curved = part * (0.5 * (end - before)[:, None] + 0.5 * part * (square[:, None] + part * cubic[:, None]))
    return np.vstack([(start[:, None] + curved).reshape(-1, few.shape[1]), end[-1:]])


def _sums(values: DoubleArray, count: int) -> DoubleArray:
    """Return the sums of `count` neighbours along the first axis."""
    total = np.cumsum(np.vstack([np.zeros_like(values[:1]), values]), axis=0)
    sums: DoubleArray = total[count:] - total[:-count]
    return sums
