"""What double and single precision lose: the floor under residuals, and its name where a tolerance lies below it."""

from __future__ import annotations

import numpy as np

from fretsolve.system.arrays import DoubleArray

ROUNDING = 64.0 * float(np.finfo(np.float64).eps)
"""Of a displacement or a gap, in parts of the largest length that it is computed from."""

TINY = float(np.finfo(np.float64).tiny)
"""What scales are at least, so that nothing is divided by 0."""

SINGLE_ROUNDING = 5e-7
"""Largest error of the elastic operator in single precision, over its largest displacement."""

LEAST_SLIP = 1e-3
"""Slip directions count in full for slips down to this part of the rigid displacement increment; below it
the angle's weight falls with the slip, also where nothing slips more."""

LEAST_MOTION = 1e-6
"""The rigid displacement increment counts as no smaller than this part of the elastic displacements, whose
rounding it could not be told from otherwise."""


def rounding_of(precision: type[np.floating]) -> float:
    """Of displacements that the elastic operator computes in `precision`, in parts of the largest."""
    return SINGLE_ROUNDING if precision is np.float32 else ROUNDING


def circle_width(precision: type[np.floating]) -> float:
    """A cell slips where its shear, stored in `precision`, is within this part of the friction bound."""
    return 1e-6 if precision is np.float32 else 1e-10


def least_slip(elastic: float, rigid: DoubleArray, farthest: float, tolerance: float) -> float:
    """Length (mm) that slips are measured against at least: with it `tolerance` of it is no less than rounding.

    elastic: largest elastic displacement, which it does not exceed; rigid: delta_z, phi_x, phi_y, delta_x, delta_y,
    phi_z since the start; farthest: largest coordinate of a cell, which phi_z turns (mm).
    """
    dx, dy, turn = np.abs(rigid[3:])
    return min(ROUNDING * float(max(elastic, dx, dy, turn * farthest)) / tolerance, elastic)


def named_rounding(error: float, lengths: dict[str, float], precision: type[np.floating] = np.float64) -> str:
    """Which of `lengths` (mm) loses by its rounding what is `error` (mm), in words; empty where none does."""
    name = max(lengths, key=lambda key: lengths[key])
    if not error <= rounding_of(precision) * lengths[name]:
        return ""
    words = "single" if precision is np.float32 else "double"
    return f"{error:.2g} mm, the rounding of {name} ({lengths[name]:.3g} mm) in {words} precision"
