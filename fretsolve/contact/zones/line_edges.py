"""Edges of a line contact and of its stick zone to a small part of a cell, from the fields of one increment."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.contact.zones.edge_law import LEVER_ALONG, EdgeLaw, ZoneFields, inset_by
from fretsolve.contact.zones.zone_cells import MARGIN_CELLS, Links, ZoneCells
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.materials import Compliances
from fretsolve.result.state import Zone

Interval = tuple[float, float]


@dataclass(frozen=True)
class LineZones:
    """Intervals (mm) of a line contact: those in contact and those that stick, each from left to right."""

    contact: tuple[Interval, ...] = ()
    stick: tuple[Interval, ...] = ()


def width(intervals: tuple[Interval, ...]) -> float:
    """Return the length (mm) of intervals together."""
    return math.fsum(right - left for left, right in intervals)


def line_zones(fields: ZoneFields, grid: LineGrid, materials: Compliances) -> LineZones:
    """Return the zones of an increment. fields: (nx, 1), shear and slip (2, nx, 1)."""
    contact = fields.zone != Zone.OPEN
    if not contact.any():
        return LineZones()
    zones = fields.zones(contact)
    part = ZoneCells.around(zones, grid)
    inside = part.inside[:, :, part.beyond]
    zone, before = (inside[:, 1:] != inside[:, :-1]).nonzero()  # the last cells before an edge: outside, inside, ..
    starts = np.arange(before.size) % 2 == 0
    inner, outer = before + starts, before + ~starts
    links = Links(
        zone,
        inner * part.width + part.beyond,
        outer * part.width + part.beyond,
        along_y=np.zeros(before.size, bool),
        length=np.full(before.size, grid.dx),
    )
    lever = np.full(before.size, LEVER_ALONG)
    beyond = EdgeLaw(part, links, fields, materials).shares(lever) - inset_by(lever)
    beyond[np.isnan(beyond)] = 0.5  # where no smooth front fits: at the grid's end, at a sharp edge, in few cells
    corner = np.array([part.corner(number)[0] for number in range(len(zones))])
    first = part.first[0] - MARGIN_CELLS
    edges = corner[zone] + grid.dx * (inner - first[zone] + (outer - inner) * beyond)
    # both laws may see an edge past the middle of a cell that is alone: then nothing is left of it
    found = edges.reshape(-1, 2)
    crossed = found[:, 0] > found[:, 1]
    found[crossed] = found[crossed].mean(axis=1, keepdims=True)
    intervals: tuple[tuple[Interval, ...], ...] = tuple(
        tuple((left, right) for left, right in found[zone[::2] == number].tolist()) for number in range(len(zones))
    )
    return LineZones(intervals[0], intervals[-1] if fields.sticks else ())
