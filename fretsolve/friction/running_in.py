"""Over how many cycles friction that runs in stays nearly the same, so that one solved cycle may stand for them."""

from __future__ import annotations

import math
import sys
from itertools import pairwise

import numpy as np

from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.result.state import Fields
from fretsolve.system.arrays import FloatArray

MOST_CHANGE = 0.05
"""Change of the coefficient over such cycles, over the largest coefficient."""


def cycles_of_little_change(
    spec: FrictionSpec, cycles: float, fields: Fields, energy: FloatArray, path: FloatArray
) -> float:
    """Return the number of cycles, at least 1, over which no cell's coefficient changes much; infinite for any.

    A cell that dissipates half as much as the one that dissipates most may change twice as much.

    cycles, fields: at the end of the last cycle; energy: dissipated per area (mJ/mm^2), path: of slip (mm) in it.
    """
    if spec.initial is not None and spec.final is not None:
        largest, drop = max(spec.initial, spec.final), abs(spec.final - spec.initial)
        scale = spec.slip or spec.energy or 1.0
        so_far, more = (fields.slip_path, path) if spec.slip else (fields.work_density, energy)
        # a cell counts by what it dissipates: of those that have just come into contact there are always some
        weight = energy / max(float(energy.max()), sys.float_info.min)
        in_a_cycle = float((weight * drop * np.exp(-so_far / scale) * more / scale).max())
        return max(1.0, MOST_CHANGE * largest / in_a_cycle) if in_a_cycle > 0.0 else math.inf
    for (before, low), (after, high) in pairwise(spec.cycles or ()):
        if cycles < before:
            return max(1.0, before - cycles)
        if cycles < after and low != high:
            in_a_cycle = abs(high - low) / (after - before)
            return max(1.0, min(after - cycles, MOST_CHANGE * max(low, high) / in_a_cycle))
        if cycles < after:
            return max(1.0, after - cycles)
    return math.inf
