"""Areas of contact and stick zone straight from fields, for the tests of zones."""

from __future__ import annotations

import numpy as np

from fretsolve.model.grid import Grid
from fretsolve.model.materials import Compliances
from fretsolve.simulation.zones.edge_shares import ZoneFields
from fretsolve.simulation.zones.zone_areas import zone_area
from fretsolve.simulation.zones.zone_edges import contact_edge, stick_edge


def contact_area(pressure: np.ndarray, gap: np.ndarray, grid: Grid, materials: Compliances) -> float:
    return zone_area(contact_edge(pressure, gap, grid, materials))


def stick_area(fields: ZoneFields, grid: Grid, materials: Compliances, contact: float) -> float:
    """The area of the stick zone, no larger than that of the contact."""
    edge = contact_edge(fields.pressure, fields.gap, grid, materials)
    return min(zone_area(stick_edge(fields, grid, materials, edge)), contact)
