"""Least errors at holes of height maps, whose edges all grids round to their cells."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.edges import Edge
from fretsolve.model.required_terms import Model
from fretsolve.result.state import State
from fretsolve.simulation.error_bars.least_errors.moments import add_moment_of_line
from fretsolve.simulation.error_bars.quantity_estimates import (
    DELTA_X,
    DELTA_Y,
    DELTA_Z,
    MX,
    MY,
    MZ,
    QX,
    QY,
    TILTS,
    TOTAL,
    WORK,
)
from fretsolve.system.arrays import DoubleArray

HOLE_MOMENT, HOLE_TILT = 0.2, 0.35
"""Least error of Mx and My over P h, and of Mz over Q h, with the extent h of a cell across the moment's axis, where
the contact reaches a hole of a height map: all grids round it to their cells, which moves the middle of the contact.
And of tilts over (h/a) delta_z/a. Straight edges beside the middle, on 24 to 48 cells, had up to 0.19 and 0.28."""

HOLE_ENERGY = 0.3
"""Least relative error of the energies at such a hole on areas, over h/a: errors of 3 and 4 % were 0.23 and 0.27 times
that."""

HOLE_MOTION = 0.1
"""Least error of the displacements of unlike bodies at such a hole over beta p h/E*, with Dundurs' beta and the largest
pressure p, and over how far off the middle it is in contact radii, known to h/a: it moves the stick zone sideways. Of
21 holes and grooves beside the middle 18 had less, half of them less than 0.05."""


@dataclass(frozen=True)
class Holes:
    """Where a contact reaches holes of a height map.

    edge: the cells beside them, as of a sharp edge; pressure: the largest one there over that of all cells; off: how
    far they are off the middle of the contact, in cells along x and y, (2,).
    """

    edge: Edge
    pressure: float
    off: DoubleArray

    def add_to(
        self, least: DoubleArray, model: Model, summary: Summary, largest: DoubleArray, cell: tuple[float, float]
    ) -> None:
        """Add what they shift moments, tilts and displacements by to the `least` errors of `ESTIMATED`.

        largest: largest absolute values so far; cell: its sides along x and y (mm).
        """
        side = max(cell)
        if model.line:
            add_moment_of_line(least, model, summary, HOLE_MOMENT * summary.P * side, HOLE_TILT / HOLE_MOMENT)
            return
        across, moments = np.array([cell[1], cell[0]]), [MX, MY]
        least[moments] = np.hypot(least[moments], HOLE_MOMENT * summary.P * across)
        shear = float(np.hypot(largest[QX], largest[QY]))
        least[MZ] = math.hypot(least[MZ], HOLE_MOMENT * side * shear)
        energies = [WORK, TOTAL]
        least[energies] = np.hypot(least[energies], HOLE_ENERGY * side / summary.contact_radius * largest[energies])
        turn = HOLE_TILT * float(largest[DELTA_Z]) / summary.contact_radius**2
        least[TILTS] = np.hypot(least[TILTS], turn * across)
        if model.coupled:
            stretch = abs(model.compliances.dundurs_constant) * summary.max_pressure / model.compliances.contact_modulus
            place = (np.abs(self.off) * cell + side) / summary.contact_radius
            motions = [DELTA_X, DELTA_Y]
            least[motions] = np.hypot(least[motions], HOLE_MOTION * stretch * side * place)


def holes_in_contact(state: State) -> Holes | None:
    """Return the holes that the contact reaches, None where there are none."""
    from scipy.ndimage import binary_dilation  # height maps alone need it

    holes, pressure = ~np.isfinite(state.fields.gap), state.fields.pressure
    if not (holes.any() and state.summary.max_pressure):
        return None
    edge = Edge(0.0, binary_dilation(holes, np.ones((3, 3))))
    if not edge.touches(pressure):
        return None
    touches = pressure > 0.0
    middles = [np.mean(np.nonzero(cells), axis=1) for cells in (edge.near & touches, touches)]
    return Holes(edge, float(pressure[edge.near].max()) / state.summary.max_pressure, middles[0] - middles[1])
