"""The potential contact area: a rectangle cut into equal rectangular cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

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

    @property
    def shape(self) -> tuple[int, int]:
        """Shape (nx, ny) of a field on the grid."""
        return self.nx, self.ny

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


def cell_centers(count: int, spacing: float, center: float) -> DoubleArray:
    """Return `count` points `spacing` apart about `center`, read-only.

    About the origin they are antisymmetric to the last bit, so that a mirror-symmetric case stays so.
    """
    centers: DoubleArray = (np.arange(count, dtype=np.float64) - (count - 1) / 2) * spacing + center
    centers.flags.writeable = False
    return centers
