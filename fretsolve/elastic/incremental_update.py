"""Incremental update of displacements: only the change of a traction is convolved.

The change is small, so its displacement is computed in single precision wherever that leaves a rounding error well
below the tolerance, and in double precision elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.interface import Apply
from fretsolve.elastic.rounding import SINGLE_ROUNDING
from fretsolve.kernels import cg
from fretsolve.system.arrays import FloatArray

SHARE = 0.3
"""Part of the tolerance that the rounding of one update may take. The updates that follow it are smaller."""

NOTHING = 1e-3
"""Part of the tolerance below which a displacement is not added."""


@dataclass(frozen=True)
class UpdateArrays:
    """Working arrays of an update: one in double precision (2, nx, ny), two in single precision (2, nx, ny)."""

    double: FloatArray
    single: tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class IncrementalUpdate:
    """Adds to a displacement what a change of a traction does.

    single: method of the elastic operator over `unit` (mm per MPa) in single precision; double: the same in mm per MPa
    and double precision, or None where single precision is all there is; tractions, displacements: numbers of
    components that the method takes and gives.
    """

    single: Apply
    double: Apply | None
    unit: float
    tractions: int
    displacements: int

    def add(
        self, displacement: FloatArray, arrays: UpdateArrays, allowed: float, sign: float = 1.0, expected: float = 0.0
    ) -> None:
        """Add `sign` times the displacement that the change of the traction in ``arrays.double`` causes.

        allowed: error (mm) that is as large as the tolerance; expected: about how large the displacement is (mm).
        """
        change, moved = arrays.double[: self.tractions], arrays.double[: self.displacements]
        largest = cg.largest_part(change)
        factor = self.unit * largest
        # The surfaces move by less than the left side.
        if factor * max(displacement.shape) <= NOTHING * allowed:
            return
        limit = SHARE * allowed / SINGLE_ROUNDING
        if self.double is None or limit > expected:
            field, image = arrays.single[0][: self.tractions], arrays.single[1][: self.displacements]
            np.divide(change, largest, out=field, casting="same_kind")
            self.single(_plane(field), _plane(image))
            if self.double is None or factor * cg.largest_part(image) <= limit:
                cg.add(displacement, image, sign * factor)
                return
        self.double(_plane(change), _plane(moved))
        cg.add(displacement, moved, sign)


def _plane(field: FloatArray) -> FloatArray:
    """Return a field of one component as a plane (nx, ny), others as they are."""
    return field[0] if len(field) == 1 else field
