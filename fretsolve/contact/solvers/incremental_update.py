"""Incremental update of displacements: only the change of a traction is convolved. Arrays of the solvers that do it.

The change is small, so its displacement is computed in single precision wherever that leaves a rounding error well
below the tolerance, and in double precision elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fretsolve.contact.kernels import kernels_of
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import SINGLE_ROUNDING
from fretsolve.system.arrays import FloatArray

SHARE = 0.3
"""Part of the tolerance that the rounding of one update may take. The updates that follow it are smaller."""

NOTHING = 0.05
"""Part of the tolerance below which a displacement is not added. Its bound is several times as large as itself. On
64 x 64 points mode I.3 takes 3 % fewer applications than with 1e-3, and hardly fewer still with more."""


class Workspace:
    """Arrays (c, nx, ny) that the normal and the tangential solver of one grid share; c: of the solver with most.

    The two never work at the same time, and keep nothing in these arrays between two solves. Sharing them saves 28
    bytes per cell.

    double: in double precision, the gap or slip of a solver, or the change of a traction. The others belong to
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


def add_displacement(
    operator: ElasticOperator,
    method: Callable[[ElasticOperator, FloatArray, FloatArray], None],
    displacement: FloatArray,
    change: FloatArray,
    workspace: Workspace,
    allowed: float,
    sign: float = 1.0,
    expected: float = 0.0,
) -> None:
    """Add `sign` times the displacement that a change of a traction causes.

    method: of the operator, from the traction to the displacement, as `ElasticOperator.normal`; displacement (mm),
    change (MPa): (1, nx, ny) or (2, nx, ny); `change` may be in ``workspace.double``, whose contents are lost; allowed:
    error (mm) that is as large as the tolerance; expected: about how large the displacement is (mm).
    """
    cg = kernels_of(operator).cg
    field, image = workspace.direction[: len(change)], workspace.image[: len(displacement)]
    largest, cells = cg.normalise(change, field)
    factor = operator.unit * largest
    # The surfaces move by less than the left side, which is about what so many cells do that lie in a disk and have the
    # largest change. Strips of a line contact reach farther.
    reach = cells if displacement.shape[-1] == 1 else math.sqrt(cells)
    if factor * reach <= NOTHING * allowed:
        return
    limit = SHARE * allowed / SINGLE_ROUNDING
    only_single = operator.dtype is np.float32
    if only_single or limit > expected:
        method(operator.inner, field, image)
        if only_single or factor * cg.largest(image) <= limit:
            cg.add(displacement, image, sign * factor)
            return
    moved = workspace.double[: len(displacement)]
    method(operator, change, moved)
    cg.add(displacement, moved, sign)


def add_correction(
    operator: ElasticOperator,
    correction: tuple[FloatArray, FloatArray],
    size: float,
    traction: FloatArray,
    before: FloatArray,
    displacement: FloatArray,
    allowed: float,
    sign: float = 1.0,
) -> bool:
    """Add a correction to a traction, and `sign` times its displacement where that is known well enough.

    correction: the solution of conjugate gradients, over ``size / operator.unit``, and `operator.inner` of the
    solution, the sum of what they have computed anyhow. Return whether its rounding is small enough. traction,
    displacement: changed in place; before: receives the traction that `displacement` then belongs to, and may hold the
    correction's displacement; allowed: error (mm) that is as large as the tolerance.

    What the friction limit, tension and the loads take from the correction is left to `add_displacement`, and is often
    nothing. Mode I.3 takes 5 to 8 % fewer applications.
    """
    solution, moved = correction
    cg = kernels_of(operator).cg
    known = operator.dtype is np.float32 or size * cg.largest(moved) <= SHARE * allowed / SINGLE_ROUNDING
    if known:
        cg.add(displacement, moved, sign * size)
    else:
        np.copyto(before, traction)
    cg.add(traction, solution, size / operator.unit)
    if known:
        np.copyto(before, traction)
    return bool(known)
