"""Invariants of stress: von Mises, largest tension, largest shear (Tresca).

A stress is an array ``(6, ...)`` of xx, yy, zz, xy, xz, yz in MPa, positive in tension.
"""

from __future__ import annotations

import numpy as np

from fretsolve.case.keys.quantity_names import INVARIANTS, Invariant
from fretsolve.system.arrays import DoubleArray

MEANINGS: dict[Invariant, str] = {
    "mises": "largest von Mises stress",
    "tension": "largest tension, the first principal stress",
    "tresca": "largest shear stress (Tresca), half of the difference of the outer principal stresses",
}


def von_mises(stress: DoubleArray) -> DoubleArray:
    """Return sqrt(3 J2), ``(...)``."""
    xx, yy, zz, xy, xz, yz = stress
    squared = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (xy * xy + xz * xz + yz * yz)
    root: DoubleArray = np.sqrt(squared)
    return root


def principal(stress: DoubleArray) -> DoubleArray:
    """Return the principal stresses, the largest first, ``(3, ...)``.

    By the angle of the deviator (Lode), whose rounding is 1e-8 of the von Mises stress where two of them are equal.
    """
    xx, yy, zz, xy, xz, yz = stress
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    radius = 2.0 / 3.0 * von_mises(stress)
    third = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(radius > 0.0, 4.0 * third / radius**3, 1.0)
    angle = np.arccos(np.clip(ratio, -1.0, 1.0)) / 3.0
    first = mean + radius * np.cos(angle)
    last = mean + radius * np.cos(angle + 2.0 * np.pi / 3.0)
    return np.stack([first, 3.0 * mean - first - last, last])


def invariant(name: Invariant, stress: DoubleArray) -> DoubleArray:
    """Return an invariant in each point, ``(...)``."""
    if name == "mises":
        return von_mises(stress)
    first, _, last = principal(stress)
    return np.asarray(first if name == "tension" else 0.5 * (first - last))


def largest(stress: DoubleArray) -> dict[Invariant, tuple[float, tuple[int, int]]]:
    """Return the largest value of each invariant of ``(6, nx, ny)`` and its cell.

    Principal stresses are computed only where they may be the largest: with the mean stress m and the von Mises stress
    s, the first one is at most m + 2 s/3 and at least m + s/3, and half their difference between s/2 and s/sqrt 3.
    """
    mises, mean = von_mises(stress), stress[:3].mean(axis=0)
    bounds = {"tension": (mean + mises / 3.0, mean + 2.0 / 3.0 * mises), "tresca": (0.5 * mises, mises / np.sqrt(3.0))}
    best = int(mises.argmax())
    found: dict[Invariant, tuple[float, tuple[int, int]]] = {"mises": (float(mises.flat[best]), _cell(best, mises))}
    for name in INVARIANTS[1:]:
        least, most = bounds[name]
        candidates = np.flatnonzero(most.ravel() >= least.max())
        values = invariant(name, stress.reshape(6, -1)[:, candidates])
        index = int(values.argmax())
        found[name] = float(values[index]), _cell(int(candidates[index]), mises)
    return found


def _cell(index: int, plane: DoubleArray) -> tuple[int, int]:
    row, column = np.unravel_index(index, plane.shape)
    return int(row), int(column)
