"""Invariants of stresses (steps, 6, points), in the order xx, yy, zz, xy, xz, yz."""

from __future__ import annotations

import math

import numpy as np

from fretsolve.system.arrays import DoubleArray

COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def hydrostatic(stress: DoubleArray) -> DoubleArray:
    """Return sH = tr/3, (steps, points)."""
    return np.asarray((stress[:, 0] + stress[:, 1] + stress[:, 2]) / 3.0)


def deviator_vectors(stress: DoubleArray) -> DoubleArray:
    """Return the deviators as vectors (steps, 5, points) of length sqrt(J2)."""
    mean = hydrostatic(stress)
    along_x, along_y = stress[:, 0] - mean, stress[:, 1] - mean
    first, second = 0.5 * math.sqrt(3.0) * along_x, 0.5 * along_x + along_y
    return np.stack([first, second, stress[:, 3], stress[:, 4], stress[:, 5]], axis=1)


def extreme_deviators(vectors: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Return the largest and the smallest principal value of deviators given as vectors (..., 5, points).

    They are 2 sqrt(J2/3) cos(a) and 2 sqrt(J2/3) cos(a + 2 pi/3), with cos(3a) = (3 sqrt(3)/2) J3/J2^(3/2).
    """
    first, second, xy, xz, yz = np.moveaxis(vectors, -2, 0)
    xx = (2.0 / math.sqrt(3.0)) * first
    yy = second - 0.5 * xx
    zz = -xx - yy
    J2 = np.square(vectors).sum(axis=-2)
    J3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    size = 2.0 * np.sqrt(J2 / 3.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(J2 > 0.0, 4.0 * J3 / size**3, 1.0)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    return size * np.cos(angle), size * np.cos(angle + 2.0 * math.pi / 3.0)
