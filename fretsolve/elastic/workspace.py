"""Arrays that the solvers of one grid share.

The normal solver, the tangential solver and the coupled Newton method of a grid never work at the same time, and none
of them keeps anything in these arrays between two solves. Sharing them saves 28 bytes per cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.system.arrays import FloatArray


@dataclass(frozen=True)
class Workspace:
    """double: (c, nx, ny) in double precision, the gap or slip of a solver, or the change of a traction. The others are
    those of conjugate gradients, in their precision: solution, residual, direction, image: (c, nx, ny); weight:
    (nx, ny)."""

    double: FloatArray
    solution: FloatArray
    residual: FloatArray
    direction: FloatArray
    image: FloatArray
    weight: FloatArray

    @classmethod
    def zeros(cls, components: int, shape: tuple[int, int], dtype: type[np.floating]) -> Workspace:
        """Return new arrays; dtype: of the conjugate gradients."""
        vector = (components, *shape)
        s, r, d, i = (np.zeros(vector, dtype) for _ in range(4))
        return cls(np.zeros(vector), s, r, d, i, np.zeros(shape, dtype))

    def first_component(self) -> Workspace:
        """Return the first component of the same arrays."""
        return Workspace(
            self.double[:1], self.solution[:1], self.residual[:1], self.direction[:1], self.image[:1], self.weight
        )
