"""The cells around a zone, and the links between their centres that its edge crosses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fretsolve.model.grid import Grid
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray

Number = TypeVar("Number", bound=np.generic)
Pair = tuple[int, int]

Share = Callable[[FloatArray], FloatArray]
"""Shares inside of the links of a front, given their levers; NaN if no smooth front fits."""

MARGIN_CELLS = 4
"""Cells kept around a zone, to which a link's share may refer."""

RIGHT, AHEAD = np.array([[0], [1], [0], [1]]), np.array([[0], [0], [1], [1]])
"""Steps along y and x from the first corner of a square between four centres to each of its corners."""


@dataclass(frozen=True)
class CellPart:
    """The part of a grid around a zone. Its cells are numbered row by row, ``width`` apart along x and 1 along y.

    corner: centre of the first cell (mm); is_row: whether the grid is a single row, whose edges lie along the cells;
    inside: cells of the zone; deep: those of them whose neighbours are inside too.
    """

    slices: tuple[slice, slice]
    missing: tuple[Pair, Pair]
    width: int
    spacing: tuple[float, float]
    corner: tuple[float, float]
    is_row: bool
    inside: BoolArray
    deep: BoolArray

    @classmethod
    def around(cls, zone: BoolArray, grid: Grid) -> CellPart:
        """Return the part that holds all of `zone` (nx, ny; not empty) and a margin, beyond the grid if needed."""
        rows, columns = (np.flatnonzero(zone.any(axis=1 - axis)) for axis in (0, 1))
        top, bottom = int(rows[0]) - MARGIN_CELLS, int(rows[-1]) + MARGIN_CELLS + 1
        left, right = int(columns[0]) - MARGIN_CELLS, int(columns[-1]) + MARGIN_CELLS + 1
        slices = slice(max(top, 0), bottom), slice(max(left, 0), right)
        missing = (max(-top, 0), max(bottom - grid.nx, 0)), (max(-left, 0), max(right - grid.ny, 0))
        inside = _with_border(zone[slices], missing, False)
        width = inside.shape[1]
        inside = inside.ravel()
        deep = inside.copy()
        # the margin lies outside of the zone, so that neighbours in the rows before and after do not count
        if grid.nx > 1:
            deep[width:-width] &= inside[2 * width :] & inside[: -2 * width]
        if grid.ny > 1:  # a single row of cells, as in line contact, has neighbours along x alone
            deep[1:-1] &= inside[2:] & inside[:-2]
        x, y = grid.x0 + (top - (grid.nx - 1) / 2) * grid.dx, grid.y0 + (left - (grid.ny - 1) / 2) * grid.dy
        spacing, corner, is_row = (grid.dx, grid.dy), (float(x), float(y)), 1 in grid.shape
        return cls(slices, missing, width, spacing, corner, is_row, inside, deep)

    def cut(self, field: NDArray[Number], beyond: float) -> NDArray[Number]:
        """Return the part's cells of a field (nx, ny), in one row; `beyond` past the grid's border."""
        return _with_border(field[self.slices], self.missing, beyond).ravel()


def _with_border(cells: NDArray[Number], missing: tuple[Pair, Pair], beyond: float) -> NDArray[Number]:
    """Return `cells` with `missing` rows and columns around them. NumPy's `pad` takes five times as long."""
    (above, below), (left, right) = missing
    if not above + below + left + right:
        return cells
    rows, columns = cells.shape
    whole = np.full((above + rows + below, left + columns + right), beyond, cells.dtype)
    whole[above : above + rows, left : left + columns] = cells
    return whole


@dataclass(frozen=True)
class Links:
    """Links (k,) from an inner to an outer cell. along_y: those along y; length: between the cells' centres (mm)."""

    inner: IndexArray
    outer: IndexArray
    along_y: BoolArray
    length: FloatArray

    def some(self, chosen: IndexArray) -> Links:
        """Return the links of these numbers."""
        return Links(self.inner[chosen], self.outer[chosen], self.along_y[chosen], self.length[chosen])


@dataclass(frozen=True)
class Front:
    """The n squares between four centres that the edge of a zone crosses.

    count: how many of the four cells are inside, (n,); opposite: these are two that do not touch, (n,); whole: number
    of squares all inside; starts: shares inside of each square's two links along x and two along y, (4, n), 1 or 0;
    crossed: places in `starts` of the `links` that the edge crosses; square: the square of each of these, from 0.
    """

    count: NDArray[np.uint8]
    opposite: BoolArray
    whole: int
    starts: FloatArray
    crossed: IndexArray
    square: IndexArray
    links: Links

    @classmethod
    def of(cls, part: CellPart) -> Front:
        """Return the front of the part's zone."""
        width, (dx, dy) = part.width, part.spacing
        cells = part.inside.view(np.uint8)
        # squares by their first corner; one that wraps round to the next row lies in the margin, outside
        count = cells[: -width - 1] + cells[1:-width] + cells[width:-1] + cells[width + 1 :]
        corner, whole = ((count - 1) < 3).nonzero()[0], int(np.count_nonzero(count == 4))  # unsigned: 0 becomes large
        count = count[corner]
        corners = cells.take(corner + (AHEAD * width + RIGHT))
        # from the near corner along x, from that to its right; from the near one along y, from that ahead
        starts = np.concatenate([corners[:2], corners[::2]])
        crossed = (starts != np.concatenate([corners[2:], corners[1::2]])).ravel().nonzero()[0]
        side, square = np.divmod(crossed, corner.size)
        along_y = side >= 2
        first = corner[square] + np.array([0, 1, 0, width])[side]
        second = first + np.where(along_y, 1, width)
        from_first = starts.ravel()[crossed] != 0
        inner, outer = np.where(from_first, first, second), np.where(from_first, second, first)
        links = Links(inner, outer, along_y, np.where(along_y, dy, dx))
        opposite = (count == 2) & (corners[0] == corners[3])
        return cls(count, opposite, whole, starts.astype(np.float64), crossed, square, links)

    def shares(self, lever: FloatArray, share: Share) -> FloatArray:
        """Return the shares inside of the links of each square, (4, n); lever: of each square, (n,)."""
        shares = self.starts.copy()
        shares.ravel()[self.crossed] = share(lever[self.square])
        return shares
