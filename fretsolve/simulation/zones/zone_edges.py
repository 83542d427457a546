"""Edges of the contact and of its stick zone to a small part of a cell, from the fields of one increment.

The fields place the edge of the contact, and of a stick zone that shrinks, on the link between the centres of an inner
and an outer cell by (T16) of docs/theory.md, less an inset along its normal; the factor kappa is here the lever. For an
edge along the cells this holds to 2e-4 of their side h, with a lever of 0.58 and an inset of 0.175 h; in any direction
to 0.02 of h, and to 0.002 on average, with the constants below, measured on Hertz contacts on grids of 128 to 512 cells
a side. For the stick zone the reserve, by which the shear traction is below the friction limit, takes the place of the
pressure, and the slip increment that of the gap.

No smooth front fits along a body's sharp edge, and in contacts so small that no cell has its neighbours with it. The
reserve behind the front gives its place if there is less slip than belongs to the shear traction, as when the front
moves by less than a cell in an increment, and if the stick zone grows (T17).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.rounding import TINY
from fretsolve.model.grid import Grid
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray, vector_lengths

Number = TypeVar("Number", bound=np.generic)
Pair = tuple[int, int]

Share = Callable[[FloatArray], FloatArray]
"""Shares inside of the links of a front, given their levers; NaN if no smooth front fits."""

LEVER, LEVER_ALONG, LEVER_SLANTING, LEVER_MOST = 0.9, 0.58, 0.5, 0.94
"""The lever of a front at an angle t to the cells is LEVER_ALONG + LEVER_SLANTING sin 2t, but no more than LEVER_MOST;
LEVER is used while the angle is unknown."""

INSET = 0.104
"""Inset in cells for the lever LEVER, the same in all directions. Another lever moves the share by a sixth of the
logarithm of their ratio, averaged over the front's places within a cell, which the inset corrects."""

STEEPEST = 2.0
"""Limit of lever E* g over h times the largest pressure behind the front. Smooth fronts have at most 1.6, sharp edges
far more."""

RATIO, RATIO_INSET, TRUST = 0.4245, 0.05, 0.16
"""By the reserve alone the share is r/(1 - RATIO r) less about RATIO_INSET, with r the reserve in the last cell over
that in the one behind. It holds to 2e-4 on a front along the cells (without the inset), to 0.1 on others. It begins to
replace the share by the slip if that is larger by TRUST, and has replaced it at twice that."""

LIKE_A_ROOT = 0.65
"""Farther in, r is at least 0.7 behind a front that has moved into the stick zone, or 0.61 if the front is about to
reach a cell."""

STEEP = 0.72
"""Behind the front of a stick zone that has grown over some increments, r is at most 0.55. One cell farther in it is at
most 0.65, and at least 0.78 behind other fronts."""

GAINED, GAINED_BEYOND = 1.5, 0.12
"""Behind the front of a growing stick zone the reserve goes like s^GAINED, since a singular rate of the shear traction
would exceed the friction limit. So r gives the front's place, which on the discrete grid is GAINED_BEYOND of a link
farther out. For spheres pressed on a dissimilar body, for which Spence's theory is exact, this holds to 0.02 of h on
average, and within 0.03 of that from place to place. In increments smaller than a cell, the slip shows only which cell
the front has reached."""

AT_THE_LIMIT, UNLIKE = 1e-5, 0.1
"""Reserve over the friction limit up to which a sticking cell is at the limit. Then the slip past the front, which goes
like s^(3/2) where the front has moved by some cells, gives its place: on a front along the cells to 0.08 of h. The
cells are counted where the slip of the third cell is farther from that law than the latter part of it."""

MARGIN_CELLS = 4
"""Cells kept around a zone, to which a link's share may refer."""


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


