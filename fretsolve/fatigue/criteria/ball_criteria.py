"""Criteria of the smallest ball around the path of the deviator; they have no critical plane."""

from __future__ import annotations

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.fatigue.criteria.invariants import deviator_vectors, extreme_deviators, hydrostatic
from fretsolve.fatigue.criteria.smallest_ball import smallest_ball
from fretsolve.system.arrays import DoubleArray


def crossland(material: Material, stress: DoubleArray) -> DoubleArray:
    """Return sqrt(J2a) + aC max sH (Crossland 1956), (points,), of stresses (steps, 6, points).

    sqrt(J2a) is the radius of the smallest ball around the deviator's path.
    """
    amplitude, _ = smallest_ball(deviator_vectors(stress))
    return np.asarray(amplitude + material.crossland_factor * hydrostatic(stress).max(axis=0))


def dang_van(material: Material, stress: DoubleArray) -> DoubleArray:
    """Return max [Tresca(s_dev - s*) + aD sH] (Dang Van 1993), (points,), of stresses (steps, 6, points).

    s* is the centre of the smallest ball around the deviator's path; Tresca is half of sI - sIII.
    """
    path = deviator_vectors(stress)
    _, center = smallest_ball(path)
    largest, smallest = extreme_deviators(path - center)
    return np.asarray((0.5 * (largest - smallest) + material.dang_van_factor * hydrostatic(stress)).max(axis=0))
