"""Areas and extents of contact and stick zone, compiled by numba.

They follow the laws of `fretsolve.simulation.zones`. Its 600 calls of NumPy, for the hundred squares that an edge
crosses, take 0.6 ms: a sixth of an increment of mode I.3 on 32 x 32 points. These kernels take 0.1 ms.

Cells are numbered (i, j) on the grid, beyond which nothing presses and the gap is infinite. `inside` is the zone with a
margin, whose first cell is `corner`.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.kernels.numba_options import exact, inlined
from fretsolve.kernels.zone_laws import (
    AT_THE_LIMIT,
    GAINED,
    GAINED_BEYOND,
    HARDLY,
    INSET,
    LEVER,
    LEVER_ALONG,
    LEVER_MOST,
    LEVER_SLANTING,
    LIKE_A_ROOT,
    OF_THE_WHOLE,
    RATIO,
    RATIO_INSET,
    STEEP,
    STEEPEST,
    TRUST,
    UNLIKE,
)
from fretsolve.system.arrays import TINY

BALANCE, RECEDING, FIXED, AT_LIMIT = range(4)
"""Laws of the share of a link that is inside: load and opening balance; the same, but no more than the reserve lets
expect; a share whatever the lever; and that less the inset."""

MARGIN = 5
"""Cells around a zone that its edge may refer to."""

NONE = -10
"""In place of the first index of a cell that there is not."""


@exact
def sizes(zone, slipping, pressure, gap, shear, limit, slip, slip_so_far, dx, dy, across, along, sheared):
    """Return area (mm^2), half-widths (mm) and middle (in cells from the first one) of a `zone`, (nx, ny).

    sheared: whether it is a stick zone, past which cells are `slipping` or open; else it is the contact, and
    `slipping`, shear (MPa), limit (the friction limit, MPa), slip (increment, mm) and slip_so_far (mm) are not read.
    dx, dy: sides of a cell (mm); across, along: the contact modulus and that of antiplane shear (MPa).
    """
    top, bottom, left, right = box = _box(zone)
    inside, corner = _with_margin(zone, box), (top - MARGIN, left - MARGIN)
    laws, values, shares, outer = np.zeros(4, np.uint8), np.empty((4, 4)), np.empty(4), np.empty((4, 2), np.int64)
    whole, cells, turns = 0, 0, 0
    part, lengths, cubes, taken = 0.0, 0.0, 0.0, 0.0
    # the farthest crossing of each row, towards -x, +x, -y, +y, in cells beyond the zone's outermost middles
    ends = np.full((4, max(bottom - top, right - left) + 5), -math.inf)
    unknown = np.full(ends.shape, -math.inf)
    for i in range(top - 1, bottom + 1):
        for j in range(left - 1, right + 1):
            m, n = i - corner[0], j - corner[1]
            count = inside[m, n] + inside[m, n + 1] + inside[m + 1, n] + inside[m + 1, n + 1]
            if count == 0 or count == 4:
                whole += count == 4
                continue
            # the links that the edge crosses, and where it crosses them
            for k in range(4):
                a, b, c, d = _link(inside, corner, i, j, k)
                outer[k, 0], outer[k, 1] = c, d
                if inside[a - corner[0], b - corner[1]] == inside[c - corner[0], d - corner[1]]:
                    laws[k], values[k, 3], outer[k, 0] = FIXED, inside[a - corner[0], b - corner[1]], NONE
                elif sheared and 0 <= c < zone.shape[0] and 0 <= d < zone.shape[1] and slipping[c, d]:
                    side, moduli = (dx, (across, along)) if k < 2 else (dy, (along, across))
                    tangential = shear, limit, slip, slip_so_far
                    laws[k] = _put_stick(values[k], inside, corner, tangential, a, b, c, d, side, moduli)
                else:
                    side = dx if k < 2 else dy
                    laws[k] = _put_contact(values[k], inside, corner, pressure, gap, a, b, c, d, side, across)
            inset, run_x, run_y, length = _place(shares, laws, values, dx, dy, min(zone.shape) == 1)
            _put_ends(ends, unknown, shares, outer, inset, box)
            # the area inside the square, and what a smooth front within the segments takes from it
            x, y = shares[0] + shares[1], shares[2] + shares[3]
            inner = 0.5 * x * y if count <= 2 else 1.0 - 0.5 * (2.0 - x) * (2.0 - y)
            if inner != inner or (count == 2 and inside[m, n] == inside[m + 1, n + 1]):
                cells += count
            else:
                turns += (count == 1) - (count == 3)
                part += inner
                lengths += length
                cubes += length**3
                taken += inset * (run_y * dx**2 + run_x * dy**2) / _at_least(run_y * dx + run_x * dy) * length
    area = (whole + cells / 4.0 + part) * dx * dy
    if lengths:
        bulge = cubes / (12.0 * lengths)
        area -= taken - 0.5 * math.pi * turns * (bulge + 0.5 * (taken / lengths) ** 2)
    low_x, high_x, low_y, high_y = _farthest(ends, unknown)
    return (
        max(area, 0.0),
        0.5 * dx * (bottom - top + low_x + high_x),
        0.5 * dy * (right - left + low_y + high_y),
        0.5 * (top + bottom + high_x - low_x),
        0.5 * (left + right + high_y - low_y),
    )


@exact
def _place(shares, laws, values, dx, dy, is_row):
    """Place the edge on the links of a square: put the `shares` inside, and return the edge's inset (cells), its runs
    along x and y and its length within the square (mm).
    """
    lever, run_x, run_y, length = LEVER, 0.0, 0.0, 0.0
    for _ in range(2):  # the first pass finds the edge's direction
        for k in range(4):
            shares[k] = _share(laws[k], values[k], lever)
        run_x, run_y = abs(shares[1] - shares[0]) * dx, abs(shares[3] - shares[2]) * dy
        length = _at_least(math.sqrt(run_x * run_x + run_y * run_y))
        lever = LEVER_ALONG + LEVER_SLANTING * (2.0 * (run_x / length) * (run_y / length))
        lever = LEVER_ALONG if is_row else LEVER_MOST if lever > LEVER_MOST else lever
    return _inset_by(lever), run_x, run_y, length


@exact
def _put_ends(ends, unknown, shares, outer, inset, box):
    """Put how far the crossings of a square reach beyond the outermost middles of the zone, near its ends."""
    top, bottom, left, right = box
    for k in range(4):
        c, d = outer[k]
        place = c - 0.5 * (top + bottom) if k < 2 else d - 0.5 * (left + right)
        depth = 0.5 * (bottom - top if k < 2 else right - left) + 1.0 - abs(place)
        if c == NONE or depth >= 1.5:
            continue
        towards, line = 2 * (k // 2) + (place > 0.0), (d - left if k < 2 else c - top) + 2
        beyond = shares[k] - inset - depth
        if beyond != beyond:  # no smooth edge fits
            unknown[towards, line] = max(unknown[towards, line], 0.5 - depth)
        else:
            ends[towards, line] = max(ends[towards, line], beyond)


@exact
def _box(zone):
    """Return the first and last row and column of a zone."""
    nx, ny = zone.shape
    top, bottom, left, right = nx, -1, ny, -1
    for i in range(nx):
        row = zone[i]
        for j in range(ny):
            if row[j]:
                top, bottom, left = min(top, i), i, min(left, j)
                break
        if bottom == i:
            for j in range(ny - 1, right, -1):
                if row[j]:
                    right = j
                    break
    return top, bottom, left, right


@exact
def _with_margin(zone, box):
    """Return the cells of a zone as 1, with a margin of 0 around."""
    top, bottom, left, right = box
    inside = np.zeros((bottom - top + 1 + 2 * MARGIN, right - left + 1 + 2 * MARGIN), np.uint8)
    for i in range(top, bottom + 1):  # numba takes seconds to compile an assignment of slices
        for j in range(left, right + 1):
            inside[i - top + MARGIN, j - left + MARGIN] = zone[i, j]
    return inside


@inlined
def _link(inside, corner, i, j, k):
    """Return the ends of a square's link, the one inside first where there is one: of two along x, and two along y."""
    a, b = (i, j + k) if k < 2 else (i + k - 2, j)
    c, d = (a + 1, b) if k < 2 else (a, b + 1)
    if inside[a - corner[0], b - corner[1]]:
        return a, b, c, d
    return c, d, a, b


