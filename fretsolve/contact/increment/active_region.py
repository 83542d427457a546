"""The active region: the part of the grid that an increment is solved on, which is the contact with a margin.

Convolutions of tractions inside the region need no cell outside, so a contact that covers a small part of the
grid costs a small part. The certificate is always computed on the whole grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import EllipsisType

import numpy as np

from fretsolve.elastic.fftw import fast_length, padded_length
from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import BoolArray

Span = tuple[int, int]

FEWEST_POINTS = 48
"""Grids with fewer points on both sides are solved as a whole: in parts they take 1.1 times as long."""

LEAST_SIDE = 16
"""Fewest cells of a side."""

FREE_CELLS = 2
"""Fewest free cells on each side, so that a contact may grow a little within an increment. With three mode I.3 takes
5 % longer on 48 x 48 points, and about as long on larger grids."""


@dataclass(frozen=True)
class ActiveRegion:
    """Cells ``rows[0] <= i < rows[1]``, ``columns[0] <= j < columns[1]`` of a grid."""

    rows: Span
    columns: Span

    @property
    def cells(self) -> tuple[EllipsisType, slice, slice]:
        """Index of the region in a field (nx, ny) or (2, nx, ny)."""
        return ..., slice(*self.rows), slice(*self.columns)

    @property
    def count(self) -> int:
        """Number of cells."""
        return (self.rows[1] - self.rows[0]) * (self.columns[1] - self.columns[0])

    def holds(self, contact: BoolArray) -> bool:
        """Return whether `contact` (on the whole grid) lies inside and touches no edge but the grid's."""
        (top, bottom), (left, right), (nx, ny) = self.rows, self.columns, contact.shape
        outside = contact.copy()
        outside[top + (top > 0) : bottom - (bottom < nx), left + (left > 0) : right - (right < ny)] = False
        return not outside.any()

    def part_of(self, grid: Grid) -> Grid:
        """Return the region as a grid of its own."""
        x, y = grid.x[slice(*self.rows)], grid.y[slice(*self.columns)]
        center_x, center_y = 0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1])
        return grid.part(x.size, y.size, (grid.dx, grid.dy), (float(center_x), float(center_y)))


def region_around(contact: BoolArray, free: int = FREE_CELLS, mirrored: bool = False) -> ActiveRegion:
    """Return a region that holds `contact` (nx, ny) and `free` cells on each side; without contact the whole grid.

    A small grid is not cut. The region depends on the arguments alone, so that a resumed run has the same regions.
    mirrored: for one half of a grid, whose parts begin with its first column.
    """
    whole = ActiveRegion((0, contact.shape[0]), (0, contact.shape[1]))
    if max(contact.shape[0], contact.shape[1] * (1 + mirrored)) < FEWEST_POINTS or not contact.any():
        return whole
    wanted = ActiveRegion(_span(contact, 0, free), (_half_span if mirrored else _span)(contact, 1, free))
    return whole if wanted.count > 0.8 * whole.count else wanted  # another operator would not pay


def _half_span(contact: BoolArray, axis: int, free: int) -> Span:
    """Return a span from the first cell of a half on, as wide as its transform allows."""
    points, last = contact.shape[axis], int(np.flatnonzero(contact.any(axis=1 - axis))[-1])
    return 0, min(fast_length(max(LEAST_SIDE, 2 * (last + 1 + free)), even=True) // 2, points)


def _span(contact: BoolArray, axis: int, free: int) -> Span:
    """Return a span along `axis` around `contact` and free cells, as wide as the padding of its transform allows.

    Fast lengths of transforms are so far apart that a growing contact does not need new spectra each time.
    """
    points, indices = contact.shape[axis], np.flatnonzero(contact.any(axis=1 - axis))
    first, last = int(indices[0]), int(indices[-1])
    size = (padded_length(max(LEAST_SIDE, last - first + 1 + 2 * free)) + 1) // 2
    if size >= points:
        return 0, points
    start = min(max(0, (first + last + 1 - size) // 2), points - size)
    return start, start + size
