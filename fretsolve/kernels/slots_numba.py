"""Operations on the slots of fields on one half of a grid, compiled by numba. Each does what its namesake in
`slots_numpy` does."""

from __future__ import annotations

import numpy as np

from fretsolve.kernels.numba_options import inlined
from fretsolve.kernels.numba_options import kernel as compiled

TILE = 64
"""Rows that are transposed at a time. With 8 of them, which fill a cache line, an increment on 1024 x 1024 points takes
2 % longer."""


@compiled
def multiply_slots(upper, lower, lines):
    """Multiply lines (r, m) of two real fields by even kernels, in place: by `upper` their real parts, by `lower` the
    others."""
    rows, half = upper.shape
    length = lines.shape[1]
    one_half = upper.dtype.type(0.5)
    mirrored = np.empty(half, lines.dtype)  # the loops over products then run forward, in vector instructions
    for r in range(rows):
        line, one, other = lines[r], upper[r], lower[r] if r < lower.shape[0] else upper[r]
        _take_negative(line, mirrored)
        for i in range(half):
            p, n = line[i], mirrored[i]
            mean, rest = one_half * (one[i] + other[i]), one_half * (one[i] - other[i])
            line[i] = complex(mean * p.real + rest * n.real, mean * p.imag - rest * n.imag)
            mirrored[i] = complex(mean * n.real + rest * p.real, mean * n.imag - rest * p.imag)
        _give_negative(mirrored, line, length)


@compiled
def multiply_in_plane(xx, yy, xy, lines):
    """Turn lines (r, m) of qx + i qy into those of ux + i uy, by the kernels of slots, (r, m//2 + 1), in place."""
    rows, half = xx.shape
    length = lines.shape[1]
    one_half = xx.dtype.type(0.5)
    mirrored = np.empty(half, lines.dtype)
    for r in range(rows):
        line = lines[r]
        _take_negative(line, mirrored)
        for i in range(half):
            p, n, across = line[i], mirrored[i], xy[r, i]
            mean, rest = one_half * (xx[r, i] + yy[r, i]), one_half * (xx[r, i] - yy[r, i])
            line[i] = complex((mean - across) * p.real + rest * n.real, (mean - across) * p.imag - rest * n.imag)
            mirrored[i] = complex((mean + across) * n.real + rest * p.real, (mean + across) * n.imag - rest * p.imag)
        _give_negative(mirrored, line, length)


@compiled
def turn_sideways(xz, yz, lines):
    """Turn lines (r, m) of p into those of ux + i uy, by the kernels of slots, (r, m//2 + 1), in place."""
    rows, half = xz.shape
    length = lines.shape[1]
    mirrored = np.empty(half, lines.dtype)
    for r in range(rows):
        line = lines[r]
        _take_negative(line, mirrored)
        for i in range(half):
            p, n = line[i], mirrored[i]
            along, against = xz[r, i] - yz[r, i], xz[r, i] + yz[r, i]
            line[i] = complex(-along * p.imag, along * p.real)
            mirrored[i] = complex(against * n.imag, -against * n.real)
        _give_negative(mirrored, line, length)


@compiled
def turn_upright(xz, yz, lines):
    """Turn lines (r, m) of qx + i qy into those of uz, by the kernels of slots, (r, m//2 + 1), in place."""
    rows, half = xz.shape
    length = lines.shape[1]
    one_half = xz.dtype.type(0.5)
    mirrored = np.empty(half, lines.dtype)
    for r in range(rows):
        line = lines[r]
        _take_negative(line, mirrored)
        for i in range(half):
            p, n = line[i], mirrored[i]
            along, against = one_half * (xz[r, i] - yz[r, i]), one_half * (xz[r, i] + yz[r, i])
            line[i] = complex(along * p.imag - against * n.imag, -along * p.real - against * n.real)
            mirrored[i] = complex(along * p.imag - against * n.imag, against * n.real + along * p.real)
        _give_negative(mirrored, line, length)


@compiled
def multiply_coupled(zz, xx, yy, xy, xz, yz, pressure, shear):
    """Turn lines (r, m) of p and of qx + i qy into those of uz and of ux + i uy, in place.

    The others are the kernels of slots, (r, m//2 + 1).
    """
    rows, half = xx.shape
    length = shear.shape[1]
    one_half = xx.dtype.type(0.5)
    pressed, sheared = np.empty(half, shear.dtype), np.empty(half, shear.dtype)
    for r in range(rows):
        upright, sideways = pressure[r], shear[r]
        _take_negative(upright, pressed)
        _take_negative(sideways, sheared)
        for i in range(half):
            p, n, z, w = sideways[i], sheared[i], upright[i], pressed[i]
            direct, across = zz[r, i], xy[r, i]
            mean, rest = one_half * (xx[r, i] + yy[r, i]), one_half * (xx[r, i] - yy[r, i])
            along, against = xz[r, i] - yz[r, i], xz[r, i] + yz[r, i]
            turned = one_half * (along * p.imag - against * n.imag)
            raised = one_half * (along * p.real + against * n.real)
            upright[i] = complex(direct * z.real + turned, direct * z.imag - raised)
            pressed[i] = complex(direct * w.real + turned, direct * w.imag + raised)
            sideways[i] = complex(
                (mean - across) * p.real + rest * n.real - along * z.imag,
                (mean - across) * p.imag - rest * n.imag + along * z.real,
            )
            sheared[i] = complex(
                (mean + across) * n.real + rest * p.real + against * w.imag,
                (mean + across) * n.imag - rest * p.imag - against * w.real,
            )
        _give_negative(pressed, upright, length)
        _give_negative(sheared, sideways, length)