@inlined
def _is_deep(inside, m, n, nx, ny):
    """Return whether a cell and those beside it are inside; a single row has none across."""
    deep = inside[m, n] == 1
    if nx > 1:
        deep = deep and inside[m - 1, n] == 1 and inside[m + 1, n] == 1
    if ny > 1:
        deep = deep and inside[m, n - 1] == 1 and inside[m, n + 1] == 1
    return deep


@exact
def _put_contact(value, inside, corner, pressure, gap, a, b, c, d, side, modulus):
    """Put what balances the link from a cell (a, b) inside to an open one (c, d), and return its law."""
    nx, ny = gap.shape
    steepest = 0.0
    for i in range(a - 1, a + 2):
        for j in range(b - 1, b + 2):
            if _is_deep(inside, i - corner[0], j - corner[1], nx, ny):
                steepest = max(steepest, pressure[i, j])
    open_by = gap[c, d] if 0 <= c < nx and 0 <= d < ny else math.inf
    value[0], value[1] = pressure[a, b] * side, modulus * max(open_by, 0.0)
    value[2] = STEEPEST * side * steepest
    return BALANCE


@inlined
def _reserve(shear, limit, i, j):
    """Return by how much the shear traction of a cell is below the friction limit."""
    if not (0 <= i < limit.shape[0] and 0 <= j < limit.shape[1]):
        return 0.0
    q_x, q_y = shear[0, i, j], shear[1, i, j]
    return max(limit[i, j] - math.sqrt(q_x * q_x + q_y * q_y), 0.0)


