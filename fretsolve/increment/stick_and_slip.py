"""Decide of each cell whether it is open, sticks or slips.

A cell in contact slips where its shear has reached the friction limit and it moves. Under cyclic loads with a mean
value parts of a contact come to the limit in each cycle and do not move: these stick. Without friction all cells slip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray

LEFT_OVER, LARGEST_LEFT_OVER = 10.0, 1e-5
"""Slip over what the stick residual allows, and over the motion, up to which it may be the iteration's error: larger
increments before the present one leave theirs in the shear traction."""


def zones(contact: BoolArray, slipping: BoolArray) -> NDArray[np.uint8]:
    """Return the zone of each cell as `Zone`; both: cells, (nx, ny)."""
    zone = np.full(contact.shape, Zone.OPEN, dtype=np.uint8)
    zone[contact] = Zone.STICK
    zone[contact & slipping] = Zone.SLIP
    return zone


def least_slip_of_zones(tolerance: float, motion: float) -> float:
    """Return the slip increment (mm) up to which a cell has not moved.

    tolerance: of the case, the stick residual's; motion: of the increment, which that refers to (mm).
    """
    return max(tolerance, min(LEFT_OVER * tolerance, LARGEST_LEFT_OVER)) * motion
