"""Kernels of the normal problem. N1 to N8 are its steps in docs/theory.md.

Fields are (nx, ny); `x` (nx,) and `y` (ny,) are the cells' centres. A rigid displacement of amplitudes (a, b, c) is
a + b y + c x. `separation` is inf where there is no material. Loops are over the rows `first` to `stop`.
"""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.kernels.compiling import compiled, larger, largest_of
from fretsolve.system.arrays import BoolArray, FloatArray, Products, Sums


def sum_gaps(
    separation: FloatArray, uz: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray, contact: BoolArray
) -> Sums:
    """Return the sums over the contact of the gap times 1, y, x (N2)."""
    gap = np.empty_like(uz)
    _gap(separation, uz, rigid, x, y, gap)
    gap[~contact] = 0.0
    return sum_modes(gap, x, y)


@compiled
def sum_gaps_loops(first, stop, separation, uz, rigid, x, y, contact):
    _, ny = uz.shape
    all_one, all_y, all_x = 0.0, 0.0, 0.0
    for i in range(first, stop):
        along, one, turned = rigid[0] + rigid[2] * x[i], 0.0, 0.0
        for j in range(ny):
            gap = separation[i, j] + uz[i, j] - along - rigid[1] * y[j] if contact[i, j] else 0.0
            one += gap
            turned += gap * y[j]
        all_one += one
        all_y += turned
        all_x += one * x[i]
    return all_one, all_y, all_x


def take_gap(
    separation: FloatArray,
    uz: FloatArray,
    rigid: FloatArray,
    x: FloatArray,
    y: FloatArray,
    contact: BoolArray,
    gap: FloatArray,
) -> tuple[float, float, float]:
    """Compute ``gap = separation + uz - rigid displacement`` (T1, N3).

    Return its largest absolute value in contact, the deepest penetration elsewhere, and the largest uz in contact.
    """
    _gap(separation, uz, rigid, x, y, gap)
    in_contact = float(np.max(np.abs(gap), where=contact, initial=0.0))
    penetration = -float(np.min(gap, where=~contact, initial=0.0))
    return in_contact, penetration, float(np.max(uz, where=contact, initial=0.0))


@compiled
def take_gap_loops(first, stop, separation, uz, rigid, x, y, contact, gap):
    _, ny = uz.shape
    sizes, depths, heights = np.zeros(ny), np.zeros(ny), np.zeros(ny)
    for i in range(first, stop):
        along = rigid[0] + rigid[2] * x[i]
        for j in range(ny):
            inside, raised = contact[i, j], uz[i, j]
            found = separation[i, j] + raised - along - rigid[1] * y[j]
            gap[i, j] = found
            sizes[j] = larger(abs(found) if inside else 0.0, sizes[j])
            depths[j] = larger(0.0 if inside else -found, depths[j])
            heights[j] = larger(raised if inside else 0.0, heights[j])
    return largest_of(sizes), largest_of(depths), largest_of(heights)


def largest_change(before: FloatArray, after: FloatArray, contact: BoolArray) -> float:
    """Return the largest absolute difference in the contact (ST7)."""
    change = np.subtract(after, before, where=contact, out=np.zeros_like(after))
    return float(np.abs(change, out=change).max())


@compiled
def largest_change_loops(first, stop, before, after, contact):
    _, ny = before.shape
    sizes = np.zeros(ny)
    for i in range(first, stop):
        for j in range(ny):
            sizes[j] = larger(abs(after[i, j] - before[i, j]) if contact[i, j] else 0.0, sizes[j])
    return largest_of(sizes)


def gram(weight: FloatArray | BoolArray, x: FloatArray, y: FloatArray) -> Products:
    """Return the weighted sums of products of 1, y, x, 3 x 3."""
    along_x, along_y = weight.sum(axis=1, dtype=np.float64), weight.sum(axis=0, dtype=np.float64)
    one_y, one_x, mixed = float(along_y @ y), float(along_x @ x), float(x @ (weight @ y))
    yy, xx = float(along_y @ y**2), float(along_x @ x**2)
    return (float(along_x.sum()), one_y, one_x), (one_y, yy, mixed), (one_x, mixed, xx)


@compiled
def gram_loops(first, stop, weight, x, y):
    _, ny = weight.shape
    total, all_y, all_x, yy, xy, xx = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(first, stop):
        one, along, squared = 0.0, 0.0, 0.0
        for j in range(ny):
            w = 1.0 * weight[i, j]
            one += w
            along += w * y[j]
            squared += w * y[j] * y[j]
        total += one
        all_y += along
        yy += squared
        all_x += one * x[i]
        xy += along * x[i]
        xx += one * x[i] * x[i]
    return (total, all_y, all_x), (all_y, yy, xy), (all_x, xy, xx)


def sum_modes(field: FloatArray, x: FloatArray, y: FloatArray) -> Sums:
    """Return the sums of the field times 1, y, x."""
    along_x, along_y = field.sum(axis=1, dtype=np.float64), field.sum(axis=0, dtype=np.float64)
    return float(along_x.sum()), float(along_y @ y), float(along_x @ x)


@compiled
def sum_modes_loops(first, stop, field, x, y):
    _, ny = field.shape
    all_one, all_y, all_x = 0.0, 0.0, 0.0
    for i in range(first, stop):
        one, turned = 0.0, 0.0
        for j in range(ny):
            one += field[i, j]
            turned += field[i, j] * y[j]
        all_one += one
        all_y += turned
        all_x += one * x[i]
    return all_one, all_y, all_x


def stretch(pressure: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray) -> None:
    """Multiply the pressure by 1 + the rigid displacement; negative values become 0 (N7)."""
    pressure *= 1.0 + (rigid[0] + rigid[1] * y[None, :] + rigid[2] * x[:, None])
    np.maximum(pressure, 0.0, out=pressure)


@compiled
def stretch_loops(first, stop, pressure, rigid, x, y):
    _, ny = pressure.shape
    for i in range(first, stop):
        along = 1.0 + rigid[0] + rigid[2] * x[i]
        for j in range(ny):
            stretched = pressure[i, j] * (along + rigid[1] * y[j])
            pressure[i, j] = 0.0 if stretched < 0.0 else stretched


def _gap(
    separation: FloatArray, uz: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray, gap: FloatArray
) -> None:
    """Compute ``gap = separation + uz - rigid displacement`` (T1)."""
    np.add(separation, uz, out=gap)
    gap -= rigid[0] + rigid[1] * y[None, :] + rigid[2] * x[:, None]
