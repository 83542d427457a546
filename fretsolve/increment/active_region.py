"""The part of the grid that an increment is solved on: the contact with a margin.

Convolutions of the tractions inside the window need no cell outside of it, so a contact that covers a small part of
the grid costs a small part. The certificate is always computed on the whole grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.transform_length import padded_length
from fretsolve.model.grid import Grid
from fretsolve.system.arrays import BoolArray

Span = tuple[int, int]

FREE_CELLS = 3
"""Cells at least left free on each side, so that a contact may grow a little within an increment."""

STEP = 1.08
"""Ratio of one size of window to the next, so that a growing contact does not need new spectra at each increment."""

LEAST_SIZE = 16

WORTH_HAVING = 0.8
"""A window with more than this part of the grid's cells is the whole grid: another operator would not pay."""


@dataclass(frozen=True)
class Window:
    """Cells ``rows[0] <= i < rows[1]``, ``columns[0] <= j < columns[1]`` of a grid."""

    rows: Span
    columns: Span

    @property
    def cells(self) -> tuple[slice, slice]:
        """Index of the window's cells in a field (nx, ny)."""
        return slice(*self.rows), slice(*self.columns)

    @property
    def vector_cells(self) -> tuple[slice, slice, slice]:
        """Index of the window's cells in a field (2, nx, ny)."""
        return (slice(None), *self.cells)

    @property
    def count(self) -> int:
        """Number of cells."""
        return (self.rows[1] - self.rows[0]) * (self.columns[1] - self.columns[0])

    def holds(self, contact: BoolArray) -> bool:
        """Whether all of `contact` (on the whole grid) lies inside and off the edges that are not the grid's."""
        return all(
            _inside(_extent(contact, axis), span, contact.shape[axis])
            for axis, span in enumerate((self.rows, self.columns))
        )

    def part_of(self, grid: Grid) -> Grid:
        """The window as a grid of its own."""
        x, y = grid.x[slice(*self.rows)], grid.y[slice(*self.columns)]
        center_x, center_y = 0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1])
        return Grid(x.size, y.size, grid.dx, grid.dy, float(center_x), float(center_y))


def window_around(contact: BoolArray, free: int = FREE_CELLS) -> Window:
    """A window that holds `contact` (nx, ny) with `free` cells on each side; the whole grid without contact.

    It depends on its arguments alone, so that a resumed run has the same windows.
    """
    shape = contact.shape
    whole = Window((0, shape[0]), (0, shape[1]))
    if not contact.any():
        return whole
    wanted = Window(_widened(_extent(contact, 0), shape[0], free), _widened(_extent(contact, 1), shape[1], free))
    return whole if wanted.count > WORTH_HAVING * whole.count else wanted


def _extent(contact: BoolArray, axis: int) -> Span:
    """First index along `axis` at which there is contact, and the one after the last; (0, 0) without contact."""
    indices = np.flatnonzero(contact.any(axis=1 - axis))
    return (int(indices[0]), int(indices[-1]) + 1) if indices.size else (0, 0)


def _inside(extent: Span, span: Span, points: int) -> bool:
    if extent == (0, 0):
        return True
    low = extent[0] > span[0] or span[0] == 0
    high = extent[1] < span[1] or span[1] == points
    return low and high and span[0] <= extent[0] and extent[1] <= span[1]


def _widened(extent: Span, points: int, free: int) -> Span:
    """`extent` with free cells, up to the next size, and as many more as the padded length has for nothing."""
    wanted = extent[1] - extent[0] + 2 * free
    size = LEAST_SIZE
    while size < wanted:
        size = math.ceil(STEP * size)
    size = (padded_length(size) + 1) // 2
    if size >= points:
        return 0, points
    start = (extent[0] + extent[1] - size) // 2
    start = min(max(0, start), points - size)
    return start, start + size
