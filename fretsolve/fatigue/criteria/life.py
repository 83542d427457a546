"""Lives by strain-life curves, which fall with the number of cycles N."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.system.arrays import DoubleArray

LONGEST = 1e12
"""Cycles beyond which a life counts as endless."""


def shear_strain_lives(material: Material, value: DoubleArray) -> DoubleArray | None:
    """Return N of Fatemi and Socie's parameter: (tf'/G) (2N)^b + gf' (2N)^c = value. None without a curve."""
    curve = material.shear_strain_life
    if curve is None:
        return None
    strength = curve.strength / material.shear_modulus
    return lives(value, [(strength, curve.strength_exponent), (curve.ductility, curve.ductility_exponent)])


def swt_lives(material: Material, value: DoubleArray) -> DoubleArray | None:
    """Return N of Smith, Watson and Topper's parameter: (sf'^2/E) (2N)^2b + sf' ef' (2N)^(b+c) = value.

    None without a curve.
    """
    curve = material.strain_life
    if curve is None:
        return None
    b, c = curve.strength_exponent, curve.ductility_exponent
    elastic = curve.strength**2 / material.needed("young_modulus")
    return lives(value, [(elastic, 2.0 * b), (curve.strength * curve.ductility, b + c)])


def lives(value: DoubleArray, terms: Sequence[tuple[float, float]]) -> DoubleArray:
    """Return N with sum of factor (2N)^exponent = value, from `terms` (factor >= 0, exponent < 0).

    inf where N would be above `LONGEST`, 0 where it would be below half a cycle.
    """
    low, high = np.zeros(len(value)), np.full(len(value), np.log(2.0 * LONGEST))
    # Bisect ln(2N), over which the sum falls; 60 halvings reach rounding.
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = sum(factor * np.exp(exponent * middle) for factor, exponent in terms) > value
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    found: DoubleArray = 0.5 * np.exp(0.5 * (low + high))
    found[high >= np.log(2.0 * LONGEST)] = np.inf
    found[low <= 0.0] = 0.0
    return found
