"""The potential contact area: a rectangle cut into equal rectangular cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:

    from fretsolve.system.arrays import DoubleArray


LARGE_GRID = 5e5
"""Cells from which on memory counts for more than the time to get it again: one window is kept, and arrays are given
back as soon as they hold nothing of use."""


@dataclass(frozen=True)
class Grid:
    """``nx`` by ``ny`` cells with sides ``dx``, ``dy`` (mm) about the point (``x0``, ``y0``) (mm).

    Raises ValueError where there is no cell or a side is not positive and finite.
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
        """Cut the rectangle `size` (mm) centred at `center` (mm) into `points` = (nx, ny) cells."""
        nx, ny = points
        if min(points) < 1:
            raise ValueError(f"a grid needs at least one cell per direction, got {nx} x {ny}")
        return cls(nx, ny, size[0] / nx, size[1] / ny, center[0], center[1])

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
        """Largest coordinate of a cell's centre (mm)."""
        return max(abs(float(end)) for end in (self.x[0], self.x[-1], self.y[0], self.y[-1]))


def cell_centers(count: int, spacing: float, center: float) -> DoubleArray:
    """`count` read-only points `spacing` apart about `center`.

    About the origin they are antisymmetric to the last bit, so that a mirror-symmetric case stays so.
    """
    import numpy as np

    centers: DoubleArray = (np.arange(count, dtype=np.float64) - (count - 1) / 2) * spacing + center
    centers.flags.writeable = False
    return centers
