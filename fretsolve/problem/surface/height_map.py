"""A measured height map in mm, and its value on a grid.

Interpolation is bilinear. Measured maps are rough and have holes; a spline would overshoot and carry the effect of a
hole or a step across the map. It is exact at the points of the map; between them it lies above a paraboloid of radius R
by up to spacing^2/8R per direction.

A cell takes the height at its centre, or the exact mean of the bilinear surface over the cell. The mean is for cells
that are coarser than the waves of the map: single points would make long waves of short ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.system.arrays import BoolArray, DoubleArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

SNAP = 1e-6
"""Slack for rounding: at the border of the map in spacings, and at a hole as its weight in the height of a cell."""


@dataclass(frozen=True)
class HeightMap:
    """Separation `values` (mx, my) in mm, NaN in holes, at points `spacing` (mm) apart about the origin.

    mean: whether a cell takes the mean over its area, and not the height at its centre; remarks: what was found and
    done on the way here, for users; doubts: what they are warned of.
    """

    values: DoubleArray
    spacing: tuple[float, float]
    mean: bool = False
    remarks: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def span(self) -> tuple[float, float]:
        """Distances between the outermost points (mm)."""
        mx, my = self.values.shape
        return (mx - 1) * self.spacing[0], (my - 1) * self.spacing[1]

    def points(self, axis: int) -> DoubleArray:
        """Return the places (mm) of the points along an axis, about the middle of the map."""
        count: int = self.values.shape[axis]
        return np.asarray(self.spacing[axis] * (np.arange(count) - 0.5 * (count - 1)), np.float64)

    def without_holes(self) -> HeightMap:
        """Return a flat map of the same points without holes."""
        return replace(self, values=np.zeros_like(self.values))

    def sample(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Return the separation (nx, ny) in mm of cells at ascending `x` (nx,), `y` (ny,) in mm from the map's centre.

        It is +inf for cells that are not (with `mean`: not wholly) on the map, and for cells that touch the four facets
        around a lost point. With `mean` the cells lie side by side; a single one has no side, and takes no mean.
        """
        (along_x, rows), (along_y, columns) = self._weights(x, 0), self._weights(y, 1)
        known = np.isfinite(self.values)
        if known.all():
            heights = (along_x @ self.values) @ along_y.T
        else:
            share = (along_x @ known.astype(np.float64)) @ along_y.T
            heights = (along_x @ np.where(known, self.values, 0.0)) @ along_y.T
            whole = share >= 1.0 - SNAP
            heights = np.where(whole, heights / np.where(whole, share, 1.0), np.inf)
        result = np.full((x.size, y.size), np.inf)
        result[rows, columns] = heights
        return result

    def border(self, x: DoubleArray, y: DoubleArray) -> BoolArray:
        """Return the cells (nx, ny) at `x` (nx,), `y` (ny,) that are the last before the map ends within the grid."""
        from scipy.ndimage import binary_erosion

        on_map = np.zeros((x.size, y.size), dtype=bool)
        on_map[self._reaches(x, 0)[2], self._reaches(y, 1)[2]] = True
        inner: BoolArray = binary_erosion(on_map, border_value=1)  # beyond the grid counts as on the map
        return on_map & ~inner

    def _weights(self, positions: DoubleArray, axis: int) -> tuple[csr_array, slice]:
        """Return the weights (cells, points) of the map's points in the cells that lie on the map, and which these are.

        The surface is a sum of hats, one per point. The weight of a point is its hat's mean over the cell.
        """
        from scipy.sparse import csr_array

        start, end, there = self._reaches(positions, axis)
        count = self.values.shape[axis]
        first = np.floor(start).astype(np.intp)
        most = int(np.max(np.ceil(end) - first, initial=0)) + 1
        points = first[:, None] + np.arange(max(most, 2))
        from_start, from_end = start[:, None] - points, end[:, None] - points
        if positions.size > 1 and self.mean:
            weights = _hat_integral(from_end) - _hat_integral(from_start)
            weights /= weights.sum(axis=1, keepdims=True)
        else:
            weights = np.maximum(1.0 - np.abs(from_start), 0.0)
        rows = np.arange(0, weights.size + 1, weights.shape[1])
        entries = weights.ravel(), np.minimum(points, count - 1).ravel(), rows
        return csr_array(entries, shape=(len(weights), count)), there

    def _reaches(self, positions: DoubleArray, axis: int) -> tuple[DoubleArray, DoubleArray, slice]:
        """Return the ends of those cells at `positions` that lie on the map, and which cells these are.

        The ends count in spacings from the map's first point. Both are the cell's centre where no mean is taken.
        """
        last = self.values.shape[axis] - 1
        index = positions / self.spacing[axis] + last / 2
        half = 0.5 * (index[-1] - index[0]) / (index.size - 1) if self.mean and index.size > 1 else 0.0
        there = slice(*np.searchsorted(index, [half - SNAP, last - half + SNAP]))
        return np.clip(index[there] - half, 0.0, last), np.clip(index[there] + half, 0.0, last), there


def _hat_integral(end: DoubleArray) -> DoubleArray:
    """Return the integral of the hat 1 - |t| from its left foot, t = -1, to `end`."""
    clipped = np.clip(end, -1.0, 1.0)
    return 0.5 + clipped - 0.5 * clipped * np.abs(clipped)
