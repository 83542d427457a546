"""Displacements kept up with tractions that change: what is convolved is the change.

In single precision where its rounding counts for nothing against the tolerance, since the change is small; in double
elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.interface import Apply
from fretsolve.elastic.rounding import SINGLE_ROUNDING
from fretsolve.kernels import cg
from fretsolve.system.arrays import FloatArray

SHARE = 0.3
"""Of the tolerance that the rounding of one change may take up; those that come after it are smaller."""

NOTHING = 1e-3
"""Part of the tolerance below which a displacement need not be added."""


@dataclass(frozen=True)
class Room:
    """What a change is convolved in: double (2, nx, ny), and two of single precision (2, nx, ny)."""

    double: FloatArray
    single: tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Follower:
    """Adds what changes of a traction of `given` components do to a displacement of `found` components.

    single: the elastic operator over `unit` (mm per MPa) in single precision; double: the same in mm per MPa, None
    where single precision must do. Both are applied as ``apply(traction, displacement)`` to fields (components, nx, ny)
    that may share their memory.
    """

    single: Apply
    double: Apply | None
    unit: float
    given: int
    found: int

    def follow(
        self, displacement: FloatArray, room: Room, bearable: float, sign: float = 1.0, expected: float = 0.0
    ) -> None:
        """Add `sign` times the displacement that the change of the traction in `room.double` causes.

        bearable: error (mm) that counts as much as the tolerance; expected: about how large the displacement is (mm).
        """
        change, moved = room.double[: self.given], room.double[: self.found]
        largest = cg.largest_part(change)
        factor = self.unit * largest
        if factor * max(displacement.shape) <= NOTHING * bearable:  # by less than that it moves the surfaces
            return
        limit = SHARE * bearable / SINGLE_ROUNDING
        if self.double is None or limit > expected:
            field, image = room.single[0][: self.given], room.single[1][: self.found]
            np.divide(change, largest, out=field, casting="same_kind")
            self.single(field, image)
            if self.double is None or factor * cg.largest_part(image) <= limit:
                cg.add(displacement, image, sign * factor)
                return
        self.double(change, moved)
        cg.add(displacement, moved, sign)
