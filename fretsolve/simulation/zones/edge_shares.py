"""Places of edges on the links that they cross: shares inside by pressure and gap, or by shear traction and slip.

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

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.rounding import TINY
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.simulation.zones.cell_front import CellPart, Links, Share
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray, vector_lengths

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


ROWS_AROUND, COLUMNS_AROUND = np.indices((3, 3)).reshape(2, 9, 1) - 1
"""Steps along x and y from a cell to those around it."""


class ZoneFields(NamedTuple):
    """The fields of an increment that its zones follow from.

    pressure (MPa), gap (mm, may be infinite), limit, the friction coefficient times the pressure (MPa), and zone, as
    `Zone`: (nx, ny); shear (MPa) and slip, the slip increment (mm): (2, nx, ny).
    """

    pressure: FloatArray
    gap: FloatArray
    shear: FloatArray
    limit: FloatArray
    slip: FloatArray
    zone: NDArray[np.uint8]


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
    opening = np.hypot(modulus_x * slip_x[outer], modulus_y * slip_y[outer])
    by_slip = _balance(part, links, reserve, opening)
    behind = inner + np.arange(4)[:, None] * (inner - outer)
    first, second, third, fourth = reserve.take(behind)
    known = part.inside.take(behind).all(axis=0) & (first < second)
    receding = known & (second > LIKE_A_ROOT * third) & (third > LIKE_A_ROOT * fourth)
    growing = known & (second <= LIKE_A_ROOT * third) & (third < STEEP * fourth)
    growing &= first < second / 2.0**GAINED  # where the front is within the link
    # most increments have only one of these kinds of front
    share = by_slip
    if receding.any():
        share = _trusted(share, receding, first / np.where(receding, second - RATIO * first, np.inf) - RATIO_INSET)
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
