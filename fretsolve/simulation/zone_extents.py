"""Extents of the contact and of its stick zone along x and y to a small part of a cell, from their edges.

A zone reaches as far as the farthest of the points at which its edge crosses links along x, or along y (`zone_edges`).
Each row of cells has such a point on either side. The farthest one and those in the rows beside it lie on a parabola,
whose vertex may be between the rows' middles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fretsolve.simulation.zone_edges import INSET, LEVER, MARGIN_CELLS, ZoneEdge


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
    part, front, down = edge.part, edge.front, edge.part.strides[0]
    size = part.inside.size // down, down
    # crossings within two cells of the zone's ends, which are MARGIN_CELLS from the part's
    links, ahead = front.links, front.links.outer > front.links.inner
    row = links.inner // down
    column = links.inner - row * down
    place = np.where(links.along_y, column, row)
    depth = np.where(ahead, np.where(links.along_y, size[1], size[0]) - 1 - place, place) - MARGIN_CELLS
    near = np.flatnonzero(depth < 2)
    # their shares inside; NaN, where no smooth edge fits, comes last
    share = edge.shares.ravel()[front.crossed[near]] - INSET - np.log(LEVER / edge.lever[front.square[near]]) / 6.0
    order = np.argsort(share)
    near, share = near[order], share[order]
    # the farthest crossing of each row, towards -x, +x, -y, +y, in cells beyond the zone's outermost middles
    rows: list[dict[int, float]] = [{}, {}, {}, {}]
    direction, line = 2 * links.along_y[near] + ahead[near], (row + column - place)[near]
    for towards, number, inside, cells in zip(
        direction.tolist(), line.tolist(), share.tolist(), depth[near].tolist(), strict=True
    ):
        ends = rows[towards]
        if not math.isnan(inside):
            ends[number] = max(inside - cells, ends.get(number, -math.inf))
        elif number not in ends:  # cells are counted
            ends[number] = 0.5 - cells
    low_x, high_x, low_y, high_y = map(_farthest, rows)
    ends_x = MARGIN_CELLS - low_x, size[0] - 1 - MARGIN_CELLS + high_x
    ends_y = MARGIN_CELLS - low_y, size[1] - 1 - MARGIN_CELLS + high_y
    (dx, dy), (x, y) = part.spacing, part.corner
    return Extent(
        0.5 * dx * (ends_x[1] - ends_x[0]),
        0.5 * dy * (ends_y[1] - ends_y[0]),
        x + 0.5 * dx * (ends_x[0] + ends_x[1]),
        y + 0.5 * dy * (ends_y[0] + ends_y[1]),
    )


def _farthest(rows: dict[int, float]) -> float:
    """Return how far a zone reaches, from where it ends in each row of cells near its end."""
    row = max(rows, key=rows.__getitem__)
    most = rows[row]
    if row - 1 not in rows or row + 1 not in rows:  # at a corner, not on a curved edge
        return most
    back, ahead = most - rows[row - 1], most - rows[row + 1]
    return most + (ahead - back) ** 2 / (8.0 * (ahead + back)) if ahead + back else most
