"""Load control of three rigid modes: a resultant or a displacement is imposed on each.

Vectors of three follow the orders (delta_z, phi_x, phi_y) and (delta_x, delta_y, phi_z), and those of the resultants
(P, Mx, My) and (Qx, Qy, Mz).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.system.arrays import Vector


@dataclass(frozen=True)
class LoadControl:
    """forced: whether the resultant of each mode is imposed; values: the imposed resultants (N, N mm) or else
    displacements (mm, rad)."""

    forced: tuple[bool, bool, bool]
    values: tuple[float, float, float]

    def relative_to(self, rigid: Vector) -> LoadControl:
        """Return the same with imposed displacements counted from `rigid`."""
        x, y, z = (v if f else v - float(r) for f, v, r in zip(self.forced, self.values, rigid, strict=True))
        return LoadControl(self.forced, (x, y, z))

    def with_loads_scaled(self, factor: float) -> LoadControl:
        """Return the same with imposed resultants multiplied by `factor`."""
        x, y, z = (factor * v if f else v for f, v in zip(self.forced, self.values, strict=True))
        return LoadControl(self.forced, (x, y, z))

    @property
    def forced_index(self) -> list[int]:
        """Modes whose resultant is imposed."""
        return [mode for mode in range(3) if self.forced[mode]]

    @property
    def imposed_displacement(self) -> Vector:
        """The imposed displacements, 0 where the resultant is imposed."""
        return np.array([0.0 if f else v for f, v in zip(self.forced, self.values, strict=True)])

    @property
    def imposed_resultant(self) -> Vector:
        """The imposed resultants, 0 where the displacement is imposed."""
        return np.array([v if f else 0.0 for f, v in zip(self.forced, self.values, strict=True)])
