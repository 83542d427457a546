"""Transfer of fields to a grid of half the points per side, and back.

A coarse cell holds two by two fine ones, or two by one where a side has too few points to be halved; the last row
of an odd number of cells is paired with zeros. Coarse problems are posed as in a full approximation scheme (Brandt
1977): an exact fine estimate solves the coarse problem too, up to the zones' edges, and a poor one is improved.
"""

from __future__ import annotations

import numpy as np

from fretsolve.model.grid import Grid, HalfGrid
from fretsolve.system.arrays import BoolArray, FloatArray

FEWEST_COARSE_POINTS = 49
"""Fewest points that are left of a side that is halved. With 24 a first increment on 48 to 64 points takes 1.4 times as
long, as coarse solves cost calls there, not cells, and the mean of mode I.3 up to 1.1 times."""


class GridTransfer:
    """Transfer between the grid `fine` and a grid `coarse`, which is None where no side can be halved."""

    def __init__(self, grid: Grid):
        self.fine = grid
        self.factors = tuple(2 if count >= 2 * FEWEST_COARSE_POINTS else 1 for count in grid.whole_shape)
        self.coarse: Grid | None = None
        if 2 in self.factors:  # cells that cover those of `fine`, from the same corner on
            fx, fy = self.factors
            nx, ny = -(-grid.nx // fx), -(-grid.ny // fy)
            x0, y0 = grid.x0 + 0.5 * (nx * fx - grid.nx) * grid.dx, grid.y0 + 0.5 * (ny * fy - grid.ny) * grid.dy
            self.coarse = grid.part(nx, ny, (fx * grid.dx, fy * grid.dy), (x0, y0))

    def restrict(self, field: FloatArray) -> FloatArray:
        """Return means over the coarse cells, ``(..., nx, ny)``, with zeros beyond the fine grid."""
        fx, fy = self.factors
        rows = _pair_mean(field, -2) if fx == 2 else field
        return _pair_mean(rows, -1) if fy == 2 else rows

    def restrict_separation(self, separation: FloatArray) -> FloatArray:
        """Return means where all of a coarse cell has material, +inf elsewhere."""
        padding = [(0, count % factor) for count, factor in zip(separation.shape, self.factors, strict=True)]
        return self.restrict(np.pad(separation, padding, constant_values=np.inf))

    def prolong(self, field: FloatArray) -> FloatArray:
        """Return the bilinear interpolation to the fine cells, ``(..., nx, ny)``, with zeros outside of the grid.

        On one half of a grid the other half of the field is its mirror image, and that of qy its negative.
        """
        fx, fy = self.factors
        rows = _interpolate(field, -2)[..., : self.fine.nx, :] if fx == 2 else field
        if fy == 1:
            return rows
        found = _interpolate(rows, -1)[..., : self.fine.ny]
        if isinstance(self.fine, HalfGrid):
            beyond = 0.25 * rows[..., 0]
            if field.ndim == 3:
                beyond[1] *= -1.0
            found[..., 0] += beyond
        return found

    def inject(self, mask: BoolArray) -> BoolArray:
        """Return the values of the coarse cells in their fine ones."""
        fx, fy = self.factors
        nx, ny = self.fine.shape
        return np.repeat(np.repeat(mask, fx, axis=0)[:nx], fy, axis=1)[:, :ny]


def _pair_mean(field: FloatArray, axis: int) -> FloatArray:
    moved = np.moveaxis(field, axis, 0)
    if moved.shape[0] % 2:
        moved = np.concatenate([moved, np.zeros_like(moved[:1])])
    return np.moveaxis(0.5 * (moved[0::2] + moved[1::2]), 0, axis)


def _interpolate(field: FloatArray, axis: int) -> FloatArray:
    moved = np.moveaxis(field, axis, 0)
    result = np.empty((2 * moved.shape[0], *moved.shape[1:]), dtype=field.dtype)
    result[0::2] = 0.75 * moved
    result[1::2] = 0.75 * moved
    result[2::2] += 0.25 * moved[:-1]
    result[1:-1:2] += 0.25 * moved[1:]
    return np.moveaxis(result, 0, axis)
