"""Rounding errors in double and single precision, and the smallest lengths that slips are measured against.

A residual cannot fall below the rounding of the lengths that it is computed from.
"""

from __future__ import annotations

import numpy as np

from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, vector_lengths

ROUNDING = 64.0 * float(np.finfo(np.float64).eps)
"""Rounding of a displacement or a gap, over the largest length that it is computed from."""

SINGLE_ROUNDING = 5e-7
"""Largest error of the elastic operator in single precision, over its largest displacement."""

LEAST_SLIP = 1e-3
"""Slip directions count in full for slips down to this part of the rigid displacement increment. Below it, the weight
of the angle between slip and shear falls with the slip."""

LEAST_MOTION = 1e-6
"""The rigid displacement increment counts as at least this part of the elastic displacements. A smaller one would be
lost in their rounding."""


def rounding_of(precision: type[np.floating]) -> float:
    """Return the rounding of displacements that the elastic operator computes, over the largest of them."""
    return SINGLE_ROUNDING if precision is np.float32 else ROUNDING


def circle_width(precision: type[np.floating]) -> float:
    """Return the distance from the friction limit, over the limit, within which a cell counts as slipping.

    precision: in which the shear traction is stored.
    """
    return 1e-6 if precision is np.float32 else 1e-10


def slips(shear: FloatArray, friction_limit: FloatArray, within: float) -> BoolArray:
    """Return the cells (nx, ny) whose shear (2, nx, ny) has reached the friction limit (nx, ny).

    within: part of the limit that the shear may lack, as `circle_width` of its precision.
    """
    reached: BoolArray = vector_lengths(shear) >= friction_limit * (1.0 - within)
    return reached


def least_slip(elastic: float, rigid: DoubleArray, farthest: float, tolerance: float) -> float:
    """Return the least scale of slips (mm) at which `tolerance` times the scale is not below rounding.

    It does not exceed `elastic`, the largest elastic displacement (mm). rigid: delta_z, phi_x, phi_y, delta_x, delta_y,
    phi_z since the start; farthest: largest coordinate of a cell (mm), where phi_z moves most.
    """
    dx, dy, turn = np.abs(rigid[3:])
    return min(ROUNDING * float(max(elastic, dx, dy, turn * farthest)) / tolerance, elastic)


def named_rounding(error: float, lengths: dict[str, float], precision: type[np.floating] = np.float64) -> str:
    """Describe `error` (mm) as the rounding of the largest of `lengths` (mm); return "" if it is larger than that."""
    name = max(lengths, key=lambda key: lengths[key])
    if not error <= rounding_of(precision) * lengths[name]:
        return ""
    words = "single" if precision is np.float32 else "double"
    return f"{error:.2g} mm, the rounding of {name} ({lengths[name]:.3g} mm) in {words} precision"
