"""Operations on spectra, compiled by numba. Each does what its namesake in `spectral_numpy` does.

`combine_mirrored` has none, since NumPy would take longer for it than it saves.
"""

from __future__ import annotations

import numpy as np

from fretsolve.kernels.numba_options import exact, inlined
from fretsolve.kernels.numba_options import kernel as compiled

TILE = 8
"""Rows and columns transposed at a time: in double precision 8 complex numbers fill two cache lines. Loops of
this fixed length become vector instructions."""


@compiled
def join_rows(upper, lower, lines):
    """Compute ``lines = upper + i lower``, (r, m), padded with zeros; upper: (r, ny), lower: as many or one less."""
    rows, ny = upper.shape
    for r in range(rows):
        if r < lower.shape[0]:
            for j in range(ny):
                lines[r, j] = complex(upper[r, j], lower[r, j])
        else:
            for j in range(ny):
                lines[r, j] = upper[r, j]
        lines[r, ny:] = 0.0


@compiled
def split_rows(lines, upper, lower):
    """Copy the real parts of `lines` (r, m) to `upper` (r, ny) and the imaginary parts to `lower`."""
    rows, ny = upper.shape
    for r in range(rows):
        for j in range(ny):
            upper[r, j] = lines[r, j].real
        if r < lower.shape[0]:
            for j in range(ny):
                lower[r, j] = lines[r, j].imag


@compiled
def split_spectra(lines, upper, lower):
    """Compute the spectra (r, m//2 + 1) of two real rows from that of the upper one plus i times the lower, (r, m)."""
    rows, columns = upper.shape
    length = lines.shape[1]
    half = upper.real.dtype.type(0.5)
    mirrored = np.empty(columns, lines.dtype)  # the loops below then run forward, in vector instructions
    unused = np.empty(columns, lines.dtype)
    for r in range(rows):
        one, other = upper[r], lower[r] if r < lower.shape[0] else unused
        mirrored[0] = lines[r, 0]
        for k in range(1, columns):
            mirrored[k] = lines[r, length - k]
        for k in range(columns):
            a, b = lines[r, k], mirrored[k]
            one[k] = complex(half * (a.real + b.real), half * (a.imag - b.imag))
            other[k] = complex(half * (a.imag + b.imag), half * (b.real - a.real))


