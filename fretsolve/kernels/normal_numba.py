"""Kernels of the normal problem over the rows `first` to `stop`, compiled by numba, as those in `normal_numpy`."""

from __future__ import annotations

import numpy as np

from fretsolve.kernels.numba_options import kernel, larger, largest_of


@kernel
def sum_gaps(first, stop, separation, uz, rigid, x, y, contact):
    """Return the sums over the contact of the gap times 1, y, x (N2)."""
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


@kernel
def take_gap(first, stop, separation, uz, rigid, x, y, contact, gap):
    """Compute ``gap = separation + uz - rigid displacement`` (T1, N3)."""
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


@kernel
def largest_change(first, stop, before, after, contact):
    """Return the largest absolute difference in the contact (ST7)."""
    _, ny = before.shape
    sizes = np.zeros(ny)
    for i in range(first, stop):
        for j in range(ny):
            sizes[j] = larger(abs(after[i, j] - before[i, j]) if contact[i, j] else 0.0, sizes[j])
    return largest_of(sizes)


@kernel
def gram(first, stop, weight, x, y):
    """Return the weighted sums of products of 1, y, x, 3 x 3."""
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


@kernel
def sum_modes(first, stop, field, x, y):
    """Return the sums of the field times 1, y, x."""
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


@kernel
def stretch(first, stop, pressure, rigid, x, y):
    """Multiply the pressure by 1 + the rigid displacement; negative values become 0 (N7)."""
    _, ny = pressure.shape
    for i in range(first, stop):
        along = 1.0 + rigid[0] + rigid[2] * x[i]
        for j in range(ny):
            stretched = pressure[i, j] * (along + rigid[1] * y[j])
            pressure[i, j] = 0.0 if stretched < 0.0 else stretched