@inlined
def _take_negative(line, mirrored):
    """Copy the values of a line at wave numbers 0, -1, -2 .. to `mirrored`."""
    length = line.shape[0]
    mirrored[0] = line[0]
    for i in range(1, mirrored.shape[0]):
        mirrored[i] = line[length - i]


@inlined
def _give_negative(mirrored, line, length):
    """Copy such values back, but not those of wave numbers that stand for both signs."""
    for i in range(1, length - mirrored.shape[0] + 1):
        line[length - i] = mirrored[i]


@compiled
def fold_rows(upper, lower, odd, lines):
    """Put the cells of ``upper + i lower`` into lines (r, m): those of even numbers, then the odd ones in reverse."""
    sign = upper.dtype.type(-1.0 if odd else 1.0)
    nothing = np.zeros(upper.shape[1], upper.dtype)
    for r in range(len(upper)):
        if r < len(lower):
            _fold(upper[r], lower[r], sign, lines[r])
        else:
            _fold(upper[r], nothing, sign, lines[r])


@inlined
def _fold(upper, lower, sign, line):
    """Put the cells of two rows into the real and the imaginary part of a line."""
    ny, length = len(upper), len(line)
    for j in range((ny + 1) // 2):
        line[j] = complex(upper[2 * j], lower[2 * j])
    for j in range((ny + 1) // 2, length - ny // 2):
        line[j] = 0.0
    for j in range(ny // 2):
        line[length - 1 - j] = complex(sign * upper[2 * j + 1], sign * lower[2 * j + 1])


@compiled
def unfold_rows(lines, odd, upper, lower):
    """Invert `fold_rows`."""
    sign = upper.dtype.type(-1.0 if odd else 1.0)
    nowhere = np.empty(upper.shape[1], upper.dtype)
    for r in range(len(upper)):
        if r < len(lower):
            _unfold(lines[r], sign, upper[r], lower[r])
        else:
            _unfold(lines[r], sign, upper[r], nowhere)


@inlined
def _unfold(line, sign, upper, lower):
    """Invert `_fold`."""
    ny, length = len(upper), len(line)
    for j in range((ny + 1) // 2):
        upper[2 * j], lower[2 * j] = line[j].real, line[j].imag
    for j in range(ny // 2):
        value = line[length - 1 - j]
        upper[2 * j + 1], lower[2 * j + 1] = sign * value.real, sign * value.imag


@compiled
def to_slots(lines, phases, odd, upper, lower):
    """Write the series of two real rows, (m, r), from the spectra of their folded lines (r, m)."""
    rows, length = lines.shape
    rows_below = lower.shape[1]
    for first in range(0, rows, TILE):
        tile = range(first, min(first + TILE, rows))
        for r in tile:
            upper[0, r] = lines[r, 0].real + lines[r, 0].real
            if r < rows_below:
                lower[0, r] = lines[r, 0].imag + lines[r, 0].imag
        # slots k and m - k follow from the same numbers a = w z_k and b = conj(w) z_(m-k): a + b and i (a - b)
        for k in range(1, length // 2 + 1):
            one, other = (length - k, k) if odd else (k, length - k)
            turn, back = phases[k], phases[k].conjugate()
            for r in tile:
                a, b = turn * lines[r, k], back * lines[r, length - k]
                added, taken = a + b, a - b
                upper[one, r], upper[other, r] = added.real, -taken.imag
                if r < rows_below:
                    lower[one, r], lower[other, r] = added.imag, taken.real


@compiled
def from_slots(upper, lower, phases, odd, lines):
    """Invert `to_slots`, up to a factor: write the spectra of the folded lines (r, m) of two series, (m, r)."""
    rows, length = lines.shape
    rows_below = lower.shape[1]
    nothing = upper.dtype.type(0.0)
    for first in range(0, rows, TILE):
        count = min(TILE, rows - first)
        for r in range(first, first + count):
            lines[r, 0] = complex(upper[0, r], lower[0, r] if r < rows_below else nothing)
        for k in range(1, length // 2 + 1):
            one, other = (length - k, k) if odd else (k, length - k)
            turn = phases[k].conjugate()
            for r in range(first, first + count):
                both = r < rows_below
                u = complex(upper[one, r], lower[one, r] if both else nothing)
                v = complex(upper[other, r], lower[other, r] if both else nothing)
                turned = complex(-v.imag, v.real)
                lines[r, k] = turn * (u - turned)
                lines[r, length - k] = phases[k] * (u + turned)
