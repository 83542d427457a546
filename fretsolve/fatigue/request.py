"""Say which fatigue parameters to compute."""

from __future__ import annotations

from dataclasses import dataclass

from fretsolve.fatigue.averaging import Average
from fretsolve.fatigue.material_file import MaterialSource
from fretsolve.stress.halfspace.influence import Body
from fretsolve.stress.request import WindowChoice

SMALLER = "fewer depths or bodies, or more room, is needed"
"""What makes the stresses of a cycle smaller, or lets them be as large as they are."""

AVERAGE_DEPTHS = 17
"""Depths that are computed for an average, graded towards the surface, where stresses change most."""


@dataclass(frozen=True)
class FatigueRequest:
    """Fatigue parameters to compute.

    criteria: their names; average: of the stresses, None for none. bodies: none for those in a file of stresses, or for
    body 2 of a result, or 1 if that is rigid; depths (mm): none for graded ones. window: the
    cells of a result, as in `stress_request`.
    """

    material: MaterialSource
    criteria: tuple[str, ...]
    average: Average | None = None
    bodies: tuple[Body, ...] = ()
    depths: tuple[float, ...] = ()
    window: WindowChoice = "auto"

    def stress_depths(self, least: float) -> tuple[float, ...]:
        """Return the depths at which stresses are computed; least: that of the first one below the surface (mm)."""
        if self.average is None:
            return self.depths
        first, last = self.average.depth_range
        if first == last:
            return (last,)
        graded = (last * (k / (AVERAGE_DEPTHS - 1)) ** 2 for k in range(AVERAGE_DEPTHS))
        return tuple(depth for depth in graded if depth in (first, last) or depth >= least)
