"""Places of edges on the links that they cross: shares inside by pressure and gap, or by shear traction and slip.

The fields place the edge of the contact, and of a stick zone that shrinks, on the link between the centres of an inner
and an outer cell by (T16) of docs/theory.md, less an inset along its normal; the factor kappa is here the lever. For an
edge along the cells this holds to 2e-4 of their side h, with a lever of 0.58 and an inset of 0.175 h; in any direction
to 0.02 of h, and to 0.002 on average, with the constants below, measured on Hertz contacts on grids of 128 to 512 cells
a side. For the stick zone the reserve, by which the shear traction is below the friction limit, takes the place of the
pressure, and slip that of the gap: the slip increment, or all the slip so far where the inner cell never slipped.

No smooth front fits along a body's sharp edge, and in contacts so small that no cell has its neighbours with it. The
reserve behind the front gives its place if there is less slip than belongs to the shear traction, as when the front
moves by less than a cell in an increment, and if the stick zone grows (T17). For a front that moves in it counts along
the traction past it, since the cells behind may still have that of an earlier load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretsolve.kernels.zone_laws import (
    AT_THE_LIMIT,
    GAINED,
    GAINED_BEYOND,
    HARDLY,
    INSET,
    LEVER,
    LIKE_A_ROOT,
    OF_THE_WHOLE,
    RATIO,
    RATIO_INSET,
    STEEP,
    STEEPEST,
    TRUST,
    UNLIKE,
)
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.simulation.zones.cell_front import CellPart, Links, Share
from fretsolve.system.arrays import TINY, BoolArray, FloatArray, IndexArray, vector_lengths

ROWS_AROUND, COLUMNS_AROUND = np.indices((3, 3)).reshape(2, 9, 1) - 1
"""Steps along x and y from a cell to those around it."""


class ZoneFields(NamedTuple):
    """The fields of an increment that its zones follow from.

    pressure (MPa), gap (mm, may be infinite), limit, the friction coefficient times the pressure (MPa), and zone, as
    `Zone`: (nx, ny); shear (MPa), slip, the slip increment (mm), and slip_before, the slip accumulated before that
    (mm): (2, nx, ny).
    """

    pressure: FloatArray
    gap: FloatArray
    shear: FloatArray
    limit: FloatArray
    slip: FloatArray
    zone: NDArray[np.uint8]
    slip_before: FloatArray


def contact_share(part: CellPart, links: Links, pressure: FloatArray, gap: FloatArray, materials: Compliances) -> Share:
    """Return the shares at the edge of the contact, by pressure (MPa) and gap (mm, may be infinite): (nx, ny)."""
    load, gap = part.cut(pressure, 0.0), part.cut(gap, np.inf)[links.outer]
    return _balance(part, links, load, materials.contact_modulus * np.maximum(gap, 0.0))


def stick_share(part: CellPart, links: Links, fields: ZoneFields, materials: Compliances) -> Share:
    """Return the shares at the edge of the stick zone, past which cells slip or are open."""
    to_slip = part.cut(fields.zone == Zone.SLIP, False)[links.outer].nonzero()[0]
    if to_slip.size == links.outer.size:
        return _slip_share(part, links, fields, materials)
    share = contact_share(part, links, fields.pressure, fields.gap, materials)
    if not to_slip.size:
        return share
    return _replaced(share, to_slip, _slip_share(part, links.some(to_slip), fields, materials))


def _slip_share(part: CellPart, links: Links, fields: ZoneFields, materials: Compliances) -> Share:
    """Return the shares by slip and the reserve of shear below the limit.

    The modulus is the contact modulus for a front across the slip, and that of antiplane shear for one along it.
    """
    friction_limit, slip_x, slip_y = (part.cut(field, 0.0) for field in (fields.limit, *fields.slip))
    reserve = np.maximum(friction_limit - part.cut(vector_lengths(fields.shear), 0.0), 0.0)
    inner, outer = links.inner, links.outer
    across, along = materials.contact_modulus, 2.0 / materials.torsional
    modulus_x, modulus_y = np.where(links.along_y, along, across), np.where(links.along_y, across, along)
    opening = _opening(part, links, (slip_x, slip_y), fields.slip_before, (modulus_x, modulus_y))
    share = _balance(part, links, reserve, opening)
    behind = inner + np.arange(4)[:, None] * (inner - outer)
    known = part.inside.take(behind).all(axis=0)
    reserves, onward = reserve[behind], _onward(part, links, fields.shear, friction_limit, behind)
    first, second, third, fourth = reserves
    receding = known & (onward[0] < onward[1]) & (_like_a_root(reserves) | _like_a_root(onward))
    growing = known & (second <= LIKE_A_ROOT * third) & (third < STEEP * fourth)
    growing &= first < second / 2.0**GAINED  # where the front is within the link
    # most increments have only one of these kinds of front
    if receding.any():
        expected = onward[0] / np.where(receding, onward[1] - RATIO * onward[0], np.inf) - RATIO_INSET
        share = _trusted(share, receding, expected)
    if growing.any():
        places = growing.nonzero()[0]
        ratio = (first[places] / second[places]) ** (1.0 / GAINED)
        gained = ratio / (1.0 - ratio) + GAINED_BEYOND
        share = _replaced(share, places, lambda lever: gained)
    at_limit = (first <= AT_THE_LIMIT * friction_limit[inner]).nonzero()[0]
    if not at_limit.size:
        return share
    past = outer[at_limit] + np.arange(3)[:, None] * (outer - inner)[at_limit]
    inside = _share_by_slip(*np.hypot(slip_x[past], slip_y[past]))
    return _replaced(share, at_limit, lambda lever: inside + inset_by(lever))


def _like_a_root(reserves: FloatArray) -> BoolArray:
    """Return whether the reserves (4, k) of the cells behind a front go like those behind one that has moved in."""
    first, second, third, fourth = reserves
    found: BoolArray = (first < second) & (second > LIKE_A_ROOT * third) & (third > LIKE_A_ROOT * fourth)
    return found


def _onward(part: CellPart, links: Links, shear: FloatArray, limit: FloatArray, behind: IndexArray) -> FloatArray:
    """Return the reserves (4, k) of the cells `behind` each link along the shear traction past it.

    shear: (2, nx, ny); limit: the part's friction limits. Those cells may still have the traction of an earlier load,
    as when that is taken back in part.
    """
    x, y = (part.cut(field, 0.0) for field in shear)
    past_x, past_y = x[links.outer], y[links.outer]
    past = np.maximum(np.hypot(past_x, past_y), TINY)
    x, y = x[behind], y[behind]
    along = (x * past_x + y * past_y) / past
    left = limit[behind] ** 2 - (x * x + y * y) + along * along
    found: FloatArray = np.maximum(np.sqrt(np.maximum(left, 0.0)) - along, 0.0)
    return found


def _opening(
    part: CellPart,
    links: Links,
    slip: tuple[FloatArray, FloatArray],
    slip_before: FloatArray,
    moduli: tuple[FloatArray, FloatArray],
) -> FloatArray:
    """Return the slip past the front that belongs to the reserve, times the moduli along x and y, (k,).

    slip: increments of the part's cells along x and y; slip_before: accumulated before, (2, nx, ny).
    """
    inner, outer = links.inner, links.outer
    (x, inner_x), (y, inner_y) = ((field[outer], field[inner]) for field in slip)
    before_x, before_y = (part.cut(field, 0.0) for field in slip_before)
    all_x, all_y = before_x[outer] + x, before_y[outer] + y
    inner_x, inner_y = before_x[inner] + inner_x, before_y[inner] + inner_y
    squared = x * x + y * y
    never_slipped = inner_x * inner_x + inner_y * inner_y <= HARDLY**2 * squared
    whole = never_slipped & (all_x * x + all_y * y >= OF_THE_WHOLE * squared)
    opening: FloatArray = np.hypot(moduli[0] * np.where(whole, all_x, x), moduli[1] * np.where(whole, all_y, y))
    return opening


def _trusted(share: Share, receding: BoolArray, expected: FloatArray) -> Share:
    """Return `share` with the values of `receding` links (k,) replaced as far as they exceed those `expected`."""

    def trusted(lever: FloatArray) -> FloatArray:
        found = share(lever)
        excess = found - expected
        nearer = np.maximum(expected + np.minimum(excess, np.maximum(2.0 * TRUST - excess, 0.0)), 0.0)
        return np.where(receding, nearer, found)

    return trusted


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
    around = links.inner + (ROWS_AROUND * part.width + COLUMNS_AROUND)
    steepest = STEEPEST * links.length * (load * part.deep).take(around).max(axis=0)
    carried = load[links.inner] * links.length

    def share(lever: FloatArray) -> FloatArray:
        opened = lever * opening
        found: FloatArray = carried / np.maximum(carried + opened, TINY)
        found[opened > steepest] = np.nan
        return found

    return share
