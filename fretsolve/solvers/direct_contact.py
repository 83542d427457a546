"""The cells in contact of a direct solution (`fretsolve.solvers.direct`), their tractions, and the unknowns of D5."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.friction.limit import FrictionLimit
from fretsolve.solvers.influence_matrices import Cells
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray, IndexArray, Vector


@dataclass(frozen=True)
class DirectSolution:
    """pressure: (nx, ny); shear: (2, nx, ny); rigid: delta_z, phi_x, phi_y, and the increments of delta_x, delta_y,
    phi_z."""

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector


class DirectContact:
    """The unknowns of the n cells in contact.

    contact: the cells, (nx, ny); pressure, slipping, limit (of friction): (n,); shear: (2 n,), all x before all y;
    direction: of the shear where it slips, else 0, (2, n); rigid: as in `DirectSolution`.
    """

    def __init__(
        self,
        friction: FrictionLimit,
        contact: BoolArray,
        cells: Cells,
        pressure: DoubleArray,
        shear: DoubleArray,
        slipping: BoolArray,
        rigid: Vector,
    ):
        self._friction, self.contact, self.cells, self.pressure = friction, contact, cells, pressure
        self.shear, self.slipping, self.rigid = shear, slipping, rigid
        self.limit: FloatArray = friction.part(contact).limit(pressure)
        self.direction: DoubleArray = np.zeros((2, cells.count))

    @property
    def has_friction(self) -> bool:
        """True if all cells have friction: others neither stick nor have a direction in which they slip."""
        return bool(self.limit.all())

    def move_to(self, contact: BoolArray, cells: Cells, pressure: DoubleArray) -> None:
        """Take the pressure of cells in contact; one that is new slips as the cells around it do, or sticks."""
        if cells is not self.cells:
            shear, slipping = np.zeros((2, contact.size)), np.zeros(contact.size, bool)
            shear[:, self.cells.index], slipping[self.cells.index] = self.shear.reshape(2, -1), self.slipping
            new = np.flatnonzero(contact & ~self.contact)
            if new.size and self.slipping.any():
                _follow_neighbours(new, contact.shape, shear, slipping)
            self.shear, self.slipping = shear[:, cells.index].ravel(), slipping[cells.index]
        self.contact, self.cells, self.pressure = contact, cells, pressure

    def put_on_circle(self) -> None:
        """Let shear beyond the friction limit slip, and give it the length of the limit where it slips."""
        shear, self.limit = self.shear.reshape(2, -1), self._friction.part(self.contact).limit(self.pressure)
        length = np.hypot(shear[0], shear[1])
        self.slipping = self.slipping & (length > 0.0) | (length > self.limit)
        self.direction = shear * (self.slipping / np.maximum(length, TINY))
        self.shear = np.where(self.slipping, self.limit * self.direction, shear).ravel()

    def along(self, field: DoubleArray) -> DoubleArray:
        """Return the part (n,) of a field (2 n,) along the direction of the shear."""
        count, (x, y) = self.cells.count, self.direction
        part: DoubleArray = field[:count] * x + field[count:] * y
        return part

    def across(self, fields: DoubleArray) -> DoubleArray:
        """Return fields (m, 2 n) without their part along the direction of the shear."""
        x, y = self.direction
        parts = fields.reshape(len(fields), 2, -1)
        along = parts[:, 0] * x + parts[:, 1] * y
        rest: DoubleArray = fields - (along[:, None] * self.direction).reshape(fields.shape)
        return rest

    def unknowns(self, in_plane: bool) -> Unknowns:
        """Return the unknowns of D5; in_plane: whether nothing acts and moves along y in a line contact."""
        x, y = self.direction
        first = np.where(self.slipping, -y, 1.0), np.where(self.slipping, x, 0.0)
        return Unknowns(self, in_plane, np.flatnonzero(~self.slipping), first)


@dataclass(frozen=True)
class Unknowns:
    """The unknowns of D5 at fixed zones: of each of the n cells across its shear or along x, then along y of `sticking`
    ones; `in_plane` of a line contact along x of the latter alone.

    first: direction of the unknown of each cell, x and y, (n,).
    """

    contact: DirectContact
    in_plane: bool
    sticking: IndexArray
    first: tuple[DoubleArray, DoubleArray]

    def reduced(self, fields: DoubleArray) -> DoubleArray:
        """Return fields (m, 2 n) by the unknowns."""
        if self.in_plane:
            return fields[:, self.sticking]
        count, (first_x, first_y) = self.contact.cells.count, self.first
        x, y = fields[:, :count], fields[:, count:]
        return np.concatenate([x * first_x + y * first_y, y[:, self.sticking]], axis=1)

    def matrix(self, forward: DoubleArray) -> DoubleArray:
        """Return the matrix of D5; forward: the slip along the shear, (n,)."""
        contact, sticking, (first_x, first_y) = self.contact, self.sticking, self.first
        count, influence = contact.cells.count, contact.cells.tangential
        if self.in_plane:
            return influence[sticking[:, None], sticking]
        by_first = influence[:, :count] * first_x + influence[:, count:] * first_y
        matrix = np.empty((count + sticking.size, count + sticking.size))
        matrix[:count, :count] = first_x[:, None] * by_first[:count] + first_y[:, None] * by_first[count:]
        matrix[count:, :count] = by_first[count + sticking]
        matrix[:count, count:] = matrix[count:, :count].T
        matrix[count:, count:] = influence[count + sticking[:, None], count + sticking]
        slipping = np.flatnonzero(contact.slipping)
        matrix[slipping, slipping] += forward[slipping] / contact.limit[slipping]
        return matrix

    def expanded(self, unknown: DoubleArray) -> DoubleArray:
        """Return the field (2 n,) of values of the unknowns."""
        count, sticking = self.contact.cells.count, self.sticking
        if self.in_plane:
            field = np.zeros(2 * count)
            field[sticking] = unknown
            return field
        field = np.concatenate([unknown[:count] * self.first[0], unknown[:count] * self.first[1]])
        field[count + sticking] += unknown[count:]
        return field


def _follow_neighbours(new: IndexArray, shape: tuple[int, int], shear: DoubleArray, slipping: BoolArray) -> None:
    """Let new cells slip along the sum of the shear of the slipping cells around them, if there are any.

    Cells beyond one half of a mirror image are left out, as that is an estimate.
    new: flat indices; shear: (2, nx ny), slipping: (nx ny,) of a grid of `shape`, changed in place.
    """
    around = np.zeros((2, shape[0] + 2, shape[1] + 2))
    around[:, 1:-1, 1:-1] = (shear * slipping).reshape(2, *shape)
    row, column = np.divmod(new, shape[1])
    rows, columns = np.indices((3, 3)).reshape(2, 9, 1)
    found = around[:, row + rows, column + columns].sum(axis=1)
    shear[:, new], slipping[new] = found, found.any(axis=0)
