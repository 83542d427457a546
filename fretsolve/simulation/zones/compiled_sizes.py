"""Sizes of contact and stick zone by the compiled kernels; without numba they follow from `ZoneEdge`."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

import numpy as np

from fretsolve.model.grid import Grid
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.simulation.zones.edge_shares import ZoneFields
from fretsolve.simulation.zones.zone_extents import Extent

NO_VECTORS = np.empty((2, 0, 0))
"""In place of fields that are not read. Those of cases without shear have another layout, to be compiled for."""


class ZoneSize(NamedTuple):
    """The area (mm^2) of a zone and its extent; that of no zone by default."""

    area: float = 0.0
    extent: Extent = Extent()


def compiled_sizes(
    kernels: ModuleType, fields: ZoneFields, grid: Grid, materials: Compliances
) -> tuple[ZoneSize, ZoneSize]:
    """Return the sizes of contact and stick zone. If nothing slips, they are the same."""
    contact, sticking, slipping = fields.pressure > 0.0, fields.zone == Zone.STICK, fields.zone == Zone.SLIP
    if not contact.any():
        return ZoneSize(), ZoneSize()
    sides_and_moduli = grid.dx, grid.dy, materials.contact_modulus, 2.0 / materials.torsional
    pressed = fields.pressure, fields.gap
    unread = NO_VECTORS, fields.pressure, NO_VECTORS, NO_VECTORS
    found = _placed(kernels.sizes(contact, contact, *pressed, *unread, *sides_and_moduli, False), grid)
    if not sticking.any():
        return found, ZoneSize()
    if not slipping.any():
        return found, found
    # a new array, since numba compiles once more for one that is read-only
    tangential = fields.shear, fields.limit, fields.slip, fields.slip_before + fields.slip
    return found, _placed(kernels.sizes(sticking, slipping, *pressed, *tangential, *sides_and_moduli, True), grid)


def _placed(sizes: tuple[float, ...], grid: Grid) -> ZoneSize:
    """Return the size of a zone, whose middle is given in cells from the grid's first one."""
    area, half_x, half_y, row, column = sizes
    x, y = grid.x0 + (row - 0.5 * (grid.nx - 1)) * grid.dx, grid.y0 + (column - 0.5 * (grid.ny - 1)) * grid.dy
    return ZoneSize(area, Extent(half_x, half_y, x, y))
