"""Edges of a line contact and of its stick zone to a small part of a cell, from the fields of one increment.

The laws are those of `zone_edges` for a front along the cells: by pressure and gap at the edge of contact (T16), by the
reserve of shear and the slip where the stick zone shrinks, and by the reserve alone where it grows (T17).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.rounding import TINY
from fretsolve.model.grid import LineGrid
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.simulation.zone_edges import (
    AT_THE_LIMIT,
    GAINED,
    GAINED_BEYOND,
    INSET,
    LEVER,
    LEVER_ALONG,
    LIKE_A_ROOT,
    RATIO,
    RATIO_INSET,
    STEEP,
    STEEPEST,
    TRUST,
    share_by_slip,
)
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

EDGE_INSET = INSET + math.log(LEVER / LEVER_ALONG) / 6.0
"""Inset in cells of a front along the cells."""

Interval = tuple[float, float]


@dataclass(frozen=True)
class LineZones:
    """Intervals (mm) of a line contact: those in contact and those that stick, each from left to right."""

    contact: tuple[Interval, ...]
    stick: tuple[Interval, ...]


def width(intervals: tuple[Interval, ...]) -> float:
    """Return the length (mm) of intervals together."""
    return math.fsum(right - left for left, right in intervals)


def line_zones(
    pressure: FloatArray,
    gap: FloatArray,
    shear: FloatArray,
    limit: FloatArray,
    slip: FloatArray,
    zone: NDArray[np.uint8],
    grid: LineGrid,
    materials: Compliances,
) -> LineZones:
    """Return the zones of an increment. slip: its slip increment, (2, nx, 1); limit: of friction
    (MPa); the others (nx, 1), shear (2, nx, 1)."""
    load, states = pressure[:, 0].astype(np.float64), zone[:, 0]
    opening = materials.contact_modulus * np.maximum(gap[:, 0], 0.0)
    of_contact = _Edges(load, opening, states != Zone.OPEN, grid)
    contact = of_contact.intervals(of_contact.share)
    sticking, slipping = states == Zone.STICK, states == Zone.SLIP
    if not sticking.any() or not slipping.any():
        return LineZones(contact, contact if sticking.any() else ())
    reserve = np.maximum(limit[:, 0] - np.hypot(shear[0, :, 0], shear[1, :, 0]), 0.0)
    moved = np.hypot(materials.contact_modulus * slip[0, :, 0], 2.0 / materials.torsional * slip[1, :, 0])
    of_stick = _Edges(reserve, moved, sticking, grid)

    def share(inner: int, outer: int) -> float:
        if not 0 <= outer < grid.nx or not slipping[outer]:
            return of_contact.share(inner, outer)
        if reserve[inner] <= AT_THE_LIMIT * limit[inner, 0]:
            past = np.clip(outer + np.arange(3) * (outer - inner), 0, grid.nx - 1)
            found = float(share_by_slip(*moved[past, None])[0])
            return 0.5 if math.isnan(found) else found
        return of_stick.moving_share(inner, outer)

    return LineZones(contact, of_stick.intervals(share))


@dataclass(frozen=True)
class _Edges:
    """Edges of the cells `inside`, by their `load` and the `opening` (MPa mm) past them; all (nx,)."""

    load: DoubleArray
    opening: DoubleArray
    inside: BoolArray
    grid: LineGrid

    def intervals(self, share: Callable[[int, int], float]) -> tuple[Interval, ...]:
        """Return the intervals inside; share: from an inner and an outer cell to the distance of the edge in cells."""
        changes = np.diff(np.concatenate([[False], self.inside, [False]]).astype(np.int8))
        firsts, lasts = np.flatnonzero(changes > 0).tolist(), (np.flatnonzero(changes < 0) - 1).tolist()
        x, side = self.grid.x, self.grid.dx
        return tuple(
            (float(x[first]) - share(first, first - 1) * side, float(x[last]) + share(last, last + 1) * side)
            for first, last in zip(firsts, lasts, strict=True)
        )

    def share(self, inner: int, outer: int) -> float:
        """Return the distance of the edge from the inner centre in cells: where load and opening balance.

        Half a cell where no smooth front fits: at the grid's end, at a body's sharp edge, in zones of a few cells.
        """
        found = self._balance(inner, outer)
        return 0.5 if math.isnan(found) else found - EDGE_INSET

    def moving_share(self, inner: int, outer: int) -> float:
        """Return the same at the edge of a stick zone, by the load alone where it has gained cells or moved little."""
        found, step = self._balance(inner, outer), inner - outer
        behind = [inner + k * step for k in range(4)]
        if 0 <= behind[-1] < self.grid.nx and self.inside[behind].all() and self.load[behind[0]] < self.load[behind[1]]:
            first, second, third, fourth = self.load[behind].tolist()
            if second <= LIKE_A_ROOT * third and third < STEEP * fourth and first < second / 2.0**GAINED:
                ratio = (first / second) ** (1.0 / GAINED)
                return float(ratio / (1.0 - ratio) + GAINED_BEYOND - EDGE_INSET)
            if second > LIKE_A_ROOT * third and third > LIKE_A_ROOT * fourth and not math.isnan(found):
                expected: float = first / (second - RATIO * first) - RATIO_INSET
                excess = found - expected
                found = max(expected + min(excess, max(2.0 * TRUST - excess, 0.0)), 0.0)
        return 0.5 if math.isnan(found) else found - EDGE_INSET

    def _balance(self, inner: int, outer: int) -> float:
        """Return the share of the link at which both balance; NaN where no smooth front fits."""
        if not 0 <= outer < self.grid.nx:
            return math.nan
        near = range(max(inner - 1, 1), min(inner + 2, self.grid.nx - 1))
        deep = [self.load[cell] for cell in near if self.inside[cell - 1 : cell + 2].all()]
        opened = LEVER_ALONG * float(self.opening[outer])
        if opened > STEEPEST * self.grid.dx * max(deep, default=0.0):
            return math.nan
        carried = float(self.load[inner]) * self.grid.dx
        return carried / max(carried + opened, TINY)
