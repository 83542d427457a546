"""Kernels of the normal problem in NumPy. N1 to N8 are its steps in docs/theory.md.

Fields are (nx, ny); `x` (nx,) and `y` (ny,) are the cells' centres. A rigid displacement of amplitudes (a, b, c) is
a + b y + c x. `separation` is inf where there is no material.
"""

from __future__ import annotations

import numpy as np

from fretsolve.system.arrays import BoolArray, FloatArray, Products, Sums


def sum_gaps(
    separation: FloatArray, uz: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray, contact: BoolArray
) -> Sums:
    """Return the sums over the contact of the gap times 1, y, x (N2)."""
    gap = np.empty_like(uz)
    _gap(separation, uz, rigid, x, y, gap)
    gap[~contact] = 0.0
    return sum_modes(gap, x, y)


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


def largest_change(before: FloatArray, after: FloatArray, contact: BoolArray) -> float:
    """Return the largest absolute difference in the contact (ST7)."""
    change = np.subtract(after, before, where=contact, out=np.zeros_like(after))
    return float(np.abs(change, out=change).max())


def gram(weight: FloatArray | BoolArray, x: FloatArray, y: FloatArray) -> Products:
    """Return the weighted sums of products of 1, y, x, 3 x 3."""
    along_x, along_y = weight.sum(axis=1, dtype=np.float64), weight.sum(axis=0, dtype=np.float64)
    one_y, one_x, mixed = float(along_y @ y), float(along_x @ x), float(x @ (weight @ y))
    yy, xx = float(along_y @ y**2), float(along_x @ x**2)
    return (float(along_x.sum()), one_y, one_x), (one_y, yy, mixed), (one_x, mixed, xx)


def sum_modes(field: FloatArray, x: FloatArray, y: FloatArray) -> Sums:
    """Return the sums of the field times 1, y, x."""
    along_x, along_y = field.sum(axis=1, dtype=np.float64), field.sum(axis=0, dtype=np.float64)
    return float(along_x.sum()), float(along_y @ y), float(along_x @ x)


def stretch(pressure: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray) -> None:
    """Multiply the pressure by 1 + the rigid displacement; negative values become 0 (N7)."""
    pressure *= 1.0 + (rigid[0] + rigid[1] * y[None, :] + rigid[2] * x[:, None])
    np.maximum(pressure, 0.0, out=pressure)


def _gap(
    separation: FloatArray, uz: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray, gap: FloatArray
) -> None:
    """Compute ``gap = separation + uz - rigid displacement`` (T1)."""
    np.add(separation, uz, out=gap)
    gap -= rigid[0] + rigid[1] * y[None, :] + rigid[2] * x[:, None]
