"""Operations on the cosine coefficients of fields on one half of a grid: their series along y, products along x.

`fretsolve.elastic.mirrored_operator` defines coefficients and lines. Kernels are real and hold the non-negative
wave numbers along the last axis, (r, m//2 + 1); what they do at the negative ones follows from their parity in x.
"""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.kernels.compiling import compiled, inlined
from fretsolve.system.arrays import ComplexArray, FloatArray

TILE = 64
"""Rows that are transposed at a time. With 8 of them, which fill a cache line, an increment on 1024 x 1024 points takes
2 % longer."""


def multiply_even(upper: FloatArray, lower: FloatArray, lines: ComplexArray) -> None:
    """Multiply lines (r, m) of two real fields by even kernels, in place: by `upper` their real parts, by `lower` the
    others.

    upper, lower: (r, m//2 + 1); lower may have one row less, where the last line has no imaginary part.
    """
    other = lower if len(lower) == len(upper) else np.concatenate([lower, upper[-1:]])
    mean, rest = 0.5 * (upper + other), 0.5 * (upper - other)
    positive, negative = _by_sign(lines)
    _put(lines, mean * positive + rest * negative.conj(), mean * negative + rest * positive.conj())


@compiled
def multiply_even_loops(upper, lower, lines):
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


def multiply_in_plane(xx: FloatArray, yy: FloatArray, xy: FloatArray, lines: ComplexArray) -> None:
    """Turn lines (r, m) of qx + i qy into lines of ux + i uy, in place; kernels: of the coefficients, (r, m//2 + 1)."""
    _put(lines, *_in_plane(xx, yy, xy, *_by_sign(lines)))


@compiled
def multiply_in_plane_loops(xx, yy, xy, lines):
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


def tangential_from_pressure(xz: FloatArray, yz: FloatArray, lines: ComplexArray) -> None:
    """Turn lines (r, m) of p into lines of ux + i uy, by the kernels of the coefficients, (r, m//2 + 1), in place."""
    _put(lines, *_tangential(xz, yz, *_by_sign(lines)))


@compiled
def tangential_from_pressure_loops(xz, yz, lines):
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


def normal_from_shear(xz: FloatArray, yz: FloatArray, lines: ComplexArray) -> None:
    """Turn lines (r, m) of qx + i qy into lines of uz, by the kernels of the coefficients, (r, m//2 + 1), in place."""
    _put(lines, *_normal(xz, yz, *_by_sign(lines)))


@compiled
def normal_from_shear_loops(xz, yz, lines):
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


def multiply_coupled(
    zz: FloatArray,
    xx: FloatArray,
    yy: FloatArray,
    xy: FloatArray,
    xz: FloatArray,
    yz: FloatArray,
    pressure: ComplexArray,
    shear: ComplexArray,
) -> None:
    """Turn lines (r, m) of p and of qx + i qy into lines of uz and of ux + i uy, in place.

    The others are the kernels of the coefficients, (r, m//2 + 1).
    """
    p, q = _by_sign(pressure), _by_sign(shear)
    lifted, moved, in_plane = _normal(xz, yz, *q), _tangential(xz, yz, *p), _in_plane(xx, yy, xy, *q)
    _put(pressure, zz * p[0] + lifted[0], zz * p[1] + lifted[1])
    _put(shear, moved[0] + in_plane[0], moved[1] + in_plane[1])


@compiled
def multiply_coupled_loops(zz, xx, yy, xy, xz, yz, pressure, shear):
    rows, half = xx.shape
    length = shear.shape[1]
    one_half = xx.dtype.type(0.5)
    pressed, sheared = np.empty(half, shear.dtype), np.empty(half, shear.dtype)
    for r in range(rows):
        lifted, moved = pressure[r], shear[r]
        _take_negative(lifted, pressed)
        _take_negative(moved, sheared)
        for i in range(half):
            p, n, z, w = moved[i], sheared[i], lifted[i], pressed[i]
            direct, across = zz[r, i], xy[r, i]
            mean, rest = one_half * (xx[r, i] + yy[r, i]), one_half * (xx[r, i] - yy[r, i])
            along, against = xz[r, i] - yz[r, i], xz[r, i] + yz[r, i]
            turned = one_half * (along * p.imag - against * n.imag)
            raised = one_half * (along * p.real + against * n.real)
            lifted[i] = complex(direct * z.real + turned, direct * z.imag - raised)
            pressed[i] = complex(direct * w.real + turned, direct * w.imag + raised)
            moved[i] = complex(
                (mean - across) * p.real + rest * n.real - along * z.imag,
                (mean - across) * p.imag - rest * n.imag + along * z.real,
            )
            sheared[i] = complex(
                (mean + across) * n.real + rest * p.real + against * w.imag,
                (mean + across) * n.imag - rest * p.imag - against * w.real,
            )
        _give_negative(pressed, lifted, length)
        _give_negative(sheared, moved, length)