@compiled
def join_spectra(upper, lower, lines):
    """Invert `split_spectra`. Imaginary parts at wave numbers that stand for both signs are left out."""
    rows, columns = upper.shape
    length = lines.shape[1]
    nothing, mirrored = np.zeros(columns, lines.dtype), np.empty(columns, lines.dtype)
    for r in range(rows):
        one, other = upper[r], lower[r] if r < lower.shape[0] else nothing
        for k in range(columns):
            a, b = one[k], other[k]
            lines[r, k] = complex(a.real - b.imag, a.imag + b.real)
            mirrored[k] = complex(a.real + b.imag, b.real - a.imag)
        for k in range(columns, length):
            lines[r, k] = mirrored[length - k]
        # These wave numbers stand for both signs.
        lines[r, 0] = complex(one[0].real, other[0].real)
        if length % 2 == 0:
            lines[r, length // 2] = complex(one[length // 2].real, other[length // 2].real)


@compiled
def take_columns(spectrum, lines):
    """Copy the columns of `spectrum` (nx, n) to `lines` (n, mx), padded with zeros."""
    rows, columns = spectrum.shape
    _transpose(spectrum, lines, columns, rows)
    lines[:, rows:] = 0.0


@compiled
def give_columns(lines, spectrum):
    """Copy the first nx numbers of `lines` (n, mx) to the columns of `spectrum` (nx, n)."""
    rows, columns = spectrum.shape
    _transpose(lines, spectrum, rows, columns)


@inlined
def _transpose(source, target, rows, columns):
    """Copy the transpose of `source` to the first `rows` and `columns` of `target`, by tiles."""
    whole_rows, whole_columns = rows // TILE * TILE, columns // TILE * TILE
    for first in range(0, whole_rows, TILE):
        for start in range(0, whole_columns, TILE):
            for i in range(TILE):
                for j in range(TILE):
                    target[first + i, start + j] = source[start + j, first + i]
    for i in range(whole_rows, rows):
        for j in range(whole_columns):
            target[i, j] = source[j, i]
    for j in range(whole_columns, columns):
        for i in range(rows):
            target[i, j] = source[j, i]


@compiled
def multiply(kernel, odd, field, result):
    """Compute ``result = kernel field``; `result` may be the field."""
    lines, length = field.shape
    half = kernel.shape[1]
    one = kernel.dtype.type(1.0)
    sign = -one if odd else one
    for n in range(lines):
        for i in range(half):
            result[n, i] = field[n, i] * kernel[n, i]
        for i in range(half, length):
            result[n, i] = field[n, i] * (sign * kernel[n, length - i])


def multiply_symmetric(kernels, odd, fields):
    """Multiply two or three fields, in place, by a symmetric matrix of kernels; `odd` is even on the diagonal."""
    if len(fields) == 2:
        _multiply_pair(kernels[0] + kernels[1], odd[0][1], fields)
    else:
        _multiply_triple(kernels[0] + kernels[1] + kernels[2], (odd[0][1], odd[0][2], odd[1][2]), fields)


@compiled
def _multiply_pair(kernels, odd, fields):
    """Multiply two fields by a symmetric 2 x 2 matrix of kernels, (4, n, half)."""
    direct_x, mixed, _, direct_y = kernels
    field_x, field_y = fields
    lines, length = field_x.shape
    half = mixed.shape[1]
    one = mixed.dtype.type(1.0)
    sign = -one if odd else one
    for n in range(lines):
        for i in range(half):
            x, y, across = field_x[n, i], field_y[n, i], mixed[n, i]
            field_x[n, i] = x * direct_x[n, i] + y * across
            field_y[n, i] = x * across + y * direct_y[n, i]
        for i in range(half, length):
            x, y, across = field_x[n, i], field_y[n, i], sign * mixed[n, length - i]
            field_x[n, i] = x * direct_x[n, length - i] + y * across
            field_y[n, i] = x * across + y * direct_y[n, length - i]


@compiled
def _multiply_triple(kernels, odd, fields):
    """Multiply three fields by a symmetric 3 x 3 matrix of kernels, (9, n, half)."""
    direct_z, mixed_zx, mixed_zy, _, direct_x, mixed_xy, _, _, direct_y = kernels
    field_z, field_x, field_y = fields
    lines, length = field_z.shape
    half = direct_z.shape[1]
    one = direct_z.dtype.type(1.0)
    for n in range(lines):
        for i in range(length):
            mirrored = i if i < half else length - i
            sign_zx = -one if odd[0] and i >= half else one
            sign_zy = -one if odd[1] and i >= half else one
            sign_xy = -one if odd[2] and i >= half else one
            z, x, y = field_z[n, i], field_x[n, i], field_y[n, i]
            zx, zy = sign_zx * mixed_zx[n, mirrored], sign_zy * mixed_zy[n, mirrored]
            xy = sign_xy * mixed_xy[n, mirrored]
            field_z[n, i] = z * direct_z[n, mirrored] + x * zx + y * zy
            field_x[n, i] = z * zx + x * direct_x[n, mirrored] + y * xy
            field_y[n, i] = z * zy + x * xy + y * direct_y[n, mirrored]


@exact
def combine(factors, spectra, results, product):
    """Compute ``results = factors spectra``, (m, k) of (m, n, k) and (n, k).

    In one pass, where NumPy takes three: a convolution of two fields on 32 to 64 points takes about 0.9 of the time.
    """
    rows, columns, count = factors.shape
    for row in range(rows):
        if columns == 1:
            for k in range(count):
                results[row, k] = factors[row, 0, k] * spectra[0, k]
        elif columns == 2:
            for k in range(count):
                results[row, k] = factors[row, 0, k] * spectra[0, k] + factors[row, 1, k] * spectra[1, k]
        else:
            for k in range(count):
                sums = factors[row, 0, k] * spectra[0, k] + factors[row, 1, k] * spectra[1, k]
                results[row, k] = sums + factors[row, 2, k] * spectra[2, k]


@exact
def combine_mirrored(mean, rest, field, result):
    """Compute ``result = mean field + rest conj(field at -k)`` at wave numbers k, (mx, my); `mean` is real."""
    rows, columns = field.shape
    mirrored = np.empty(columns, field.dtype)  # the loop below then runs forward, in vector instructions
    for i in range(rows):
        other = field[rows - i if i else 0]
        mirrored[0] = other[0]
        for j in range(1, columns):
            mirrored[j] = other[columns - j]
        for j in range(columns):
            z, m, r, s = field[i, j], mirrored[j], rest[i, j], mean[i, j]
            real = r.real * m.real + r.imag * m.imag
            imag = r.imag * m.real - r.real * m.imag
            result[i, j] = complex(s * z.real + real, s * z.imag + imag)


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
    rows, ny = upper.shape
    length = lines.shape[1]
    one = upper.dtype.type(1.0)
    sign = -one if odd else one
    for r in range(rows):
        line = lines[r]
        line[(ny + 1) // 2 : length - ny // 2] = 0.0
        if r < lower.shape[0]:
            for j in range((ny + 1) // 2):
                line[j] = complex(upper[r, 2 * j], lower[r, 2 * j])
            for j in range(ny // 2):
                line[length - 1 - j] = complex(sign * upper[r, 2 * j + 1], sign * lower[r, 2 * j + 1])
        else:
            for j in range((ny + 1) // 2):
                line[j] = upper[r, 2 * j]
            for j in range(ny // 2):
                line[length - 1 - j] = sign * upper[r, 2 * j + 1]


@compiled
def unfold_rows(lines, odd, upper, lower):
    """Invert `fold_rows`."""
    rows, ny = upper.shape
    length = lines.shape[1]
    one = upper.dtype.type(1.0)
    sign = -one if odd else one
    for r in range(rows):
        line = lines[r]
        for j in range((ny + 1) // 2):
            upper[r, 2 * j] = line[j].real
        for j in range(ny // 2):
            upper[r, 2 * j + 1] = sign * line[length - 1 - j].real
        if r < lower.shape[0]:
            for j in range((ny + 1) // 2):
                lower[r, 2 * j] = line[j].imag
            for j in range(ny // 2):
                lower[r, 2 * j + 1] = sign * line[length - 1 - j].imag


@compiled
def to_slots(lines, phases, odd, upper, lower):
    """Write the series of two real rows, (m, r), from the spectra of their folded lines (r, m)."""
    rows, length = lines.shape
    # slots k and m - k follow from the same numbers a = w z_k and b = conj(w) z_(m-k): a + b and i (a - b)
    real, imag = np.empty((length, TILE), upper.dtype), np.empty((length, TILE), upper.dtype)
    for first in range(0, rows, TILE):
        count = min(TILE, rows - first)
        for r in range(count):
            line = lines[first + r]
            real[0, r], imag[0, r] = line[0].real + line[0].real, line[0].imag + line[0].imag
            for k in range(1, length // 2 + 1):
                a, b = phases[k] * line[k], phases[k].conjugate() * line[length - k]
                added, taken = a + b, a - b
                real[k, r], imag[k, r] = added.real, added.imag
                real[length - k, r], imag[length - k, r] = -taken.imag, taken.real
        _copy_slots(real, odd, upper[:, first : first + count])
        _copy_slots(imag, odd, lower[:, first : first + count])


@inlined
def _copy_slots(values, odd, slots):
    """Copy `values` to `slots`, in reverse but for the first where they are `odd`."""
    length, columns = slots.shape
    for k in range(length):
        slot = length - k if odd and k else k
        for r in range(columns):
            slots[slot, r] = values[k, r]


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
