"""Decide of each cell whether it is open, sticks or slips."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.rounding import circle_width, slips
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, FloatArray


def zones(
    contact: BoolArray,
    shear: FloatArray,
    slip: FloatArray,
    limit: FloatArray,
    friction: float,
    precision: type[np.floating],
) -> NDArray[np.uint8]:
    """Return the zone of each cell as `Zone`, (nx, ny).

    A cell in contact slips where its shear has reached the friction limit. If no cell has slipped, all stick; without
    friction all slip.

    contact: cells in contact, (nx, ny); shear (MPa) and slip increment (mm): (2, nx, ny); limit: `friction`, its
    coefficient, times pressure (MPa), (nx, ny); precision: of the tractions, whose rounding the limit allows for.
    """
    zone = np.full(contact.shape, Zone.OPEN, dtype=np.uint8)
    zone[contact] = Zone.STICK
    if not friction:
        zone[contact] = Zone.SLIP
    elif slip.any():
        zone[contact & slips(shear, limit, circle_width(precision))] = Zone.SLIP
    return zone
