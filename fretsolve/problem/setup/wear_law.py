"""The law of wear, and the wear of one cycle by it, which jumps over many cycles multiply.

The depth that is worn off follows from the energy dissipated, or from pressure and the path of slip. A cycle's wear is
a rate times the pressure at its end, and a rest that does not go with this pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fretsolve.case.keys.wear_spec import WearSpec
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.result.state import WearState
from fretsolve.system.arrays import DoubleArray, FloatArray

LEAST_PRESSURE = 0.1
"""Smallest pressure, over the mean one in contact, in a law of wear that depends on it: cells that do not touch yet
would have no rate, or one without limit. Half or twice this pressure changes volumes by less than 0.1 %."""

MOST_RATE = 4.0
"""Largest rate of a cell over the rate of its path of slip. Where the pressure at the end of a cycle is less than a
quarter of the mean one, the rest is worn whatever the pressure becomes. With 2, volumes were up to 3 % wrong where P is
out of phase with Q, against 0.6 % now; without a limit similar bodies need nine times the increments there."""


@dataclass(frozen=True)
class WearLaw:
    """Wear by energy, dw = alpha q ds (Fouvry), or by pressure and slip, dw = k p (p/p0)^(m - 1) ds (Archard).

    alpha: worn volume per energy, in mm^3/mJ, which is mm^3/(N mm); k: worn volume per force and path, in mm^3/(N mm);
    exponent: m; reference_pressure: p0 (MPa); share: of the worn depth in body 1 and body 2, which add up to 1.
    """

    law: Literal["energy", "archard"]
    alpha: float = 0.0
    k: float = 0.0
    exponent: float = 1.0
    reference_pressure: float = 1.0
    share: tuple[float, float] = (0.5, 0.5)

    def depth(self, energy: FloatArray, path: FloatArray, pressure: FloatArray) -> FloatArray:
        """Return the depth (mm) that slip wears off both bodies together, of the arrays' shape.

        energy: dissipated per area (mJ/mm^2); path: length of the slip (mm); pressure: its mean on this path (MPa).
        """
        if self.law == "energy":
            return np.asarray(self.alpha * energy)
        return np.asarray(self._per_path(pressure) * path)

    def energy_per_depth(self, limit: FloatArray, pressure: FloatArray) -> FloatArray | float:
        """Return the energy dissipated per area and worn depth, in mJ/mm^2 per mm.

        limit: of friction (MPa) under `pressure` > 0 (MPa).
        """
        return 1.0 / self.alpha if self.law == "energy" else limit / self._per_path(pressure)

    def _per_path(self, pressure: FloatArray) -> FloatArray:
        """Return the depth per path of slip under `pressure` (MPa)."""
        if self.exponent == 1.0:
            return np.asarray(self.k * pressure)
        reference = self.reference_pressure
        return np.asarray(self.k * reference * (np.maximum(pressure, 0.0) / reference) ** self.exponent)

    def of_bodies(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the worn depths (mm) of body 1 and body 2 from the worn depth of both together."""
        return self.share[0] * depth, self.share[1] * depth


def wear_law(spec: WearSpec) -> WearLaw:
    """Return the law of wear of a case."""
    return WearLaw(
        spec.law, spec.alpha or 0.0, spec.k or 0.0, spec.exponent or 1.0, spec.reference_pressure or 1.0, spec.share
    )


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