Signs = tuple[ComplexArray, ComplexArray]
"""Values at the wave numbers 0..m//2 of lines, and at the wave numbers with the other sign, both (r, m//2 + 1)."""


def _by_sign(lines: ComplexArray) -> Signs:
    half = lines.shape[1] // 2 + 1
    return lines[:, :half], np.concatenate([lines[:, :1], lines[:, : lines.shape[1] - half : -1]], axis=1)


def _put(lines: ComplexArray, positive: ComplexArray, negative: ComplexArray) -> None:
    """Write such values into `lines`; where one stands for both signs, they are equal."""
    half = positive.shape[1]
    lines[:, : lines.shape[1] - half : -1] = negative[:, 1:]
    lines[:, :half] = positive


def _in_plane(xx: FloatArray, yy: FloatArray, xy: FloatArray, positive: ComplexArray, negative: ComplexArray) -> Signs:
    mean, rest = 0.5 * (xx + yy), 0.5 * (xx - yy)
    return ((mean - xy) * positive + rest * negative.conj(), (mean + xy) * negative + rest * positive.conj())


def _tangential(xz: FloatArray, yz: FloatArray, positive: ComplexArray, negative: ComplexArray) -> Signs:
    return 1j * ((xz - yz) * positive), -1j * ((xz + yz) * negative)


def _normal(xz: FloatArray, yz: FloatArray, positive: ComplexArray, negative: ComplexArray) -> Signs:
    along, against = 0.5 * (xz - yz), 0.5 * (xz + yz)
    return (-1j * (along * positive + against * negative.conj()), 1j * (against * negative + along * positive.conj()))


