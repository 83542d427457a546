"""What an increment starts from, and what its passes change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.rounding import least_slip
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.system.arrays import FloatArray, Vector

FIRST_TOLERANCE = 1e-2
"""Of the first pass of a coupled increment."""


@dataclass(frozen=True)
class Start:
    """What an increment starts from: tractions, tangential displacement, and rigid displacements.

    pressure: (nx, ny); shear, displacement: (2, nx, ny); rigid: delta_z, phi_x, phi_y, delta_x, delta_y, phi_z;
    normal: what was imposed of the normal problem; elastic_slip: (2, nx, ny), of the tractions that the passes begin
    with, where these are not the start's and `displacement` does not tell it well enough.
    """

    pressure: FloatArray
    shear: FloatArray
    displacement: FloatArray
    rigid: Vector
    normal: LoadControl | None = None
    elastic_slip: FloatArray | None = None

    @property
    def elastic(self) -> float:
        """Largest tangential displacement (mm)."""
        return float(np.abs(self.displacement).max())

    def least_slip(self, grid: Grid, tolerance: float) -> float:
        """Length (mm) that slips are measured against at least, as the certificate has it."""
        return least_slip(self.elastic, self.rigid, grid.farthest, tolerance)


@dataclass
class Iterate:
    """What the passes change: tractions, rigid displacements and the counts.

    at_start: the tractions still are those that the increment starts from; approach: length that the gap is measured
    against (mm); change: what the last pass's shear did to the gap, over the approach; jointly: the increment was
    solved for both together.
    """

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector
    at_start: bool = True
    approach: float = 0.0
    change: float = FIRST_TOLERANCE
    iterations_normal: int = 0
    iterations_tangential: int = 0
    alternations: int = 0
    jointly: bool = False