@exact
def _put_stick(value, inside, corner, tangential, a, b, c, d, side, moduli):
    """Put what balances the link from a sticking cell (a, b) to a slipping one (c, d), and return its law.

    tangential: shear, friction limit, slip increment and slip so far.
    """
    shear, limit, slip, slip_so_far = tangential
    nx, ny = limit.shape
    steepest = 0.0
    for i in range(a - 1, a + 2):
        for j in range(b - 1, b + 2):
            if _is_deep(inside, i - corner[0], j - corner[1], nx, ny):
                steepest = max(steepest, _reserve(shear, limit, i, j))
    step_i, step_j = a - c, b - d
    first, second = _reserve(shear, limit, a, b), _reserve(shear, limit, a + step_i, b + step_j)
    third = _reserve(shear, limit, a + 2 * step_i, b + 2 * step_j)
    fourth = _reserve(shear, limit, a + 3 * step_i, b + 3 * step_j)
    value[0], value[1] = first * side, _opening(slip, slip_so_far, a, b, c, d, moduli)
    value[2] = STEEPEST * side * steepest
    if first <= AT_THE_LIMIT * limit[a, b]:
        value[3] = _share_by_slip(slip, c, d, -step_i, -step_j)
        return AT_LIMIT
    for k in range(4):
        if inside[a + k * step_i - corner[0], b + k * step_j - corner[1]] == 0:
            return BALANCE
    if second <= LIKE_A_ROOT * third and third < STEEP * fourth and first < second / 2.0**GAINED:
        ratio = (first / second) ** (1.0 / GAINED)
        value[3] = ratio / (1.0 - ratio) + GAINED_BEYOND
        return FIXED
    receding = _like_a_root(first, second, third, fourth)
    first = _onward(shear, limit, a, b, c, d)
    second = _onward(shear, limit, a + step_i, b + step_j, c, d)
    third = _onward(shear, limit, a + 2 * step_i, b + 2 * step_j, c, d)
    fourth = _onward(shear, limit, a + 3 * step_i, b + 3 * step_j, c, d)
    if first < second and (receding or _like_a_root(first, second, third, fourth)):
        value[3] = first / (second - RATIO * first) - RATIO_INSET
        return RECEDING
    return BALANCE


