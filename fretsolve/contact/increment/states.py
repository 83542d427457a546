"""The state that an increment starts from, and the state that its staggered iterations change.

Under bulk stress the mismatch of the surfaces slips, or shear takes it up, as a rigid motion. Far from the origin a
mismatch moves a contact mostly as a whole. A rigid motion follows this common part, so that residuals are measured
against what strains the contact, wherever the contact lies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.materials import mismatch_displacement
from fretsolve.result.state import Before, Fields
from fretsolve.system.arrays import FloatArray, Vector

FIRST_TOLERANCE = 1e-2
"""Tolerance of the first staggered iteration of a coupled increment."""


@dataclass(frozen=True)
class Prediction:
    """Expected changes in an increment: `growth` times the changes over the increment before it.

    Slip zones spread much as they did over the increment before. pressure, shear, displacement: as in `InitialState`;
    rigid: delta_z, phi_x, phi_y. The tangential problem finds its own motions from the shear.
    """

    pressure: FloatArray
    shear: FloatArray
    displacement: FloatArray
    rigid: Vector

    @classmethod
    def of(cls, growth: float, state: Fields, displacement: FloatArray, before: Before, moved: Vector) -> Prediction:
        """Return the prediction from the state after an increment and before it; moved: rigidly in that increment."""
        return cls(
            growth * (state.pressure - before.pressure),
            growth * (state.shear - before.shear),
            growth * (displacement - before.displacement),
            growth * moved[:3],
        )

    def part(self, cells: Any) -> Prediction:
        """Return the prediction on part of the grid."""
        return Prediction(self.pressure[cells], self.shear[cells], self.displacement[cells], self.rigid)

    def apply(self, work: WorkingState) -> None:
        """Add the prediction to `work`: elastic displacements are linear in the tractions, so no convolution is needed.

        Where the elastic slip is unknown, the pressure comes from coarser grids, and the shear alone is predicted.
        """
        work.shear += self.shear
        if work.elastic_slip is not None:
            work.pressure += self.pressure
            work.rigid[:3] += self.rigid
            work.elastic_slip = work.elastic_slip - self.displacement


@dataclass(frozen=True)
class InitialState:
    """State at the start of an increment.

    pressure: (nx, ny); shear, displacement: tangential, (2, nx, ny); rigid: delta_z, phi_x, phi_y, delta_x, delta_y,
    phi_z; friction: its limit in the increment; normal: what was imposed on the normal problem; mismatch: (2, nx, ny),
    of the surfaces by bulk stress in the increment, which has been taken from `displacement`; prediction: None where
    the staggered iterations start from the start itself.
    """

    pressure: FloatArray
    shear: FloatArray
    displacement: FloatArray
    rigid: Vector
    friction: FrictionLimit
    normal: LoadControl | None = None
    mismatch: FloatArray | None = None
    prediction: Prediction | None = None

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

    elastic_slip: since the start, at the tractions that the staggered iterations start with, (2, nx, ny), None where it
    is to be computed; gap_scale: length that the gap is measured against (mm); change: of the gap by the last change of
    the shear, over gap_scale; coupled_step: the increment was solved by the coupled Newton method.
    """

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector
    elastic_slip: FloatArray | None = None
    gap_scale: float = 0.0
    change: float = FIRST_TOLERANCE
    iterations_normal: int = 0
    iterations_tangential: int = 0
    staggered_iterations: int = 0
    coupled_step: bool = False


def with_mismatch(start: InitialState, strain_mismatch: Vector, grid: Grid, *, turns: bool = True) -> InitialState:
    """Return the start of an increment in which bulk stress moves the surfaces apart.

    strain_mismatch: its change in the increment, De_xx, De_yy, De_xy; turns: whether a rotation may follow it. The slip
    is D(rigid motion) - D(u) - D(w); the rigid part of w in the contact at the start is taken from w and has been added
    to the rigid displacements.
    """
    followed = _rigid_part(strain_mismatch, start.pressure, grid, turns)
    mismatch = mismatch_displacement(strain_mismatch, grid, followed)
    rigid = start.rigid + np.concatenate([np.zeros(3), followed])
    displacement = start.displacement - mismatch
    return replace(start, rigid=rigid, displacement=displacement, mismatch=mismatch)


def _rigid_part(strain_mismatch: Vector, pressure: FloatArray, grid: Grid, turns: bool) -> Vector:
    """Return delta_x, delta_y, phi_z that follow w at the middle of the contact and on average turn with it."""
    xx, yy, xy = strain_mismatch
    inside = [np.flatnonzero((pressure > 0.0).any(axis=1 - axis)) for axis in (0, 1)]
    if not inside[0].size:
        x, y, turn = grid.x0, grid.y0, 0.0
    else:
        # the middle of the outermost cells: exactly 0 in a mirror-symmetric contact
        x, y = (0.5 * (c[i[0]] + c[i[-1]]) for c, i in zip((grid.x, grid.y), inside, strict=True))
        half_x, half_y = (0.5 * np.ptp(c[i]) for c, i in zip((grid.x, grid.y), inside, strict=True))
        turn = turns * xy * (half_x**2 - half_y**2) / max(half_x**2 + half_y**2, grid.dx * grid.dy)
    return np.array([xx * x + xy * y + turn * y, xy * x + yy * y - turn * x, turn])
