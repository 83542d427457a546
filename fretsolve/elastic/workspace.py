"""Arrays that the normal and the tangential solver of one grid share.

The two never work at the same time, and keep nothing in these arrays between two solves. Sharing them saves 28 bytes
per cell.
"""

from __future__ import annotations

import numpy as np


class Workspace:
    """Arrays (c, nx, ny) with as many components as the solver with most of them has.

    double: in double precision, the gap or slip of a solver, or the change of a traction. The others are those of
    conjugate gradients, in their precision `dtype`: solution, residual, direction, image, and weight (nx, ny).
    """

    def __init__(self, components: int, shape: tuple[int, int], dtype: type[np.floating]):
        vector = (components, *shape)
        self.double = np.zeros(vector)
        self.solution, self.residual, self.direction, self.image = (np.zeros(vector, dtype) for _ in range(4))
        self.weight = np.zeros(shape, dtype)