@inlined
def _like_a_root(first, second, third, fourth):
    """Return whether the reserves of the cells behind a front go like those behind one that has moved in."""
    return first < second and second > LIKE_A_ROOT * third and third > LIKE_A_ROOT * fourth


@inlined
def _onward(shear, limit, i, j, c, d):
    """Return the reserve of a cell (i, j) along the shear traction of a cell (c, d) past the front."""
    past_x, past_y, x, y = shear[0, c, d], shear[1, c, d], shear[0, i, j], shear[1, i, j]
    along = (x * past_x + y * past_y) / _at_least(math.hypot(past_x, past_y))
    left = limit[i, j] * limit[i, j] - (x * x + y * y) + along * along
    return max(math.sqrt(max(left, 0.0)) - along, 0.0)


@inlined
def _opening(slip, slip_so_far, a, b, c, d, moduli):
    """Return the slip past the front that belongs to the reserve, times the moduli."""
    x, y, all_x, all_y = slip[0, c, d], slip[1, c, d], slip_so_far[0, c, d], slip_so_far[1, c, d]
    inner_x, inner_y = slip_so_far[0, a, b], slip_so_far[1, a, b]
    squared = x * x + y * y
    never_slipped = inner_x * inner_x + inner_y * inner_y <= HARDLY**2 * squared
    if never_slipped and all_x * x + all_y * y >= OF_THE_WHOLE * squared:
        x, y = all_x, all_y
    return math.hypot(moduli[0] * x, moduli[1] * y)


@exact
def _share_by_slip(slip, i, j, step_i, step_j):
    """Return the share inside, without an inset, from the slips of the three cells past a front; NaN where they do not
    go by the law.
    """
    lengths = np.zeros(3)
    for k in range(3):
        m, n = i + k * step_i, j + k * step_j
        if 0 <= m < slip.shape[1] and 0 <= n < slip.shape[2]:
            lengths[k] = math.hypot(slip[0, m, n], slip[1, m, n])
    ratio = (lengths[0] / lengths[1]) ** (2.0 / 3.0)
    beyond = ratio / (1.0 - ratio)
    expected = lengths[1] * ((beyond + 2.0) / (beyond + 1.0)) ** 1.5
    fits = ratio < 1.0 and beyond <= 1.25 and abs(lengths[2] - expected) <= UNLIKE * expected
    return 1.0 - beyond if fits else math.nan


@inlined
def _at_least(length):
    """Return a length, or the least one if that is more; NaN stays NaN."""
    return TINY if length < TINY else length


@inlined
def _inset_by(lever):
    """Return the inset of an edge in cells."""
    return INSET + math.log(LEVER / lever) / 6.0


@inlined
def _share(law, value, lever):
    """Return the share of a link that is inside; NaN if no smooth front fits."""
    if law == FIXED:
        return value[3]
    if law == AT_LIMIT:
        return value[3] + _inset_by(lever)
    opened = lever * value[1]
    if opened > value[2]:
        return math.nan
    found = value[0] / _at_least(value[0] + opened)
    if law == BALANCE or found != found:
        return found
    excess = found - value[3]
    return max(value[3] + min(excess, max(2.0 * TRUST - excess, 0.0)), 0.0)


@exact
def _farthest(ends, unknown):
    """Return how far the zone reaches towards -x, +x, -y, +y: by parabolas through rows and those beside, which end no
    farther.
    """
    found = np.full(4, -math.inf)
    for towards in range(4):
        row = ends[towards]
        for line in range(len(row)):
            if row[line] == -math.inf:
                row[line] = unknown[towards, line]
        for line in range(1, len(row) - 1):
            most, back, ahead = row[line], row[line] - row[line - 1], row[line] - row[line + 1]
            if back >= 0.0 and ahead >= 0.0 and 0.0 < back + ahead < math.inf:  # else at a corner
                most += (ahead - back) ** 2 / (8.0 * (ahead + back))
            found[towards] = max(found[towards], most)
    return found[0], found[1], found[2], found[3]
