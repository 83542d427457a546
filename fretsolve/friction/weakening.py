"""Find whether friction that falls with slip lets the slip run away.

In an increment friction is fixed, so there is always one solution. Over many small increments the slip of a contact
that slides as a whole grows by itself once the largest eigenvalue of A diag(w) reaches 1. A is the tangential
compliance of the cells in contact and w the fall of the friction limit per slip. Beyond, the result depends on the
increments.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.errors import WeakeningError
from fretsolve.friction.bound import FrictionBound
from fretsolve.reference.hertz import HertzContact
from fretsolve.system.arrays import TINY, DoubleArray, FloatArray

MOST_STEPS, CLOSE = 30, 1e-3
"""Power steps, and the change at which the eigenvalue is known well enough."""

OF_PRESSURE, OF_PRESSURE_SQUARED = 1.300, 1.082
"""Eigenvalue over w0 a S/4 where the fall goes with Hertz's pressure and with its square, w0 in the middle; by
`largest_growth` on 128 x 128 points."""


def fall_per_slip(spec: FrictionSpec, pressure: FloatArray, bound: FrictionBound) -> DoubleArray | None:
    """Return by how much the friction limit falls per slip (MPa/mm), (nx, ny); None where it does not fall.

    pressure: at the increment's start (MPa); bound: in the increment. The shear limit holds whatever the coefficient.
    """
    if spec.initial is None or spec.final is None or spec.final >= spec.initial:
        return None
    pressure = pressure.astype(np.float64)
    limit, per_coefficient = (
        one.limit(pressure) for one in (bound, replace(bound, coefficient=1.0, shear_limit=math.inf))
    )
    fall = per_coefficient * (bound.coefficient - spec.final)
    fall *= 1.0 / spec.slip if spec.slip else limit / (spec.energy or 1.0)
    return np.where(limit < bound.shear_limit, fall, 0.0)


def largest_growth(fall: DoubleArray, operator: ElasticOperator) -> float:
    """Return the largest eigenvalue of A diag(fall), by power steps on its symmetric form."""
    root = np.sqrt(fall)
    vector, found = root / max(float(np.linalg.norm(root)), TINY), 0.0
    shear, moved = np.zeros((2, *fall.shape)), np.zeros((2, *fall.shape))
    for _ in range(MOST_STEPS):
        shear[0] = root * vector
        operator.tangential(shear, moved)
        image = root * moved[0]
        before, found = found, float(np.vdot(vector, image))
        vector = image / max(float(np.linalg.norm(image)), TINY)
        if abs(found - before) <= CLOSE * found:
            break
    return found


def growth_on_sphere(spec: FrictionSpec, hertz: HertzContact, compliance: float) -> float:
    """Return the eigenvalue on Hertz's contact of a sphere before any slip; 0 where friction does not fall, or falls
    neither with the pressure nor with its square. compliance: the tangential one (1/MPa)."""
    if spec.initial is None or spec.final is None or spec.final >= spec.initial:
        return 0.0
    if spec.exponent is not None or (spec.shear_limit or math.inf) < spec.initial * hertz.max_pressure:
        return 0.0
    drop, arm = (spec.initial - spec.final) * hertz.max_pressure, 0.25 * compliance * hertz.contact_radius
    if spec.slip:
        return OF_PRESSURE * drop / spec.slip * arm
    return OF_PRESSURE_SQUARED * drop / (spec.energy or 1.0) * spec.initial * hertz.max_pressure * arm


def require_stable(spec: FrictionSpec, pressure: FloatArray, bound: FrictionBound, operator: ElasticOperator) -> None:
    """Raise WeakeningError where friction falls so fast that slip may run away, unless the case allows it.

    pressure, bound: as for `fall_per_slip`.
    """
    fall = None if spec.weakening == "allow" else fall_per_slip(spec, pressure, bound)
    if fall is None or not fall.any():
        return
    growth = largest_growth(fall, operator)
    if growth >= 1.0:
        over = "slip" if spec.slip else "energy"
        raise WeakeningError(
            f"friction falls too fast with slip: the fall of the friction limit is {growth:.3g} times what the elastic"
            f" surfaces hold against it, so that slip runs away and depends on the increments; a larger friction.{over}"
            " is needed, or weakening: allow"
        )
