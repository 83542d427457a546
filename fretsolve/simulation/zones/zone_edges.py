"""Edges of the contact and of its stick zone to a small part of a cell, from the fields of one increment.

`cell_front` finds the links between cells that an edge crosses, and `edge_shares` has the laws that place it on them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.kernels.zone_laws import LEVER, LEVER_ALONG, LEVER_MOST, LEVER_SLANTING
from fretsolve.model.grid import Grid
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.simulation.zones.cell_front import CellPart, Front, Share
from fretsolve.simulation.zones.edge_shares import ZoneFields, contact_share, inset_by, stick_share
from fretsolve.system.arrays import TINY, FloatArray


@dataclass(frozen=True)
class ZoneEdge:
    """The edge of a zone: the part of the grid around it, and the n squares between centres that it crosses.

    shares: inside of each square's links, as `Front.starts`, (4, n); run, length: of the edge within each square, along
    x and y, (2, n), and in all, (n,) (mm); inset: of the edge in cells, by its direction there, (n,).
    """

    part: CellPart
    front: Front
    shares: FloatArray
    run: FloatArray
    length: FloatArray
    inset: FloatArray

    @classmethod
    def placed(cls, part: CellPart, front: Front, share: Share) -> ZoneEdge:
        """Place an edge on the links that it crosses."""
        sides = np.array(part.spacing)[:, None]
        lever = np.full(front.count.shape, LEVER)
        for _ in range(2):  # the first pass finds the edge's direction
            shares = front.shares(lever, share)
            run = np.abs(shares[1::2] - shares[::2]) * sides
            length = np.maximum(np.hypot(*run), TINY)
            cosine, sine = run / length
            lever = np.minimum(LEVER_ALONG + LEVER_SLANTING * (2.0 * cosine * sine), LEVER_MOST)
            if part.is_row:
                lever = np.full(lever.shape, LEVER_ALONG)
        return cls(part, front, shares, run, length, inset_by(lever))


def contact_edge(pressure: FloatArray, gap: FloatArray, grid: Grid, materials: Compliances) -> ZoneEdge | None:
    """Return the edge of the contact, None without one; pressure (MPa) and gap (mm, may be infinite): (nx, ny)."""
    contact = pressure > 0.0
    if not contact.any():
        return None
    part = CellPart.around(contact, grid)
    front = Front.of(part)
    return ZoneEdge.placed(part, front, contact_share(part, front.links, pressure, gap, materials))


def stick_edge(fields: ZoneFields, grid: Grid, materials: Compliances, contact: ZoneEdge | None) -> ZoneEdge | None:
    """Return the edge of the stick zone, None without one; that of the `contact` if nothing slips."""
    sticking = fields.zone == Zone.STICK
    if not sticking.any():
        return None
    if not (fields.zone == Zone.SLIP).any():
        return contact
    part = CellPart.around(sticking, grid)
    front = Front.of(part)
    return ZoneEdge.placed(part, front, stick_share(part, front.links, fields, materials))
