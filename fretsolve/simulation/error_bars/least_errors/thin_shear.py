"""Least errors of tangential values where shear slips in an annulus that is thin against the cells.

Where next to nothing slips, the shear traction rises like that of a flat punch towards the edge of the contact, and
cells place that edge to a part of one. Grids show it by their differences, or hide it by chance.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.simulation.error_bars.least_errors.unseen_slip import UnseenSlip
from fretsolve.simulation.error_bars.quantity_estimates import DELTA_X, DELTA_Y, MZ, PHI_Z, QX, QY
from fretsolve.simulation.error_bars.shear_path import ShearPath
from fretsolve.system.arrays import DoubleArray

SHEARED, TURNED, THIN, ORDER = 0.13, 0.4, 0.5, 1.5
"""Least relative error of forces and displacements, and of torques and turns, over h/a in an annulus of no width. At
the width w it is less by 1 + (w/THIN h)^ORDER. Of 260 spheres each, in a first shear and turn on 24 to 64 points with w
of nothing to 8 h, three and two had more than that, 1.4 times at most."""


def add_thin_shear(
    least: DoubleArray, unseen: UnseenSlip, summary: Summary, largest: DoubleArray, path: ShearPath
) -> None:
    """Add what cells miss of tangential values of round bodies by the edge of a singular shear.

    largest: largest absolute values so far.
    """
    model, side = unseen.model, unseen.side
    radius, slipping = summary.contact_radius, path.memory.slipping
    if model.line or not (radius and slipping and path.largest):  # the displacements of a line have a free constant
        return
    width = (1.0 - unseen.stick_share(slipping)) * radius
    if model.coupled:  # pressing has slipped, too
        width = max(width, radius - summary.stick_radius)
    # The way since the last turn is at most twice the part that slips.
    way = min(2.0 * slipping / path.largest, 1.0)
    relative = way * side / radius / (1.0 + (width / (THIN * side)) ** ORDER)
    for part, places in ((SHEARED, [QX, QY]), (SHEARED, [DELTA_X, DELTA_Y]), (TURNED, [MZ]), (TURNED, [PHI_Z])):
        size = math.hypot(*largest[places])
        least[places] = np.hypot(least[places], part * relative * size)
