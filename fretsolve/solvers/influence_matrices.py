"""The elastic operator between few cells of a grid, as matrices: the convolutions' own influence coefficients."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from fretsolve.elastic.kernel_spectrum import Influence
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.model.grid import Grid
from fretsolve.system.arrays import DoubleArray, IndexArray


class Cells:
    """Cells of a grid, their rigid motions, and the influence matrices between them (mm/MPa).

    index: flat, (n,); tilts: (3, n), the motions of the gap; motions: (3, 2 n), those of the slip, all x before all y.
    """

    def __init__(self, index: IndexArray, grid: Grid, tables: InfluenceTables):
        self.index, self.count, self._tables = index, index.size, tables
        x, y = grid.x[index // grid.ny], grid.y[index % grid.ny]
        one, nothing = np.ones(index.size), np.zeros(index.size)
        self.tilts: DoubleArray = np.array([one, y, x])
        self.motions: DoubleArray = np.array([[one, nothing], [nothing, one], [-y, x]]).reshape(3, -1)

    @cached_property
    def normal(self) -> DoubleArray:
        """From pressure to uz, (n, n)."""
        return self._between("zz", odd=False)

    @cached_property
    def tangential(self) -> DoubleArray:
        """From shear to tangential displacement, (2 n, 2 n)."""
        matrix, x, y = np.zeros((2 * self.count, 2 * self.count)), slice(self.count), slice(self.count, None)
        matrix[x, x], matrix[y, y] = self._between("xx", odd=False), self._between("yy", odd=True)
        if self._tables.terms.in_plane_coupling:
            matrix[x, y] = self._between("xy", odd=True)
            matrix[y, x] = matrix[x, y].T
        return matrix

    def pressures(self, displacements: DoubleArray) -> DoubleArray:
        """Return the pressures (n, k) under which the cells have these uz (n, k). Raises LinAlgError."""
        return np.asarray(np.linalg.solve(self.normal, displacements), np.float64)

    def pressures_by_inverse(self, displacements: DoubleArray) -> DoubleArray:
        """Return the same, by the inverse matrix, which takes two solutions and is kept. Raises LinAlgError."""
        found: DoubleArray = self._inverse @ displacements
        return found

    @cached_property
    def _inverse(self) -> DoubleArray:
        return np.asarray(np.linalg.inv(self.normal), np.float64)

    @cached_property
    def sideways(self) -> DoubleArray:
        """From pressure to tangential displacement, (2 n, n); its transpose is from shear to uz."""
        return np.concatenate([self._between("xz", odd=False), self._between("yz", odd=False)])

    def _between(self, name: Influence, odd: bool) -> DoubleArray:
        """Return an influence of all cells on all cells, with that of their mirror images on one half of a grid.

        odd: the tractions of these are the cells' own with another sign, as qy is.
        """
        direct = self._tables.at(name, self._offsets)
        if self._mirrored_offsets is None:
            return direct
        mirrored = self._tables.at(name, self._mirrored_offsets)
        return direct - mirrored if odd else direct + mirrored

    @cached_property
    def _offsets(self) -> IndexArray:
        return self._tables.offsets(self.index)

    @cached_property
    def _mirrored_offsets(self) -> IndexArray | None:
        return self._tables.mirrored_offsets(self.index)


class InfluenceTables:
    """Influence coefficients by the offset of two cells of a grid, each computed when it is first needed.

    Offsets are those on the whole grid, where `grid` is one half.
    """

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.terms, self._coefficients, self._grid = operator.terms, operator.coefficients, grid
        self._beyond = grid.whole_shape[1] - grid.ny  # columns that the half of the grid lacks
        self._tables: dict[Influence, DoubleArray] = {}

    def offsets(self, cells: IndexArray) -> IndexArray:
        """Return where the tables have the offsets between cells, flat indices (n,), as (n, n)."""
        own = self._beyond + cells % self._grid.ny
        return self._from_to(cells, own, own)

    def mirrored_offsets(self, cells: IndexArray) -> IndexArray | None:
        """Return the same from the mirror images of cells to the cells; None on a whole grid."""
        if not self._beyond:
            return None
        column = cells % self._grid.ny
        return self._from_to(cells, self._beyond - 1 - column, self._beyond + column)

    def _from_to(self, cells: IndexArray, sources: IndexArray, targets: IndexArray) -> IndexArray:
        """Return the offsets (n, n) from cells in the columns `sources` to those in the columns `targets`."""
        rows, columns = self._grid.whole_shape
        row, width = cells // self._grid.ny, 2 * columns - 1
        found: IndexArray = (row * width + targets)[:, None] - (row * width + sources)
        found += (rows - 1) * width + columns - 1
        return found

    def at(self, name: Influence, offsets: IndexArray) -> DoubleArray:
        """Return an influence (mm/MPa) at such offsets."""
        if name not in self._tables:
            odd_x, odd_y = name in ("xy", "xz"), name in ("xy", "yz")
            quarter = self._coefficients(name, self._grid.whole_shape)
            half = np.concatenate([-quarter[:0:-1] if odd_x else quarter[:0:-1], quarter])
            self._tables[name] = np.concatenate([-half[:, :0:-1] if odd_y else half[:, :0:-1], half], axis=1)
        return self._tables[name].take(offsets)