def stick_edge(
    pressure: FloatArray,
    gap: FloatArray,
    shear: FloatArray,
    limit: FloatArray,
    slip: FloatArray,
    zone: NDArray[np.uint8],
    grid: Grid,
    materials: Compliances,
    contact: ZoneEdge | None,
) -> ZoneEdge | None:
    """Return the edge of the stick zone, None without one; that of the `contact` if nothing slips.

    limit: friction coefficient times pressure (MPa), and zone: of `Zone`, both (nx, ny); shear (MPa) and slip, the
    slip increment (mm): (2, nx, ny); the others as for `contact_edge`.
    """
    sticking = zone == Zone.STICK
    if not sticking.any():
        return None
    slipping = zone == Zone.SLIP
    if not slipping.any():
        return contact
    part = CellPart.around(sticking, grid)
    front = Front.of(part)
    return ZoneEdge.placed(
        part, front, stick_share(part, front.links, pressure, gap, shear, limit, slip, slipping, materials)
    )


@dataclass(frozen=True)
class CellPart:
    """The part of a grid around a zone. Its cells are numbered row by row, ``width`` apart along x and 1 along y.

    corner: centre of the first cell (mm); is_row: whether the grid is a single row, whose edges lie along the cells;
    inside: cells of the zone; deep: those of them whose neighbours are inside too.
    """

    slices: tuple[slice, slice]
    missing: tuple[Pair, Pair]
    width: int
    spacing: tuple[float, float]
    corner: tuple[float, float]
    is_row: bool
    inside: BoolArray
    deep: BoolArray

    @classmethod
    def around(cls, zone: BoolArray, grid: Grid) -> CellPart:
        """Return the part that holds all of `zone` (nx, ny; not empty) and a margin, beyond the grid if needed."""
        rows, columns = (np.flatnonzero(zone.any(axis=1 - axis)) for axis in (0, 1))
        top, bottom = int(rows[0]) - MARGIN_CELLS, int(rows[-1]) + MARGIN_CELLS + 1
        left, right = int(columns[0]) - MARGIN_CELLS, int(columns[-1]) + MARGIN_CELLS + 1
        slices = slice(max(top, 0), bottom), slice(max(left, 0), right)
        missing = (max(-top, 0), max(bottom - grid.nx, 0)), (max(-left, 0), max(right - grid.ny, 0))
        inside = _with_border(zone[slices], missing, False)
        deep = inside.copy()  # the margin lies outside of the zone
        if grid.nx > 1:
            deep[1:-1] &= inside[2:] & inside[:-2]
        if grid.ny > 1:  # a single row of cells, as in line contact, has neighbours along x alone
            deep[:, 1:-1] &= inside[:, 2:] & inside[:, :-2]
        x, y = grid.x0 + (top - (grid.nx - 1) / 2) * grid.dx, grid.y0 + (left - (grid.ny - 1) / 2) * grid.dy
        width, spacing, corner, is_row = inside.shape[1], (grid.dx, grid.dy), (float(x), float(y)), 1 in grid.shape
        return cls(slices, missing, width, spacing, corner, is_row, inside.ravel(), deep.ravel())

    def cut(self, field: NDArray[Number], beyond: float) -> NDArray[Number]:
        """Return the part's cells of a field (nx, ny), in one row; `beyond` past the grid's border."""
        return _with_border(field[self.slices], self.missing, beyond).ravel()


def _with_border(cells: NDArray[Number], missing: tuple[Pair, Pair], beyond: float) -> NDArray[Number]:
    """Return `cells` with `missing` rows and columns around them. NumPy's `pad` takes five times as long."""
    (above, below), (left, right) = missing
    if not above + below + left + right:
        return cells
    rows, columns = cells.shape
    whole = np.full((above + rows + below, left + columns + right), beyond, cells.dtype)
    whole[above : above + rows, left : left + columns] = cells
    return whole


@dataclass(frozen=True)
class Links:
    """Links (k,) from an inner to an outer cell. along_y: those along y; length: between the cells' centres (mm)."""

    inner: IndexArray
    outer: IndexArray
    along_y: BoolArray
    length: FloatArray

    def some(self, chosen: IndexArray) -> Links:
        """Return the links of these numbers."""
        return Links(self.inner[chosen], self.outer[chosen], self.along_y[chosen], self.length[chosen])


