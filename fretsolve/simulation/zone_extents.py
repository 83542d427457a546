"""Extents of the contact and of its stick zone along x and y to a small part of a cell, from their edges.

A zone reaches as far as the farthest of the points at which its edge crosses links along x, or along y (`zone_edges`).
There the edge is along the cells. Each row of cells has such a point on each side; the farthest one and those in the
rows beside it lie on a parabola, whose vertex is between the rows' middles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fretsolve.simulation.zone_edges import INSET, LEVER, LEVER_ALONG, ZoneEdge
from fretsolve.system.arrays import FloatArray

INSET_ALONG = INSET + math.log(LEVER / LEVER_ALONG) / 6.0
"""Inset in cells of an edge along the cells."""


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
    links = edge.front.links
    share = edge.share(np.full(links.length.shape, LEVER_ALONG))
    # where no smooth edge fits, the cells are counted
    reach = np.where(np.isnan(share), 0.5, share - INSET_ALONG) * links.length
    (rows, columns), ahead = np.divmod(links.inner, edge.part.strides[0]), links.outer > links.inner
    ends = []
    for along_y, line, place in ((False, columns, rows), (True, rows, columns)):
        axis = int(along_y)
        side, start = edge.part.spacing[axis], edge.part.corner[axis]
        low, high = (
            _farthest(line[chosen], sign * side * place[chosen] + reach[chosen], side)
            for sign, chosen in ((-1.0, (links.along_y == along_y) & ~ahead), (1.0, (links.along_y == along_y) & ahead))
        )
        ends += [start - low, start + high]
    left, right, bottom, top = map(float, ends)
    return Extent(0.5 * (right - left), 0.5 * (top - bottom), 0.5 * (left + right), 0.5 * (bottom + top))


def _farthest(line: FloatArray, reach: FloatArray, side: float) -> float:
    """Return how far an edge reaches beyond its crossings in rows of cells.

    line: number of each crossing's row, (n,); reach: its place outwards (mm), (n,); side: of a cell (mm).
    """
    farthest = int(reach.argmax())
    most, row = float(reach[farthest]), line[farthest]
    beside = [reach[line == row + step].max(initial=-math.inf) for step in (-1, 1)]
    back, ahead = (most - float(other) for other in beside)
    # A row beside it that ends more than a cell earlier belongs to a corner, not to a curved edge.
    if back + ahead == 0.0 or max(back, ahead) > side:
        return most
    return most + (ahead - back) ** 2 / (8.0 * (ahead + back))
