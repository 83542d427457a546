"""The worn depth per pressure and cycle, of cells that touch and of those that will as the contact grows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.friction.limit import FrictionLimit
from fretsolve.result.state import WearState
from fretsolve.system.arrays import DoubleArray, FloatArray
from fretsolve.wear.law import WearLaw

LEAST_PRESSURE = 0.1
"""Pressure, over the mean one in contact, at which the law of wear holds for cells that hardly touch or do not touch
yet, where it depends on the pressure. A power of no pressure would give a rate of zero, or one without limit. With
the exponent 2 half or twice of it changes volumes by less than 0.1 %."""

MOST_RATE = 4.0
"""Largest rate of a cell over that of its path of slip. Where the pressure at the end of a cycle is less than a quarter
of the mean one, the rest is worn whatever the pressure becomes: as before the jump. Where P is out of phase with Q that
is a fifth of the wear or more, and `wear_error` does not count it. In three such cases errors are 0.2 to 0.75 of it at
a tolerance of 1 %; where all wear is of that kind, it is 0 and the error 0.01 %. If the change of the rest counted,
like bodies would take 128 jumps, not 9, and be off by 0.3 %, not 0.1 %. With 2, volumes were up to 3 % wrong where P is
out of phase with Q, against 0.6 % now; without a limit like bodies need nine times the increments there, for cells of
hardly any pressure."""


@dataclass(frozen=True)
class Rates:
    """Wear of one cycle, each (nx, ny).

    rate: depth per pressure at its end (mm/MPa); rest: depth (mm) that does not go with this pressure; energy:
    dissipated per depth (mJ/mm^2 per mm).
    """

    rate: DoubleArray
    rest: DoubleArray
    energy: FloatArray | float


def rates_of(law: WearLaw, friction: FrictionLimit, pressure: FloatArray, state: WearState) -> Rates:
    """Return the wear of the cycle that has just ended. pressure: at its end (MPa); friction: its limit.

    Cells that touch wear by what they have worn. Those that do not, by their way past the other surface, which goes on
    smoothly beyond the contact's edge: so wear takes part in a jump where the contact grows.
    """
    worn, touching = state.depth - state.mark, pressure > 0.0
    mean = float(pressure.sum()) / max(int(np.count_nonzero(touching)), 1)
    firm = np.maximum(pressure, LEAST_PRESSURE * mean)
    per_path = law.depth(friction.limit(firm), np.ones_like(firm), firm) / firm
    of_path = per_path * state.path
    of_pressure = np.divide(worn, pressure, out=np.zeros_like(worn), where=touching)
    rate = np.where(touching, np.minimum(of_pressure, MOST_RATE * of_path), of_path)
    rest = np.maximum(worn - rate * pressure, 0.0)
    return Rates(rate, rest, law.energy_per_depth(friction.limit(firm), firm))


def owed(rate: DoubleArray, jump_before: float, state: WearState) -> DoubleArray:
    """Return what a jump has taken too little, as a compliance (mm/MPa): the mean of the rates at its two ends less the
    rate that it took, times its cycles. rate: at its end."""
    return jump_before * (0.5 * (rate + state.rate) - state.used)


def rate_over_jump(rate: DoubleArray, jump: float, state: WearState, jump_before: float) -> DoubleArray:
    """Return the mean rate over a jump: continued to its middle by its change over the jump before it.

    rate: at its start; jump, jump_before: their cycles.
    """
    middle = rate + 0.5 * jump / jump_before * (rate - state.rate)
    return np.clip(middle, 0.5 * rate, 1.5 * rate)
