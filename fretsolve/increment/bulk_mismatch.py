"""The mismatch of the surfaces under bulk stress, which slips or is taken up by shear as a rigid motion is.

Far from the origin a mismatch moves a contact mostly as a whole. A rigid motion follows that part, so that residuals
are measured against what stretches the contact, wherever it lies.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretsolve.increment.working_state import InitialState
from fretsolve.model.grid import Grid
from fretsolve.model.materials import mismatch_displacement
from fretsolve.system.arrays import FloatArray, Vector


def with_mismatch(start: InitialState, stretch: Vector, grid: Grid, *, turns: bool = True) -> InitialState:
    """Return the start of an increment in which bulk stress moves the surfaces apart.

    stretch: change of the mismatch in the increment, De_xx, De_yy, De_xy; turns: whether a rotation may follow it. The
    slip is D(rigid motion) - D(u) - D(w); the rigid part of w in the contact at the start is taken from w and has been
    added to the rigid displacements.
    """
    followed = _rigid_part(stretch, start.pressure, grid, turns)
    mismatch = mismatch_displacement(stretch, grid, followed)
    rigid = start.rigid + np.concatenate([np.zeros(3), followed])
    displacement = start.displacement - mismatch
    return replace(start, rigid=rigid, displacement=displacement, elastic_slip=-mismatch, mismatch=mismatch)


def _rigid_part(stretch: Vector, pressure: FloatArray, grid: Grid, turns: bool) -> Vector:
    """Return delta_x, delta_y, phi_z that follow w at the middle of the contact and on average turn with it."""
    xx, yy, xy = stretch
    inside = [np.flatnonzero((pressure > 0.0).any(axis=1 - axis)) for axis in (0, 1)]
    if not inside[0].size:
        x, y, turn = grid.x0, grid.y0, 0.0
    else:
        # the middle of the outermost cells: exactly 0 in a mirror-symmetric contact
        x, y = (0.5 * (c[i[0]] + c[i[-1]]) for c, i in zip((grid.x, grid.y), inside, strict=True))
        half_x, half_y = (0.5 * np.ptp(c[i]) for c, i in zip((grid.x, grid.y), inside, strict=True))
        turn = turns * xy * (half_x**2 - half_y**2) / max(half_x**2 + half_y**2, grid.dx * grid.dy)
    return np.array([xx * x + xy * y + turn * y, xy * x + yy * y - turn * x, turn])
