"""Edges of a line contact and of its stick zone to a small part of a cell, from the fields of one increment.

The laws are those of `edge_shares` for a front along the cells.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.kernels.zone_laws import LEVER_ALONG
from fretsolve.model.grid import LineGrid
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.simulation.zones.cell_front import MARGIN_CELLS, CellPart, Links, Share
from fretsolve.simulation.zones.edge_shares import ZoneFields, contact_share, inset_by, stick_share
from fretsolve.system.arrays import BoolArray

Interval = tuple[float, float]


@dataclass(frozen=True)
class LineZones:
    """Intervals (mm) of a line contact: those in contact and those that stick, each from left to right."""

    contact: tuple[Interval, ...]
    stick: tuple[Interval, ...]


def width(intervals: tuple[Interval, ...]) -> float:
    """Return the length (mm) of intervals together."""
    return math.fsum(right - left for left, right in intervals)


def line_zones(fields: ZoneFields, grid: LineGrid, materials: Compliances) -> LineZones:
    """Return the zones of an increment. fields: (nx, 1), shear and slip (2, nx, 1)."""
    sticking = fields.zone == Zone.STICK
    contact = _intervals(
        fields.zone != Zone.OPEN,
        grid,
        lambda part, links: contact_share(part, links, fields.pressure, fields.gap, materials),
    )
    if not sticking.any() or not np.any(fields.zone == Zone.SLIP):
        return LineZones(contact, contact if sticking.any() else ())
    stick = _intervals(sticking, grid, lambda part, links: stick_share(part, links, fields, materials))
    return LineZones(contact, stick)


def _intervals(zone: BoolArray, grid: LineGrid, share_of: Callable[[CellPart, Links], Share]) -> tuple[Interval, ...]:
    """Return the intervals of the cells of a zone, (nx, 1); share_of: the law of their edges."""
    if not zone.any():
        return ()
    part = CellPart.around(zone, grid)
    inside = part.inside.reshape(-1, part.width)[:, MARGIN_CELLS]
    before = np.flatnonzero(inside[1:] != inside[:-1])  # the last cells before an edge: outside, inside, outside, ..
    starts = np.arange(before.size) % 2 == 0
    inner, outer = before + starts, before + ~starts
    links = Links(
        inner * part.width + MARGIN_CELLS,
        outer * part.width + MARGIN_CELLS,
        along_y=np.zeros(before.size, bool),
        length=np.full(before.size, grid.dx),
    )
    lever = np.full(before.size, LEVER_ALONG)
    beyond = share_of(part, links)(lever) - inset_by(lever)
    beyond[np.isnan(beyond)] = 0.5  # where no smooth front fits: at the grid's end, at a sharp edge, in few cells
    edges = part.corner[0] + grid.dx * (inner + (outer - inner) * beyond)
    # both laws may see an edge past the middle of a cell that is alone: then nothing is left of it
    found = edges.reshape(-1, 2)
    crossed = found[:, 0] > found[:, 1]
    found[crossed] = found[crossed].mean(axis=1, keepdims=True)
    return tuple((left, right) for left, right in found.tolist())
