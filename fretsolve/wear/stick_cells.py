"""The error of a worn volume by a stick zone that consists of whole cells.

Nothing wears where cells stick, and they go on sticking, so that wear follows the stick zone of the grid, whose area is
that of its cells. The worn limit of partial slip says what a little more or less of it changes.
"""

from __future__ import annotations

import math

from fretsolve.reference.worn_contact import WornLimit

INSET = 0.11
"""Radius of the area of the cells that stick less that of the zone they stand for, over a cell's side. Worn limits and
volumes at T = 10 on 75 grids of 32 to 128 points a side give 0.10 to 0.12."""

SPREAD = 0.04
"""Cells by which that radius is known. With it the estimate is at least the error in all of 32 scenes by which it was
not chosen, and twice the error in the median. They have nu = 0 and 3 to 17 cells per stick radius."""

SCATTER_CENTRED, SCATTER = 0.2, 0.1
"""Expected error of the stick radius over a cell's side, times the root of the cells in it: root mean square where the
contact's middle lies on a corner of cells or in the middle of one, so that eight cells change at once; elsewhere. For
four such places on 27 to 43 grids each 0.06 to 0.13."""

MOST_SCATTER = 0.9
"""The same over the stick radius, at most."""


def error_by_stick_cells(limit: WornLimit, volume: float, cells: int, side: float, *, load_kept: bool) -> float | None:
    """Return the estimated error of a worn volume (mm^3), by `cells` of `side` (mm) that stick.

    limit: the worn limit that the wear leads to, with P or else the approach held. None where too few cells stick.
    """
    zone = math.sqrt(cells / math.pi) * side - INSET * side
    farther = zone + math.copysign(SPREAD * side, zone - limit.stick_radius)
    return _change(limit, volume, farther, load_kept) if farther > 0.0 else None


def expected_error(limit: WornLimit, volume: float, side: float, *, centred: bool, load_kept: bool) -> float:
    """Return the error of a worn volume (mm^3) to expect from cells of `side` (mm), as a root mean square.

    centred: whether the contact's middle lies on a corner of cells, or in the middle of one.
    """
    c = limit.stick_radius
    scatter = (SCATTER_CENTRED if centred else SCATTER) * side * math.sqrt(side / c)
    return _change(limit, volume, c - min(scatter, MOST_SCATTER * c), load_kept)


def _change(limit: WornLimit, volume: float, zone: float, load_kept: bool) -> float:
    """Return how much another stick radius, `zone`, changes a worn volume: by its part of the limit less than there."""
    change = limit.with_stick_radius(zone, load_kept=load_kept).volume - limit.volume
    return abs(change) * min(1.0, volume / limit.volume) ** 2
