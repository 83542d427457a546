"""Arrays that the normal and the tangential solver of one grid share.

The two never work at the same time, and keep nothing in these arrays between two solves. Sharing them saves 28 bytes
per cell.
"""

from __future__ import annotations

import numpy as np


class Workspace:
    """Arrays (c, nx, ny) with as many components as the solver with most of them has.

    double: in double precision, the gap or slip of a solver, or the change of a traction. The others are those of
    conjugate gradients, in their precision `dtype`: solution, residual, direction, image, weight (nx, ny), and the
    displacements by the solution (displacement) and by the direction (moved).
    """

    def __init__(self, components: int, shape: tuple[int, int], dtype: type[np.floating]):
        vector = (components, *shape)
        self.double = np.zeros(vector)
        self.solution, self.residual, self.direction, self.image = (np.zeros(vector, dtype) for _ in range(4))
        # the last two take no memory of their own: while conjugate gradients run, `double` is free
        halves = self.double.reshape(-1).view(dtype).reshape(-1, *vector)
        self.displacement, self.moved = halves[0], halves[-1]
        self.weight = np.zeros(shape, dtype)
