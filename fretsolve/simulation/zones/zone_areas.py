"""Areas of the contact and of its stick zone to a small part of a cell, from their edges.

Straight segments join the points at which an edge crosses the links between cells (`zone_edges`), one in each square
between four centres. If no smooth front fits the fields, the square's cells are counted instead.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.simulation.zones.zone_edges import ZoneEdge
from fretsolve.system.arrays import TINY, FloatArray


def zone_area(edge: ZoneEdge | None) -> float:
    """Return the area (mm^2) inside an edge, from the squares between four centres: whole ones, and those it crosses.

    0 without an edge.
    """
    if edge is None:
        return 0.0
    front, (run_x, run_y), (dx, dy) = edge.front, edge.run, edge.part.spacing
    x, y = edge.shares[::2] + edge.shares[1::2]
    count = front.count
    part_inside = np.where(count <= 2, 0.5 * x * y, 1.0 - 0.5 * (2.0 - x) * (2.0 - y))
    fits = ~(front.opposite | np.isnan(part_inside))
    ones, twos, threes = np.bincount(count[fits], minlength=4)[1:].tolist()
    counted = (int(count.sum()) - (ones + 2 * twos + 3 * threes)) / 4.0
    area = (front.whole + counted + part_inside[fits].sum()) * dx * dy
    cell = (run_y * dx**2 + run_x * dy**2) / np.maximum(run_y * dx + run_x * dy, TINY)
    inset = edge.inset * cell
    return float(max(area - _rim(edge.length[fits], inset[fits], 0.25 * (ones - threes)), 0.0))


def _rim(length: FloatArray, inset: FloatArray, turns: float) -> float:
    """Return the area between the segments and a smooth front `inset` from them, which turns `turns` times in all.

    A curved front of length l bulges past its chord by l^3/12 times its curvature, here the mean one, and an inset d
    takes its length times d less half the angle turned times d^2.
    """
    total = float(length.sum())
    if total == 0.0:
        return 0.0
    taken = float((inset * length).sum())
    bulge = float((length**3).sum()) / (12.0 * total)
    return taken - 2.0 * math.pi * turns * (bulge + 0.5 * (taken / total) ** 2)
