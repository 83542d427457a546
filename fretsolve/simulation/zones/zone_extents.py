"""Extents of the contact and of its stick zone along x and y to a small part of a cell, from their edges.

A zone reaches as far as the farthest of the points at which its edge crosses links along x, or along y (`zone_edges`).
Each row of cells has such a point on either side. The farthest one and those in the rows beside it lie on a parabola,
whose vertex may be between the rows' middles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fretsolve.simulation.zones.cell_front import MARGIN_CELLS
from fretsolve.simulation.zones.zone_edges import ZoneEdge
from fretsolve.system.arrays import FloatArray


class Extent(NamedTuple):
    """Half of a zone's width along x and y, and the middle of that width (mm); without a zone 0 and NaN."""

    half_width_x: float = 0.0
    half_width_y: float = 0.0
    center_x: float = math.nan
    center_y: float = math.nan


def zone_extent(edge: ZoneEdge | None) -> Extent:
    """Return the extent of the zone inside an edge."""
    if edge is None:
        return Extent()
    part, front, (dx, dy), (x, y) = edge.part, edge.front, edge.part.spacing, edge.part.corner
    links, width = front.links, part.width
    # the outer cells' places along their links, from the part's middle, in which the zone's own is, too
    row, column = np.divmod(links.outer, width)
    across = links.along_y.view(np.uint8)
    middle = np.array([0.5 * (part.inside.size // width - 1), 0.5 * (width - 1)])
    place = np.where(links.along_y, column, row) - middle[across]
    # crossings within two cells of the zone's ends, which are MARGIN_CELLS from the part's
    depth = (middle + (1.0 - MARGIN_CELLS))[across] - np.abs(place)
    near = (depth < 1.5).nonzero()[0]
    depth = depth[near]
    beyond = edge.shares.ravel()[front.crossed[near]] - edge.inset[front.square[near]] - depth
    # the farthest crossing of each row, towards -x, +x, -y, +y, in cells beyond the zone's outermost middles
    line, towards = np.where(links.along_y, row, column)[near], 2 * across[near] + (place[near] > 0.0)
    ends = np.full((4, int(line.max()) + 2), -math.inf)
    np.fmax.at(ends, (towards, line), beyond)
    if (unknown := np.isnan(beyond)).any():  # where no smooth edge fits
        unknown &= ends[towards, line] == -math.inf
        np.maximum.at(ends, (towards[unknown], line[unknown]), 0.5 - depth[unknown])
    low_x, high_x, low_y, high_y = _farthest(ends).tolist()
    half_x, half_y = middle - MARGIN_CELLS
    return Extent(
        dx * float(half_x + 0.5 * (low_x + high_x)),
        dy * float(half_y + 0.5 * (low_y + high_y)),
        x + dx * float(middle[0] + 0.5 * (high_x - low_x)),
        y + dy * float(middle[1] + 0.5 * (high_y - low_y)),
    )


def _farthest(ends: FloatArray) -> FloatArray:
    """Return how far a zone reaches, (4,), from where it ends in each row, (4, n), -inf where not near its own end.

    A row and those beside it, which end no farther, lie on a parabola, whose vertex may be between their middles. That
    of each such row counts, so that rounding does not decide between rows which end alike.
    """
    before, most, after = ends[:, :-2], ends[:, 1:-1], ends[:, 2:]
    with np.errstate(invalid="ignore"):
        back, ahead = most - before, most - after
        both = back + ahead
    curved = (back >= 0.0) & (ahead >= 0.0) & (both > 0.0) & (both < math.inf)
    farthest = most.copy()
    farthest[curved] += (ahead[curved] - back[curved]) ** 2 / (8.0 * both[curved])  # at a corner there is no more
    return np.asarray(farthest.max(axis=1))
