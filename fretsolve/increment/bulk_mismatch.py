"""The mismatch of the surfaces under bulk stress, which slips or is taken up by shear as a rigid motion is."""

from __future__ import annotations

from dataclasses import replace

from fretsolve.increment.working_state import InitialState
from fretsolve.model.bulk_stress import mismatch_displacement
from fretsolve.model.grid import Grid
from fretsolve.system.arrays import Vector


def with_mismatch(start: InitialState, stretch: Vector, grid: Grid) -> InitialState:
    """Return the start of an increment in which bulk stress moves the surfaces apart.

    stretch: change of the mismatch in the increment, De_xx, De_yy, De_xy. The slip is D(rigid motion) - D(u) - D(w).
    """
    mismatch = mismatch_displacement(stretch, grid)
    return replace(start, displacement=start.displacement - mismatch, elastic_slip=-mismatch, mismatch=mismatch)
