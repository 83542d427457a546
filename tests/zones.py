"""Sizes of contact and stick zone straight from fields, for the tests of zones."""

from __future__ import annotations

import numpy as np

from fretsolve.contact.zones.area_contact import ZoneSize, zone_sizes
from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.materials import Compliances


def contact_size(pressure: np.ndarray, gap: np.ndarray, grid: Grid, materials: Compliances) -> ZoneSize:
    nothing = np.zeros((2, *pressure.shape))
    fields = ZoneFields(pressure, gap, nothing, nothing[0], nothing, nothing[0].astype(np.uint8), nothing)
    return zone_sizes(fields, grid, materials)[0]


def contact_area(pressure: np.ndarray, gap: np.ndarray, grid: Grid, materials: Compliances) -> float:
    return contact_size(pressure, gap, grid, materials).area


def stick_area(fields: ZoneFields, grid: Grid, materials: Compliances, contact: float) -> float:
    """The area of the stick zone, no larger than that of the contact."""
    return min(zone_sizes(fields, grid, materials)[1].area, contact)