def fold_rows(upper: FloatArray, lower: FloatArray, odd: bool, lines: ComplexArray) -> None:
    """Put the cells of ``upper + i lower`` into lines (r, m): even cells, then the odd cells in reverse.

    upper: (r, ny) with 2 ny <= 2 m; lower: as many rows or one less; odd: odd cells change their sign.
    """
    even_cells, odd_cells = lines[:, : (lines.shape[1] + 1) // 2], lines[:, : (lines.shape[1] - 1) // 2 : -1]
    lines[:] = 0.0
    for rows, part in ((upper, "real"), (lower, "imag")):
        first, second = rows[:, ::2], rows[:, 1::2]
        getattr(even_cells, part)[: len(rows), : first.shape[1]] = first
        getattr(odd_cells, part)[: len(rows), : second.shape[1]] = -second if odd else second


@compiled
def fold_rows_loops(upper, lower, odd, lines):
    sign = upper.dtype.type(-1.0 if odd else 1.0)
    nothing = np.zeros(upper.shape[1], upper.dtype)
    for r in range(len(upper)):
        if r < len(lower):
            _fold(upper[r], lower[r], sign, lines[r])
        else:
            _fold(upper[r], nothing, sign, lines[r])


def unfold_rows(lines: ComplexArray, odd: bool, upper: FloatArray, lower: FloatArray) -> None:
    """Invert `fold_rows`."""
    even_cells, odd_cells = lines[:, : (lines.shape[1] + 1) // 2], lines[:, : (lines.shape[1] - 1) // 2 : -1]
    for rows, part in ((upper, "real"), (lower, "imag")):
        first, second = rows[:, ::2], rows[:, 1::2]
        first[:] = getattr(even_cells, part)[: len(rows), : first.shape[1]]
        second[:] = getattr(odd_cells, part)[: len(rows), : second.shape[1]]
        if odd:
            np.negative(second, out=second)


@compiled
def unfold_rows_loops(lines, odd, upper, lower):
    sign = upper.dtype.type(-1.0 if odd else 1.0)
    nowhere = np.empty(upper.shape[1], upper.dtype)
    for r in range(len(upper)):
        if r < len(lower):
            _unfold(lines[r], sign, upper[r], lower[r])
        else:
            _unfold(lines[r], sign, upper[r], nowhere)


def to_coefficients(lines: ComplexArray, phases: ComplexArray, odd: bool, upper: FloatArray, lower: FloatArray) -> None:
    """Write the series of two real rows, (m, r), from the spectra of their folded lines (r, m).

    phases: exp(-i pi s/2m), (m,); lower: as many rows or one less; odd: coefficients are in reverse, but for the first.
    """
    found = phases * lines
    found[:, 1:] += phases[1:].conj() * lines[:, :0:-1]
    found[:, 0] += lines[:, 0]
    if odd:
        found[:, 1:] = found[:, :0:-1].copy()
    upper[:] = found.real.T
    lower[:] = found.imag.T[:, : lower.shape[1]]


@compiled
def to_coefficients_loops(lines, phases, odd, upper, lower):
    rows, length = lines.shape
    rows_below = lower.shape[1]
    for first in range(0, rows, TILE):
        tile = range(first, min(first + TILE, rows))
        for r in tile:
            upper[0, r] = lines[r, 0].real + lines[r, 0].real
            if r < rows_below:
                lower[0, r] = lines[r, 0].imag + lines[r, 0].imag
        # coefficients k and m - k follow from the same numbers a = w z_k and b = conj(w) z_(m-k): a + b and i (a - b)
        for k in range(1, length // 2 + 1):
            one, other = (length - k, k) if odd else (k, length - k)
            turn, back = phases[k], phases[k].conjugate()
            for r in tile:
                a, b = turn * lines[r, k], back * lines[r, length - k]
                added, taken = a + b, a - b
                upper[one, r], upper[other, r] = added.real, -taken.imag
                if r < rows_below:
                    lower[one, r], lower[other, r] = added.imag, taken.real


def from_coefficients(
    upper: FloatArray, lower: FloatArray, phases: ComplexArray, odd: bool, lines: ComplexArray
) -> None:
    """Invert `to_coefficients`, up to a factor: write the spectra of the folded lines (r, m) of two series, (m, r)."""
    values = np.zeros_like(lines)
    values.real = upper.T
    values.imag[: lower.shape[1]] = lower.T
    if odd:
        values[:, 1:] = values[:, :0:-1].copy()
    lines[:, 0] = values[:, 0]
    lines[:, 1:] = phases[1:].conj() * (values[:, 1:] - 1j * values[:, :0:-1])


@compiled
def from_coefficients_loops(upper, lower, phases, odd, lines):
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


@inlined
def _take_negative(line, mirrored):
    """Copy the values of a line at wave numbers 0, -1, -2 .. to `mirrored`."""
    length = line.shape[0]
    mirrored[0] = line[0]
    for i in range(1, mirrored.shape[0]):
        mirrored[i] = line[length - i]


@inlined
def _give_negative(mirrored, line, length):
    """Copy such values back, except at wave numbers that stand for both signs."""
    for i in range(1, length - mirrored.shape[0] + 1):
        line[length - i] = mirrored[i]


@inlined
def _fold(upper, lower, sign, line):
    ny, length = len(upper), len(line)
    for j in range((ny + 1) // 2):
        line[j] = complex(upper[2 * j], lower[2 * j])
    for j in range((ny + 1) // 2, length - ny // 2):
        line[j] = 0.0
    for j in range(ny // 2):
        line[length - 1 - j] = complex(sign * upper[2 * j + 1], sign * lower[2 * j + 1])


@inlined
def _unfold(line, sign, upper, lower):
    """Invert `_fold`."""
    ny, length = len(upper), len(line)
    for j in range((ny + 1) // 2):
        upper[2 * j], lower[2 * j] = line[j].real, line[j].imag
    for j in range(ny // 2):
        value = line[length - 1 - j]
        upper[2 * j + 1], lower[2 * j + 1] = sign * value.real, sign * value.imag
