"""What double precision loses: the floor under residuals, and its name where a tolerance lies below it."""

from __future__ import annotations

import numpy as np

ROUNDING = 64.0 * float(np.finfo(np.float64).eps)
"""Of a displacement or a gap, in parts of the largest length that it is computed from."""


def least_slip(elastic: float, farthest: float, tolerance: float) -> float:
    """Length (mm) that slips are measured against at least: with it `tolerance` of it is no less than rounding.

    elastic: largest elastic displacement, which it does not exceed; farthest: largest rigid displacement since the
    start (mm).
    """
    return min(ROUNDING * max(elastic, farthest) / tolerance, elastic)


def named_rounding(error: float, lengths: dict[str, float]) -> str:
    """Which of `lengths` (mm) loses by its rounding what is `error` (mm), in words; empty where none does."""
    name = max(lengths, key=lambda key: lengths[key])
    if not error <= ROUNDING * lengths[name]:
        return ""
    return f"{error:.2g} mm, the rounding of {name} ({lengths[name]:.3g} mm) in double precision"
