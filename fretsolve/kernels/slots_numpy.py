"""Operations on the slots of fields on one half of a grid, in NumPy: their series along y, products along x.

Slots and lines are those of `fretsolve.elastic.mirrored`. Kernels are real and hold the non-negative wave numbers along
the last axis, (r, m//2 + 1); what they do at the negative ones follows from their parity in x.
"""

from __future__ import annotations

import numpy as np

from fretsolve.system.arrays import ComplexArray, FloatArray


def multiply_slots(upper: FloatArray, lower: FloatArray, lines: ComplexArray) -> None:
    """Multiply lines (r, m) of two real fields by even kernels, in place: by `upper` their real parts, by `lower` the
    others.

    upper, lower: (r, m//2 + 1); lower may have one row less, where the last line has no imaginary part.
    """
    other = lower if len(lower) == len(upper) else np.concatenate([lower, upper[-1:]])
    mean, rest = 0.5 * (upper + other), 0.5 * (upper - other)
    positive, negative = _by_sign(lines)
    _put(lines, mean * positive + rest * negative.conj(), mean * negative + rest * positive.conj())


def multiply_in_plane(xx: FloatArray, yy: FloatArray, xy: FloatArray, lines: ComplexArray) -> None:
    """Turn lines (r, m) of qx + i qy into those of ux + i uy, by the kernels of slots, (r, m//2 + 1), in place."""
    _put(lines, *_in_plane(xx, yy, xy, *_by_sign(lines)))


def turn_sideways(xz: FloatArray, yz: FloatArray, lines: ComplexArray) -> None:
    """Turn lines (r, m) of p into those of ux + i uy, by the kernels of slots, (r, m//2 + 1), in place."""
    _put(lines, *_sideways(xz, yz, *_by_sign(lines)))


def turn_upright(xz: FloatArray, yz: FloatArray, lines: ComplexArray) -> None:
    """Turn lines (r, m) of qx + i qy into those of uz, by the kernels of slots, (r, m//2 + 1), in place."""
    _put(lines, *_upright(xz, yz, *_by_sign(lines)))


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
    """Turn lines (r, m) of p and of qx + i qy into those of uz and of ux + i uy, in place.

    The others are the kernels of slots, (r, m//2 + 1).
    """
    p, q = _by_sign(pressure), _by_sign(shear)
    upright, sideways, in_plane = _upright(xz, yz, *q), _sideways(xz, yz, *p), _in_plane(xx, yy, xy, *q)
    _put(pressure, zz * p[0] + upright[0], zz * p[1] + upright[1])
    _put(shear, sideways[0] + in_plane[0], sideways[1] + in_plane[1])


Signs = tuple[ComplexArray, ComplexArray]
"""Values at the wave numbers 0..m//2 of lines, and at those with the other sign, both (r, m//2 + 1)."""


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


def _sideways(xz: FloatArray, yz: FloatArray, positive: ComplexArray, negative: ComplexArray) -> Signs:
    return 1j * ((xz - yz) * positive), -1j * ((xz + yz) * negative)


def _upright(xz: FloatArray, yz: FloatArray, positive: ComplexArray, negative: ComplexArray) -> Signs:
    along, against = 0.5 * (xz - yz), 0.5 * (xz + yz)
    return (-1j * (along * positive + against * negative.conj()), 1j * (against * negative + along * positive.conj()))


def fold_rows(upper: FloatArray, lower: FloatArray, odd: bool, lines: ComplexArray) -> None:
    """Put the cells of ``upper + i lower`` into lines (r, m): those of even numbers, then the odd ones in reverse.

    upper: (r, ny) with 2 ny <= 2 m; lower: as many rows or one less; odd: odd cells change their sign.
    """
    even_cells, odd_cells = lines[:, : (lines.shape[1] + 1) // 2], lines[:, : (lines.shape[1] - 1) // 2 : -1]
    lines[:] = 0.0
    for rows, part in ((upper, "real"), (lower, "imag")):
        first, second = rows[:, ::2], rows[:, 1::2]
        getattr(even_cells, part)[: len(rows), : first.shape[1]] = first
        getattr(odd_cells, part)[: len(rows), : second.shape[1]] = -second if odd else second


def unfold_rows(lines: ComplexArray, odd: bool, upper: FloatArray, lower: FloatArray) -> None:
    """Invert `fold_rows`."""
    even_cells, odd_cells = lines[:, : (lines.shape[1] + 1) // 2], lines[:, : (lines.shape[1] - 1) // 2 : -1]
    for rows, part in ((upper, "real"), (lower, "imag")):
        first, second = rows[:, ::2], rows[:, 1::2]
        first[:] = getattr(even_cells, part)[: len(rows), : first.shape[1]]
        second[:] = getattr(odd_cells, part)[: len(rows), : second.shape[1]]
        if odd:
            np.negative(second, out=second)


def to_slots(lines: ComplexArray, phases: ComplexArray, odd: bool, upper: FloatArray, lower: FloatArray) -> None:
    """Write the series of two real rows, (m, r), from the spectra of their folded lines (r, m).

    phases: exp(-i pi s/2m), (m,); lower: as many rows or one less; odd: slots are in reverse, but for the first.
    """
    found = phases * lines
    found[:, 1:] += phases[1:].conj() * lines[:, :0:-1]
    found[:, 0] += lines[:, 0]
    if odd:
        found[:, 1:] = found[:, :0:-1].copy()
    upper[:] = found.real.T
    lower[:] = found.imag.T[:, : lower.shape[1]]


def from_slots(upper: FloatArray, lower: FloatArray, phases: ComplexArray, odd: bool, lines: ComplexArray) -> None:
    """Invert `to_slots`, up to a factor: write the spectra of the folded lines (r, m) of two series, (m, r)."""
    values = np.zeros_like(lines)
    values.real = upper.T
    values.imag[: lower.shape[1]] = lower.T
    if odd:
        values[:, 1:] = values[:, :0:-1].copy()
    lines[:, 0] = values[:, 0]
    lines[:, 1:] = phases[1:].conj() * (values[:, 1:] - 1j * values[:, :0:-1])
