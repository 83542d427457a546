"""The cells around the zones of an increment, and the links between the cells' centres that the edges cross."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray

MARGIN_CELLS = 4
"""Cells kept around the zones, to which the law of a link may refer."""


@dataclass(frozen=True)
class ZoneCells:
    """Whole rows of a grid around m zones. Cells are numbered row by row, all cells of one zone before the next zone's.

    top: number of the first row; beyond: cells past each side of the grid that a zone's margin would reach; inside:
    cells of the zones; deep: cells whose neighbours are inside too, both (m, rows, columns); first, last: row and
    column of the outermost cells of each zone, (2, m).
    """

    grid: Grid
    top: int
    beyond: int
    inside: BoolArray
    deep: BoolArray
    first: IndexArray
    last: IndexArray

    @classmethod
    def around(cls, zones: tuple[BoolArray, ...], grid: Grid) -> ZoneCells:
        """Return the cells around `zones`, (nx, ny); the first zone holds the others and is not empty."""
        taken: list[BoolArray] = [np.any(zones[0], axis=axis) for axis in (1, 0)]
        first, last = [int(along.argmax()) for along in taken], [int(along[::-1].argmax()) for along in taken]
        beyond = MARGIN_CELLS if min(first + last) < MARGIN_CELLS else 0
        top, bottom = first[0] - MARGIN_CELLS, grid.nx - last[0] + MARGIN_CELLS
        inside = np.array([_rows(zone, top, bottom, beyond, False) for zone in zones])
        deep = inside.copy()
        if grid.nx > 1:
            deep[:, 1:-1] &= inside[:, 2:] & inside[:, :-2]
        if grid.ny > 1:  # a single row of cells, as in line contact, has neighbours along x alone
            deep[:, :, 1:-1] &= inside[:, :, 2:] & inside[:, :, :-2]
        across: list[BoolArray] = [np.any(inside, axis=axis) for axis in (2, 1)]
        return cls(
            grid,
            top,
            beyond,
            inside,
            deep,
            np.array([along.argmax(axis=1) for along in across]),
            np.array([along.shape[1] - 1 - along[:, ::-1].argmax(axis=1) for along in across]),
        )

    @property
    def width(self) -> int:
        """Number of cells of a row."""
        return int(self.inside.shape[2])

    def cut(self, field: NDArray[np.generic], beyond: float) -> NDArray[Any]:
        """Return these cells of a field (nx, ny), as one row of numbers; `beyond` past the grid's border."""
        return _rows(field, self.top, self.top + self.inside.shape[1], self.beyond, beyond).ravel()

    def corner(self, zone: int) -> tuple[float, float]:
        """Return the place (mm) of the cell that is MARGIN_CELLS before the first row and column of a zone."""
        grid, (row, column) = self.grid, (self.first[:, zone] - MARGIN_CELLS).tolist()
        row, column = self.top + row, column - self.beyond
        return grid.x0 + (row - (grid.nx - 1) / 2) * grid.dx, grid.y0 + (column - (grid.ny - 1) / 2) * grid.dy


def _rows(field: NDArray[Any], top: int, bottom: int, margin: int, beyond: float) -> NDArray[Any]:
    """Return some rows of a field (nx, ny), with a margin of the value `beyond` past the grid's border, if any."""
    if not margin:
        return field[top:bottom]
    whole = np.full((bottom - top, field.shape[1] + 2 * margin), beyond, field.dtype)
    start, stop = max(top, 0), min(bottom, len(field))
    whole[start - top : stop - top, margin:-margin] = field[start:stop]
    return whole


@dataclass(frozen=True)
class Links:
    """Links (k,) from an inner to an outer cell, by the numbers that the cells have in the part.

    zone: number of each link's zone; along_y: whether the link is along y; length: between the cells' centres (mm).
    """

    zone: IndexArray
    inner: IndexArray
    outer: IndexArray
    along_y: BoolArray
    length: FloatArray

    def some(self, chosen: IndexArray) -> Links:
        """Return the links of these numbers."""
        return Links(*(array[chosen] for array in vars(self).values()))


@dataclass(frozen=True)
class Front:
    """The n squares between four centres that the edges cross, by zones.

    zone: number of each square's zone; count: how many of its four cells are inside; opposite: whether these are two
    that do not touch, (n,); whole: number of squares all inside, of each zone; starts: shares inside of each square's
    two links along x and two along y, (4, n), 1 or 0; crossed: places in `starts` of the `links` that the edge crosses;
    square: the square of each link, from 0.
    """

    zone: IndexArray
    count: NDArray[np.uint8]
    opposite: BoolArray
    whole: list[int]
    starts: FloatArray
    crossed: IndexArray
    square: IndexArray
    links: Links

    @classmethod
    def of(cls, part: ZoneCells) -> Front:
        """Return the front of the zones."""
        width, size, cells = part.width, part.inside[0].size, part.inside.ravel().view(np.uint8)
        # squares by their first corner; one that wraps round to the next row or zone lies in the margin, outside
        count = cells[: -width - 1] + cells[1:-width] + cells[width:-1] + cells[width + 1 :]
        corner, full = ((count - 1) < 3).nonzero()[0], count == 4  # unsigned: 0 becomes large
        zone, corner_in_zone = np.divmod(corner, size)
        count = count[corner]
        corners = cells.take(corner + np.array([[0], [1], [width], [width + 1]]))
        # from the near corner along x, from that to its right; from the near one along y, from that ahead
        starts = corners[[0, 1, 0, 2]]
        crossed = (starts != corners[[2, 3, 1, 3]]).ravel().nonzero()[0]
        side, square = np.divmod(crossed, corner.size)
        along_y = side >= 2
        first = corner_in_zone[square] + np.array([0, 1, 0, width])[side]
        second = first + np.where(along_y, 1, width)
        from_first = starts.ravel()[crossed] != 0
        inner, outer = np.where(from_first, first, second), np.where(from_first, second, first)
        links = Links(zone[square], inner, outer, along_y, np.where(along_y, part.grid.dy, part.grid.dx))
        opposite = (count == 2) & (corners[0] == corners[3])
        whole = [int(np.count_nonzero(full[n * size :][:size])) for n in range(len(part.inside))]
        return cls(zone, count, opposite, whole, starts.astype(np.float64), crossed, square, links)
