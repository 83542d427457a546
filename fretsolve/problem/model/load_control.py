"""Load control of three rigid modes: a resultant or a displacement is imposed on each.

Vectors of three follow the orders (delta_z, phi_x, phi_y) and (delta_x, delta_y, phi_z); resultants follow the orders
(P, Mx, My) and (Qx, Qy, Mz).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.system.arrays import Vector


@dataclass(frozen=True)
class LoadControl:
    """forced: whether the resultant of each mode is imposed; values: the imposed resultants (N, N mm) or else
    displacements (mm, rad); three of each."""

    forced: tuple[bool, ...]
    values: tuple[float, ...]

    def relative_to(self, rigid: Vector) -> LoadControl:
        """Return the same with imposed displacements counted from `rigid`."""
        counted = (v if f else v - float(r) for f, v, r in zip(self.forced, self.values, rigid, strict=True))
        return LoadControl(self.forced, (*counted,))

    def with_loads_scaled(self, factor: float) -> LoadControl:
        """Return the same with imposed resultants multiplied by `factor`."""
        scaled = (factor * v if f else v for f, v in zip(self.forced, self.values, strict=True))
        return LoadControl(self.forced, (*scaled,))

    @cached_property
    def forced_index(self) -> list[int]:
        """Modes whose resultant is imposed."""
        return [mode for mode, forced in enumerate(self.forced) if forced]

    @cached_property
    def imposed_displacement(self) -> Vector:
        """The imposed displacements, 0 where the resultant is imposed; read-only."""
        return _read_only([0.0 if forced else value for forced, value in zip(self.forced, self.values, strict=True)])

    @cached_property
    def imposed_resultant(self) -> Vector:
        """The imposed resultants, 0 where the displacement is imposed; read-only."""
        return _read_only([value if forced else 0.0 for forced, value in zip(self.forced, self.values, strict=True)])


def _read_only(values: list[float]) -> Vector:
    vector: Vector = np.array(values, np.float64)
    vector.flags.writeable = False
    return vector
