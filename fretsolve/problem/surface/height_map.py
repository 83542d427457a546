"""A measured height map in mm, and its value on a grid.

Interpolation is bilinear. Measured maps are rough and have holes; a spline would overshoot and carry the effect of a
hole or a step across the map. It is exact at the points of the map; between them it lies above a paraboloid of radius R
by up to spacing^2/8R per direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.system.arrays import BoolArray, DoubleArray

SNAP = 1e-6
"""Slack for rounding, in spacings, at the border of the map and at the reach of a hole."""


@dataclass(frozen=True)
class HeightMap:
    """Separation `values` (mx, my) in mm, NaN in holes, at points `spacing` (mm) apart about the origin.

    mean: whether a cell takes the mean over its area, and not the height at its centre; remarks: what was found and
    done on the way here, for users.
    """

    values: DoubleArray
    spacing: tuple[float, float]
    mean: bool = False
    remarks: tuple[str, ...] = ()

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