@dataclass(frozen=True)
class Front:
    """The n squares between four centres that the edge of a zone crosses.

    count: how many of the four cells are inside, (n,); opposite: these are two that do not touch, (n,); whole: number
    of squares all inside; starts: shares inside of each square's two links along x and two along y, (4, n), 1 or 0;
    crossed: places in `starts` of the `links` that the edge crosses; square: the square of each of these, from 0.
    """

    count: NDArray[np.uint8]
    opposite: BoolArray
    whole: int
    starts: FloatArray
    crossed: IndexArray
    square: IndexArray
    links: Links

    @classmethod
    def of(cls, part: CellPart) -> Front:
        """Return the front of the part's zone."""
        width, (dx, dy) = part.width, part.spacing
        cells = part.inside.view(np.uint8)
        # squares by their first corner; one that wraps round to the next row lies in the margin, outside
        count = cells[: -width - 1] + cells[1:-width] + cells[width:-1] + cells[width + 1 :]
        corner, whole = np.flatnonzero((count - 1) < 3), int(np.count_nonzero(count == 4))  # unsigned: 0 becomes large
        count = count[corner]
        near, right, ahead, across = cells.take(corner + np.array([[0], [1], [width], [width + 1]]))
        starts, ends = np.array([near, right, near, ahead]), np.array([ahead, across, right, across])
        crossed = np.flatnonzero(starts != ends)
        side, square = np.divmod(crossed, corner.size)
        along_y = side >= 2
        first = corner[square] + np.array([0, 1, 0, width])[side]
        second = first + np.where(along_y, 1, width)
        from_first = starts.ravel()[crossed] != 0
        inner, outer = np.where(from_first, first, second), np.where(from_first, second, first)
        links = Links(inner, outer, along_y, np.where(along_y, dy, dx))
        opposite = (count == 2) & (near == across)
        return cls(count, opposite, whole, starts.astype(np.float64), crossed, square, links)

    def shares(self, lever: FloatArray, share: Share) -> FloatArray:
        """Return the shares inside of the links of each square, (4, n); lever: of each square, (n,)."""
        shares = self.starts.copy()
        shares.ravel()[self.crossed] = share(lever[self.square])
        return shares


def contact_share(part: CellPart, links: Links, pressure: FloatArray, gap: FloatArray, materials: Compliances) -> Share:
    """Return the shares at the edge of the contact, by pressure and gap as for `contact_edge`."""
    load, gap = part.cut(pressure, 0.0), part.cut(gap, np.inf)[links.outer]
    return _balance(part, links, load, materials.contact_modulus * np.maximum(gap, 0.0))


def stick_share(
    part: CellPart,
    links: Links,
    pressure: FloatArray,
    gap: FloatArray,
    shear: FloatArray,
    limit: FloatArray,
    slip: FloatArray,
    slipping: BoolArray,
    materials: Compliances,
) -> Share:
    """Return the shares at the edge of the stick zone, past which cells slip or are open; see `stick_edge`."""
    to_slip = np.flatnonzero(part.cut(slipping, False)[links.outer])
    if to_slip.size == links.outer.size:
        return _slip_share(part, links, limit, shear, slip, materials)
    share = contact_share(part, links, pressure, gap, materials)
    if not to_slip.size:
        return share
    return _replaced(share, to_slip, _slip_share(part, links.some(to_slip), limit, shear, slip, materials))


