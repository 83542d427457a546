"""The law of wear: the depth that is worn off from the energy dissipated, or from pressure and the path of slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fretsolve.case.keys.wear_spec import WearSpec
from fretsolve.system.arrays import FloatArray


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

    def energy_per_depth(self, bound: FloatArray, pressure: FloatArray) -> FloatArray | float:
        """Return the energy dissipated per area and worn depth, in mJ/mm^2 per mm.

        bound: friction limit (MPa) under `pressure` > 0 (MPa).
        """
        return 1.0 / self.alpha if self.law == "energy" else bound / self._per_path(pressure)

    def _per_path(self, pressure: FloatArray) -> FloatArray:
        """Return the depth per path of slip under `pressure` (MPa)."""
        if self.exponent == 1.0:
            return np.asarray(self.k * pressure)
        reference = self.reference_pressure
        return np.asarray(self.k * reference * (np.maximum(pressure, 0.0) / reference) ** self.exponent)

    def of_bodies(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the worn depths (mm) of body 1 and body 2 from that of both together."""
        return self.share[0] * depth, self.share[1] * depth


def wear_law(spec: WearSpec) -> WearLaw:
    """Return the law of wear of a case."""
    return WearLaw(
        spec.law, spec.alpha or 0.0, spec.k or 0.0, spec.exponent or 1.0, spec.reference_pressure or 1.0, spec.share
    )
