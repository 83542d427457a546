"""The elastic operator between few cells of a grid, as matrices: the convolutions' own influence coefficients."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from fretsolve.elastic.influence import influence_coefficients
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
        return self._between("zz")

    @cached_property
    def tangential(self) -> DoubleArray:
        """From shear to tangential displacement, (2 n, 2 n)."""
        matrix, x, y = np.zeros((2 * self.count, 2 * self.count)), slice(self.count), slice(self.count, None)
        matrix[x, x], matrix[y, y] = self._between("xx"), self._between("yy")
        if self._tables.terms.in_plane_coupling:
            matrix[x, y] = matrix[y, x] = self._between("xy")
        return matrix

    @cached_property
    def sideways(self) -> DoubleArray:
        """From pressure to tangential displacement, (2 n, n); its transpose is from shear to uz."""
        return np.concatenate([self._between("xz"), self._between("yz")])

    def _between(self, name: Influence) -> DoubleArray:
        return self._tables.at(name, self._offsets)

    @cached_property
    def _offsets(self) -> IndexArray:
        return self._tables.offsets(self.index)


class InfluenceTables:
    """Influence coefficients by the offset of two cells of a grid, each computed when it is first needed."""

    def __init__(self, operator: ElasticOperator, grid: Grid):
        self.terms, self._compliances, self._grid = operator.terms, operator.compliances, grid
        self._tables: dict[Influence, DoubleArray] = {}

    def offsets(self, cells: IndexArray) -> IndexArray:
        """Return where the tables have the offsets between cells, flat indices (n,), as (n, n)."""
        rows, columns = self._grid.shape
        places = (cells // columns) * (2 * columns - 1) + cells % columns
        found: IndexArray = places[:, None] - places
        found += (rows - 1) * (2 * columns - 1) + columns - 1
        return found

    def at(self, name: Influence, offsets: IndexArray) -> DoubleArray:
        """Return an influence (mm/MPa) at such offsets."""
        if name not in self._tables:
            grid, odd_x, odd_y = self._grid, name in ("xy", "xz"), name in ("xy", "yz")
            quarter = influence_coefficients(name, grid.shape, (grid.dx, grid.dy), self._compliances)
            half = np.concatenate([-quarter[:0:-1] if odd_x else quarter[:0:-1], quarter])
            self._tables[name] = np.concatenate([-half[:, :0:-1] if odd_y else half[:, :0:-1], half], axis=1)
        return self._tables[name].take(offsets)