def _slip_share(
    part: CellPart, links: Links, limit: FloatArray, shear: FloatArray, slip: FloatArray, materials: Compliances
) -> Share:
    """Return the shares by slip and the reserve of shear below the limit.

    The modulus is the contact modulus for a front across the slip, and that of antiplane shear for one along it.
    """
    friction_limit, slip_x, slip_y = (part.cut(field, 0.0) for field in (limit, *slip))
    reserve = np.maximum(friction_limit - part.cut(vector_lengths(shear), 0.0), 0.0)
    inner, outer = links.inner, links.outer
    across, along = materials.contact_modulus, 2.0 / materials.torsional
    modulus_x, modulus_y = np.where(links.along_y, along, across), np.where(links.along_y, across, along)
    opening = np.hypot(modulus_x * slip_x[outer], modulus_y * slip_y[outer])
    by_slip = _balance(part, links, reserve, opening)
    behind = inner + np.arange(4)[:, None] * (inner - outer)
    first, second, third, fourth = reserve.take(behind)
    known = part.inside.take(behind).all(axis=0) & (first < second)
    receding = known & (second > LIKE_A_ROOT * third) & (third > LIKE_A_ROOT * fourth)
    growing = known & (second <= LIKE_A_ROOT * third) & (third < STEEP * fourth)
    growing &= first < second / 2.0**GAINED  # where the front is within the link
    expected = first / np.where(receding, second - RATIO * first, np.inf) - RATIO_INSET
    ratio = (np.where(growing, first, 0.0) / np.where(growing, second, 1.0)) ** (1.0 / GAINED)
    gained = ratio / (1.0 - ratio) + GAINED_BEYOND

    def share(lever: FloatArray) -> FloatArray:
        found = by_slip(lever)
        excess = found - expected
        trusted = np.maximum(expected + np.minimum(excess, np.maximum(2.0 * TRUST - excess, 0.0)), 0.0)
        return np.where(growing, gained, np.where(receding, trusted, found))

    at_limit = np.flatnonzero(first <= AT_THE_LIMIT * friction_limit[inner])
    if not at_limit.size:
        return share
    past = outer[at_limit] + np.arange(3)[:, None] * (outer - inner)[at_limit]
    inside = _share_by_slip(*np.hypot(slip_x[past], slip_y[past]))
    return _replaced(share, at_limit, lambda lever: inside + inset_by(lever))


def _replaced(share: Share, places: IndexArray, other: Share) -> Share:
    """Return `share` with the values at some links, their `places`, from another one of these."""

    def replaced(lever: FloatArray) -> FloatArray:
        found = share(lever)
        found[places] = other(lever[places])
        return found

    return replaced


def inset_by(lever: FloatArray) -> FloatArray:
    """Return the inset of an edge in cells."""
    inset: FloatArray = INSET + np.log(LEVER / lever) / 6.0
    return inset


def _share_by_slip(first: FloatArray, second: FloatArray, third: FloatArray) -> FloatArray:
    """Return the shares inside, without an inset, from the slips of the three cells past a front, (k,).

    NaN where they do not go like s^(3/2), as past a front that has moved by a cell or less.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (first / second) ** (2.0 / 3.0)
        beyond = ratio / (1.0 - ratio)
        expected = second * ((beyond + 2.0) / (beyond + 1.0)) ** 1.5
    fits = (ratio < 1.0) & (beyond <= 1.25) & (np.abs(third - expected) <= UNLIKE * expected)
    return np.where(fits, 1.0 - beyond, np.nan)


def _balance(part: CellPart, links: Links, load: FloatArray, opening: FloatArray) -> Share:
    """Return the shares at which the inner cells' `load` and the `opening` past them balance; NaN if that is too large.

    load: of the part's cells; opening: at the links' outer cells, times a modulus, for a lever of 1.
    """
    around = links.inner + np.array([i * part.width + j for i in (-1, 0, 1) for j in (-1, 0, 1)])[:, None]
    steepest = STEEPEST * links.length * (load * part.deep).take(around).max(axis=0)
    carried = load[links.inner] * links.length

    def share(lever: FloatArray) -> FloatArray:
        opened = lever * opening
        found: FloatArray = carried / np.maximum(carried + opened, TINY)
        found[opened > steepest] = np.nan
        return found

    return share
