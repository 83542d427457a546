"""Incremental update of displacements: only the change of a traction is convolved.

The change is small, so its displacement is computed in single precision wherever that leaves a rounding error well
below the tolerance, and in double precision elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import SINGLE_ROUNDING
from fretsolve.elastic.workspace import Workspace
from fretsolve.system.arrays import FloatArray

SHARE = 0.3
"""Part of the tolerance that the rounding of one update may take. The updates that follow it are smaller."""

NOTHING = 1e-3
"""Part of the tolerance below which a displacement is not added."""


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
    cg = operator.kernels.cg
    field, image = workspace.direction[: len(change)], workspace.image[: len(displacement)]
    largest = cg.normalise(change, field)
    factor = operator.unit * largest
    # The surfaces move by less than the left side.
    if factor * max(displacement.shape) <= NOTHING * allowed:
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
