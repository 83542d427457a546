"""Where and at which pressure a body begins to yield under Hertz's pressure without shear, by von Mises.

The stresses are those below the middle of the contact: of a circle Johnson (1985), (3.45), of a line McEwen (1949). In
a line contact the largest von Mises stress may also lie on the surface, where nu is below some 0.2.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from fretsolve.system.arrays import DoubleArray

DEEPEST = 2.0
"""Depth over a, beyond which stresses only fall."""


class YieldOnset(NamedTuple):
    """Largest pressure over the yield stress at which a body begins to yield, and the depth over a at which it does.

    a is the radius of a circle, or the half-width of a line.
    """

    pressure: float
    depth: float


@cache
def yield_onset(poisson_ratio: float, *, line: bool) -> YieldOnset:
    """Return where a body begins to yield under Hertz's pressure on a circle or a line (plane strain)."""
    mises = _mises_of_line if line else _mises_of_circle
    low, high = 0.0, DEEPEST
    for _ in range(8):  # each look is 50 times finer
        depths = np.linspace(low, high, 101)
        best = int(mises(depths, poisson_ratio).argmax())
        low, high = float(depths[max(best - 1, 0)]), float(depths[min(best + 1, 100)])
    depth = 0.5 * (low + high) if low > 0.0 else 0.0
    return YieldOnset(1.0 / float(mises(np.array([depth]), poisson_ratio)[0]), depth)


def _mises_of_circle(depth: DoubleArray, poisson_ratio: float) -> DoubleArray:
    """Return the von Mises stress over the largest pressure; radial and circumferential stress are equal."""
    closeness = 1.0 - depth * np.arctan2(1.0, depth)
    return np.abs(1.5 / (1.0 + depth**2) - (1.0 + poisson_ratio) * closeness)


def _mises_of_line(depth: DoubleArray, poisson_ratio: float) -> DoubleArray:
    """Return the von Mises stress over the largest pressure."""
    root = np.sqrt(1.0 + depth**2)
    xx, zz = 2.0 * depth - (1.0 + 2.0 * depth**2) / root, -1.0 / root
    yy = poisson_ratio * (xx + zz)
    return np.asarray(np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)))
