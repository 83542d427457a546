"""The state that an increment starts from, and the state that its staggered iterations change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.friction.limit import FrictionLimit
from fretsolve.model.load_control import LoadControl
from fretsolve.system.arrays import FloatArray, Vector

FIRST_TOLERANCE = 1e-2
"""Tolerance of the first staggered iteration of a coupled increment."""


@dataclass(frozen=True)
class InitialState:
    """State at the start of an increment.

    pressure: (nx, ny); shear, displacement: tangential, (2, nx, ny); rigid: delta_z, phi_x, phi_y, delta_x, delta_y,
    phi_z; friction: its limit in the increment; normal: what was imposed on the normal problem; elastic_slip:
    (2, nx, ny), at the tractions that the staggered iterations start with, where it is not 0 and `displacement` does
    not resolve it; mismatch: (2, nx, ny), of the surfaces by bulk stress in the increment, which has been taken from
    `displacement` and `elastic_slip`.
    """

    pressure: FloatArray
    shear: FloatArray
    displacement: FloatArray
    rigid: Vector
    friction: FrictionLimit
    normal: LoadControl | None = None
    elastic_slip: FloatArray | None = None
    mismatch: FloatArray | None = None

    @cached_property
    def largest_displacement(self) -> float:
        """Largest tangential elastic displacement (mm)."""
        return float(np.maximum(self.displacement.max(), -self.displacement.min()))

    def largest_mismatch(self, pressure: FloatArray) -> float:
        """Return the largest mismatch (mm) in the contact under `pressure`."""
        if self.mismatch is None:
            return 0.0
        return float(np.max(np.abs(self.mismatch), where=pressure > 0.0, initial=0.0))


@dataclass
class WorkingState:
    """Tractions, rigid displacements and counts that change within an increment.

    slip_is_known: the elastic slip of the tractions is that of `InitialState`, 0 where this has none; gap_scale: length
    that the gap is measured against (mm); change: of the gap by the last change of the shear, over gap_scale;
    coupled_step: the increment was solved by the coupled Newton method.
    """

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector
    slip_is_known: bool = True
    gap_scale: float = 0.0
    change: float = FIRST_TOLERANCE
    iterations_normal: int = 0
    iterations_tangential: int = 0
    staggered_iterations: int = 0
    coupled_step: bool = False
