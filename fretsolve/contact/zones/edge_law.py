"""Places of edges on the links that they cross: shares inside by pressure and gap, or by shear traction and slip.

The fields place the edge of the contact, and of a stick zone that shrinks, on the link between the centres of an inner
and an outer cell by (T16) of docs/theory.md, less an inset along its normal; the factor kappa is here the lever. For an
edge along the cells this holds to 2e-4 of their side h, with a lever of 0.58 and an inset of 0.175 h; in any direction
to 0.02 of h, and to 0.002 on average, with the constants below, measured on Hertz contacts on grids of 128 to 512 cells
a side. For the stick zone the reserve, by which the shear traction is below the friction limit, takes the place of the
pressure, and slip takes the place of the gap: the slip increment, or all the slip so far where the inner cell never
slipped.

A layer between the bodies takes the root from both sides of an edge. Where the layer gives way by more than the bodies
do over a cell, traction and slip fall in proportion to the distance. The layer's compliance adds to h over lever and
modulus. The share of the bodies in this sum weighs the insets and the powers of the root against those of a line.

No smooth front fits along a body's sharp edge, and in contacts so small that no cell has its neighbours with it. The
reserve behind the front gives its place if there is less slip than belongs to the shear traction, as when the front
moves by less than a cell in an increment, and if the stick zone grows (T17). For a front that moves in, the reserve
counts along the traction past the front, since the cells behind may still have the traction of an earlier load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretsolve.contact.zones.zone_cells import Links, ZoneCells
from fretsolve.problem.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.system.arrays import TINY, BoolArray, FloatArray, IndexArray

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
the reserve in the cell behind. It holds to 2e-4 on a front along the cells (without the inset), to 0.1 on others. It
begins to replace the share by the slip if that share is larger by TRUST, and has replaced it at twice TRUST."""

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
average, and within 0.03 of the average from place to place. In increments smaller than a cell, the slip shows only
which cell the front has reached."""

AT_THE_LIMIT, UNLIKE = 1e-5, 0.1
"""Reserve over the friction limit up to which a sticking cell is at the limit. Then the slip past the front, which goes
like s^(3/2) where the front has moved by some cells, gives its place: on a front along the cells to 0.08 of h. The
cells are counted where the third cell's slip differs from this law by more than the part UNLIKE of the law's slip."""

HARDLY, OF_THE_WHOLE = 0.02, 0.4
"""The slip past a front since the first load belongs to the reserve, rather than the slip in the increment, if the
inner cell has not slipped (by HARDLY of the outer cell's increment at most), and the slip since then is at least
OF_THE_WHOLE of the increment's. After full reversal the slip so far is half the slip of the increment: the increment's
slip has doubled, and the reserve has not, since the first load left a kink in the shear traction at the same front. By
the increment's slip, a stick zone would mostly be smaller by 0.05 to 0.18 of h there. In increments that move the front
by less than a cell, the slip since the first load is all that there is past it."""

ROWS_AROUND, COLUMNS_AROUND = np.indices((3, 3)).reshape(2, 9, 1) - 1
"""Steps along x and y from a cell to the cells around it."""


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

    @property
    def sticks(self) -> bool:
        """True if a cell sticks."""
        return bool((self.zone == Zone.STICK).any())

    def zones(self, contact: BoolArray) -> tuple[BoolArray, ...]:
        """Return the `contact`, and the stick zone where it is a part of the contact."""
        parted = self.sticks and (self.zone == Zone.SLIP).any()
        return (contact, self.zone == Zone.STICK) if parted else (contact,)


class EdgeLaw:
    """The shares inside of the links (k,) that edges cross, given their levers.

    The edge of the contact, and of the stick zone past which cells are open, follows from pressure and gap; the edge
    of the stick zone past which cells slip, from shear traction and slip.
    """

    def __init__(self, part: ZoneCells, links: Links, fields: ZoneFields, materials: Compliances):
        self._part, self._materials = part, materials
        load, gap = part.cut(fields.pressure, 0.0), part.cut(fields.gap, np.inf)
        opening = materials.contact_modulus * np.maximum(gap[links.outer], 0.0)
        self._softness = materials.layer_normal * materials.contact_modulus / links.length
        self._carried, self._opening, self._steepest = self._balance(links, load, opening)
        self._receding = self._growing = self._at_limit = np.zeros(0, np.intp)
        if len(part.inside) > 1:
            slipping = part.cut(fields.zone, Zone.OPEN)[links.outer] == Zone.SLIP
            slips = (slipping & (links.zone > 0)).nonzero()[0]
            if slips.size:
                self._put_slip(slips, links.some(slips), fields)

    def shares(self, lever: FloatArray) -> FloatArray:
        """Return the shares inside, (k,), given the levers (k,); NaN where no smooth front fits."""
        opened = lever * self._opening / (1.0 + lever * self._softness)
        found: FloatArray = self._carried / np.maximum(self._carried + opened, TINY)
        found[opened > self._steepest] = np.nan
        if self._receding.size:
            excess = found[self._receding] - self._expected
            trusted = np.minimum(excess, np.maximum(2.0 * TRUST - excess, 0.0))
            found[self._receding] = np.maximum(self._expected + trusted, 0.0)
        if self._growing.size:
            found[self._growing] = self._gained
        if self._at_limit.size:
            found[self._at_limit] = self._inside + self.inset(lever)[self._at_limit]
        return found

    def inset(self, lever: FloatArray) -> FloatArray:
        """Return the insets of edges in cells, (k,), given the levers (k,)."""
        found: FloatArray = (INSET + np.log(LEVER / lever) / 6.0) * self._root(slice(None))
        return found

    def _root(self, places: IndexArray | slice) -> FloatArray:
        """Return the part of the bodies in what gives way at links: 1 without a layer."""
        found: FloatArray = 1.0 / (1.0 + LEVER * self._softness[places])
        return found

    def _balance(
        self, links: Links, load: FloatArray, opening: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return what balances at links: the load of the inner cells, the opening past them, and the largest opening.

        load: of the part's cells; opening: at the links' outer cells, times a modulus, for a lever of 1.
        """
        part = self._part
        around = links.zone * load.size + links.inner + (ROWS_AROUND * part.width + COLUMNS_AROUND)
        behind = load * part.deep.reshape(len(part.deep), -1)
        return load[links.inner] * links.length, opening, STEEPEST * links.length * behind.take(around).max(axis=0)

    def _put_slip(self, places: IndexArray, links: Links, fields: ZoneFields) -> None:
        """Take the law of slip and of the reserve of shear below the limit for some links, whose `places` are given.

        The modulus is the contact modulus for a front across the slip, and the modulus of antiplane shear for a front
        along the slip.
        """
        part, inner, outer = self._part, links.inner, links.outer
        limit, x, y, *slip = (part.cut(field, 0.0) for field in (fields.limit, *fields.shear, *fields.slip))
        reserve = np.maximum(limit - np.sqrt(x * x + y * y), 0.0)
        past, modulus = self._slip_past(links, slip, fields.slip_before)
        self._softness[places] = self._materials.layer_shear * modulus / links.length
        balance = self._balance(links, reserve, past)
        self._carried[places], self._opening[places], self._steepest[places] = balance
        behind = inner + np.arange(4)[:, None] * (inner - outer)
        known = part.inside[-1].take(behind).all(axis=0)
        reserves, onward = reserve[behind], _onward(x, y, limit, behind, outer)
        first, second, third, fourth = reserves
        receding = known & (onward[0] < onward[1]) & (_like_a_root(reserves) | _like_a_root(onward))
        growing = known & (second <= LIKE_A_ROOT * third) & (third < STEEP * fourth)
        power = 1.0 + (GAINED - 1.0) * self._root(places)
        growing &= first < second / 2.0**power  # where the front is within the link
        # most increments have only one of these kinds of front
        if receding.any():
            self._receding = places[receding]
            nearer, farther = onward[0][receding], onward[1][receding]
            root = self._root(self._receding)
            self._expected = nearer / (farther - (RATIO + (1.0 - RATIO) * (1.0 - root)) * nearer) - RATIO_INSET * root
        if growing.any():
            self._growing = places[growing]
            ratio = (first[growing] / second[growing]) ** (1.0 / power[growing])
            self._gained = ratio / (1.0 - ratio) + GAINED_BEYOND * self._root(self._growing)
        at_limit = first <= AT_THE_LIMIT * limit[inner]
        if at_limit.any():
            self._at_limit = places[at_limit]
            past = outer[at_limit] + np.arange(3)[:, None] * (outer - inner)[at_limit]
            power = 1.0 + 0.5 * self._root(self._at_limit)
            first, second, third = np.hypot(slip[0][past], slip[1][past])
            self._inside = _share_by_slip(first, second, third, power)

    def _slip_past(
        self, links: Links, slip: list[FloatArray], slip_before: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the slip past the front that belongs to the reserve, times the moduli, and its modulus, (k,).

        slip: increments of the part's cells along x and y; slip_before: accumulated before, (2, nx, ny).
        """
        before = [self._part.cut(field, 0.0) for field in slip_before]
        (x, y), (inner_x, inner_y) = ([field[cells] for field in slip] for cells in (links.outer, links.inner))
        all_x, all_y = before[0][links.outer] + x, before[1][links.outer] + y
        inner_x, inner_y = before[0][links.inner] + inner_x, before[1][links.inner] + inner_y
        squared = x * x + y * y
        never_slipped = inner_x * inner_x + inner_y * inner_y <= HARDLY**2 * squared
        whole = never_slipped & (all_x * x + all_y * y >= OF_THE_WHOLE * squared)
        across, along = self._materials.contact_modulus, 2.0 / self._materials.torsional
        modulus_x, modulus_y = np.where(links.along_y, along, across), np.where(links.along_y, across, along)
        slip_x, slip_y = np.where(whole, all_x, x), np.where(whole, all_y, y)
        opening: FloatArray = np.hypot(modulus_x * slip_x, modulus_y * slip_y)
        return opening, opening / np.maximum(np.hypot(slip_x, slip_y), TINY)


def _like_a_root(reserves: FloatArray) -> BoolArray:
    """Return whether the reserves (4, k) of the cells behind a front go as behind a front that has moved in."""
    first, second, third, fourth = reserves
    found: BoolArray = (first < second) & (second > LIKE_A_ROOT * third) & (third > LIKE_A_ROOT * fourth)
    return found


def _onward(
    shear_x: FloatArray, shear_y: FloatArray, limit: FloatArray, behind: IndexArray, outer: IndexArray
) -> FloatArray:
    """Return the reserves (4, k) of the cells `behind` each link along the shear traction of its `outer` cell.

    The cells behind may still have the traction of an earlier load, as when that load is taken back in part.
    """
    past_x, past_y, x, y = shear_x[outer], shear_y[outer], shear_x[behind], shear_y[behind]
    along = (x * past_x + y * past_y) / np.maximum(np.hypot(past_x, past_y), TINY)
    left = limit[behind] ** 2 - (x * x + y * y) + along * along
    found: FloatArray = np.maximum(np.sqrt(np.maximum(left, 0.0)) - along, 0.0)
    return found


def _share_by_slip(first: FloatArray, second: FloatArray, third: FloatArray, power: FloatArray) -> FloatArray:
    """Return the shares inside, without an inset, from the slips of the three cells past a front, (k,).

    NaN where they do not go like s^power, as past a front that has moved by a cell or less.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (first / second) ** (1.0 / power)
        beyond = ratio / (1.0 - ratio)
        expected = second * ((beyond + 2.0) / (beyond + 1.0)) ** power
    fits = (ratio < 1.0) & (beyond <= 1.25) & (np.abs(third - expected) <= UNLIKE * expected)
    return np.where(fits, 1.0 - beyond, np.nan)
