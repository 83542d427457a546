"""The potential contact area: a rectangle cut into equal rectangular cells, or one row of cells of a line contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from fretsolve.system.arrays import DoubleArray

LARGE_GRID = 5e5
"""Number of cells beyond which memory matters more than the time to allocate it again: one active region is kept, and
arrays are freed as soon as they hold nothing of use."""


@dataclass(frozen=True)
class Grid:
    """``nx`` by ``ny`` cells with sides ``dx``, ``dy`` (mm), centred at (``x0``, ``y0``) (mm).

    Raises ValueError if there is no cell or a side is not positive and finite.
    """

    nx: int
    ny: int
    dx: float
    dy: float
    x0: float = 0.0
    y0: float = 0.0

    axes: ClassVar[str] = "xy"
    """The directions in which the contact has edges."""

    def __post_init__(self) -> None:
        if min(self.nx, self.ny) < 1:
            raise ValueError(f"a grid needs at least one cell per direction, got {self.nx} x {self.ny}")
        if not (0.0 < self.dx < math.inf and 0.0 < self.dy < math.inf):
            raise ValueError(f"cell sides must be positive and finite, got {self.dx} x {self.dy}")

    @classmethod
    def from_size(
        cls, points: tuple[int, int], size: tuple[float, float], center: tuple[float, float] = (0.0, 0.0)
    ) -> Grid:
        """Cut the rectangle `size` (mm), centred at `center` (mm), into `points` = (nx, ny) cells."""
        nx, ny = points  # a number below 1 is refused by the class
        return cls(nx, ny, size[0] / max(nx, 1), size[1] / max(ny, 1), center[0], center[1])

    def cut_into(self, nx: int, ny: int) -> Grid:
        """Return the same rectangle cut into other cells."""
        return Grid.from_size((nx, ny), self.size, self.center)

    def with_ring(self) -> Grid:
        """Return a grid of the same cells and one more on each side where the contact has an edge."""
        return replace(self, nx=self.nx + 2, ny=self.ny + 2)

    def part(self, nx: int, ny: int, spacing: tuple[float, float], center: tuple[float, float]) -> Grid:
        """Return a grid of its own for a part of the rectangle, or for larger cells that cover it."""
        return replace(self, nx=nx, ny=ny, dx=spacing[0], dy=spacing[1], x0=center[0], y0=center[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Shape (nx, ny) of a field on the grid."""
        return self.nx, self.ny

    @property
    def whole_shape(self) -> tuple[int, int]:
        """The same of the grid that this one is a half of, if it is one."""
        return self.shape

    @property
    def size(self) -> tuple[float, float]:
        """Sides of the potential contact area (mm)."""
        return self.nx * self.dx, self.ny * self.dy

    @property
    def center(self) -> tuple[float, float]:
        """Centre of the potential contact area (mm)."""
        return self.x0, self.y0

    @property
    def cell_area(self) -> float:
        """Area of a cell (mm^2)."""
        return self.dx * self.dy

    @cached_property
    def x(self) -> DoubleArray:
        """Cell centres along x (mm), ``(nx,)``, read-only."""
        return cell_centers(self.nx, self.dx, self.x0)

    @cached_property
    def y(self) -> DoubleArray:
        """Cell centres along y (mm), ``(ny,)``, read-only."""
        return cell_centers(self.ny, self.dy, self.y0)

    @cached_property
    def farthest(self) -> float:
        """Largest absolute coordinate of a cell's centre (mm)."""
        return max(abs(float(end)) for end in (self.x[0], self.x[-1], self.y[0], self.y[-1]))


@dataclass(frozen=True)
class LineGrid(Grid):
    """The row of cells of a line contact along x. Sums over its cells are per mm of the line's length.

    log_length: the length l (mm) of the logarithm ln(|x|/l) in the displacements. All parts of a grid have the whole
    grid's length, since it sets the free constant of the displacements.
    """

    log_length: float = 1.0

    axes: ClassVar[str] = "x"

    @classmethod
    def of_length(cls, points: int, length: float, center: float, log_length: float | None = None) -> LineGrid:
        """Cut a length (mm) about `center` (mm) into `points` cells."""
        side = length / points
        return cls(points, 1, side, side, center, 0.0, log_length or length)

    def with_ring(self) -> LineGrid:
        return replace(self, nx=self.nx + 2)

    def cut_into(self, nx: int, ny: int) -> LineGrid:
        return LineGrid.of_length(nx, self.size[0], self.x0, self.log_length)

    @property
    def cell_area(self) -> float:
        """Area of a cell per mm of the line's length (mm^2/mm)."""
        return self.dx


@dataclass(frozen=True)
class HalfGrid(Grid):
    """The half y > 0 of a grid about y = 0 with an even number of columns. Its fields are even or odd in y.

    Sums over its cells times `cell_area` are sums over the whole grid, where what is summed is even. All parts of the
    half begin at y = 0.
    """

    @classmethod
    def of(cls, grid: Grid) -> HalfGrid:
        """Return one half of a grid."""
        return cls(grid.nx, grid.ny // 2, grid.dx, grid.dy, grid.x0, 0.25 * grid.size[1])

    @property
    def whole_shape(self) -> tuple[int, int]:
        return self.nx, 2 * self.ny

    @property
    def size(self) -> tuple[float, float]:
        """Sides of the whole potential contact area (mm)."""
        return self.nx * self.dx, 2 * self.ny * self.dy

    @property
    def cell_area(self) -> float:
        """Area of a cell and of its mirror image (mm^2)."""
        return 2.0 * self.dx * self.dy

    @cached_property
    def y(self) -> DoubleArray:
        centers = (np.arange(self.ny, dtype=np.float64) + 0.5) * self.dy
        centers.flags.writeable = False
        return centers


def cell_centers(count: int, spacing: float, center: float) -> DoubleArray:
    """Return `count` points `spacing` apart about `center`, read-only.

    About the origin they are antisymmetric to the last bit, so that a mirror-symmetric case stays so.
    """
    centers: DoubleArray = (np.arange(count, dtype=np.float64) - (count - 1) / 2) * spacing + center
    centers.flags.writeable = False
    return centers
