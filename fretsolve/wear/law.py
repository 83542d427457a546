"""The law of wear: the depth that is worn off from the energy dissipated, or from pressure and the path of slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fretsolve.system.arrays import FloatArray


@dataclass(frozen=True)
class WearLaw:
    """Wear by dissipated energy, dw = alpha q ds (Fouvry), or by pressure and slip, dw = k p^m ds (Archard).

    alpha: worn volume per energy, in mm^3/mJ, which is mm^3/(N mm); k: worn volume per force and path, in mm^3/(N mm),
    with m = 1, else in mm^3/(N mm) times MPa^(1 - m); exponent: m; share: of the worn depth in body 1 and body 2, which
    add up to 1.
    """

    law: Literal["energy", "archard"]
    alpha: float = 0.0
    k: float = 0.0
    exponent: float = 1.0
    share: tuple[float, float] = (0.5, 0.5)

    def depth(self, energy: FloatArray, path: FloatArray, pressure: FloatArray) -> FloatArray:
        """Return the depth (mm) that slip wears off both bodies together, of the arrays' shape.

        energy: dissipated per area (mJ/mm^2); path: length of the slip (mm); pressure: its mean on this path (MPa).
        """
        if self.law == "energy":
            return np.asarray(self.alpha * energy)
        return np.asarray(self.k * pressure**self.exponent * path)

    def of_bodies(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the worn depths (mm) of body 1 and body 2 from that of both together."""
        return self.share[0] * depth, self.share[1] * depth
