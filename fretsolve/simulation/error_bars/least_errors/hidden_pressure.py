"""By how much the largest pressure may exceed that of the cells: at heights that they miss, at ridges, at tips, edges
and holes, and where slip meets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.edges import Edge
from fretsolve.model.required_terms import Model
from fretsolve.result.state import State
from fretsolve.setup.closed_forms import spence_ratio
from fretsolve.system.arrays import FloatArray

SMOOTH_EDGE = 1.75
"""Largest part of the largest pressure in a cell beside the edge of a smooth contact, over (h/a)^(1/2): it is there
(2 s/a)^(1/2) up to 1.5 h from the edge. Where cells beside holes of a height map have more, the body ends sharply."""

PEAK = 3.0
"""Largest pressure that unresolved heights add, over the root mean square one that flattens them: sqrt(2 ln n) for n
independent Gaussian peaks in contact, here a hundred. A sine has 1.4, which partial contact does not exceed, and two
sines across each other have 2."""

BETWEEN_CELLS, IN_CELLS = 1.0 / 22.0, 1.0 / 22.0
"""Least error of the largest pressure on a height map over its second differences there, along x and y. A parabola is
higher by 1/24 of them than the cell nearest to its top, on average, and the mean of a wave over a cell misses its
middle by as much."""

SLIP_MEETS = 1.45
"""By how much slip towards a stick zone that no cell sees raises the largest pressure at most, over mu beta p (1 +
ln(h/c)) with the radius c of that zone. Compared with fine grids it was up to 1.2 times that without the logarithm."""

KINK, KINK_LINE = 0.02, 0.01
"""Least error of the largest pressure over E* h/r, where cells show a rounding of radius r: the curvature jumps where
it begins, so that the pressure is steepest there, and beyond lies its peak. Punches and rings with 2 to 3 cells in
contact there had up to 0.03 (seeds 45 to 59), and punches in line contact with 3 to 13 cells mostly less than 0.01.
What coarse runs show comes on top."""


@dataclass(frozen=True)
class HiddenPressure:
    """The part of the largest pressure that the cells of a problem hide.

    side: the longer side of a cell (mm); flattening: pressure (MPa) that would flatten what they do not see of height
    maps; ridges: pressure (MPa) of the ridges of maps beyond that of cells; maps: whether there are height maps; edges:
    tips and edges, where pressures are largest.
    """

    model: Model
    side: float
    flattening: float
    ridges: float
    maps: bool
    edges: tuple[Edge, ...]

    def of(self, state: State, holes: float) -> float:
        """Return by how much the largest pressure may exceed that of the cells, by heights, ridges, edges and slip.

        Infinity where a sharp tip or edge is in contact. holes: largest pressure beside holes of a height map, over
        that of all cells.
        """
        if holes * math.sqrt(state.summary.contact_radius / self.side) > SMOOTH_EDGE:
            return math.inf
        pressure = state.fields.pressure
        at_edges = max((self._at_edge(edge, pressure) for edge in self.edges), default=0.0)
        beside = (BETWEEN_CELLS + IN_CELLS) * _drop_beside_peak(pressure) if self.maps else 0.0
        return PEAK * self.flattening + self.ridges + at_edges + beside + self._where_slip_meets(state.summary)

    def _at_edge(self, edge: Edge, pressure: FloatArray) -> float:
        """Return by how much the largest pressure at an edge may exceed that of the cells."""
        modulus = self.model.compliances.contact_modulus
        hidden = edge.hidden_pressure(pressure, self.side, modulus)
        if not (edge.radius and edge.touches(pressure)):
            return hidden
        return max(hidden, (KINK_LINE if self.model.line else KINK) * modulus * self.side / edge.radius)

    def _where_slip_meets(self, summary: Summary) -> float:
        """Return by how much slip towards a stick zone that no cell sees may raise the largest pressure.

        The shear traction mu p turns round there, which between unlike bodies raises p with the logarithm of the
        distance, down to the stick zone (radius c by Spence): by mu beta p ln(h/c) within a cell, and somewhat outside.
        """
        stick = spence_ratio(self.model) * summary.contact_radius
        if not self.model.coupled or not stick:
            return 0.0
        if self.model.line:  # whose stick zone has two edges however it is sheared
            stick = min(stick, summary.stick_radius or stick)
        rise = 1.0 + math.log(self.side / stick) if stick < self.side else self.side / stick
        mismatch = abs(self.model.compliances.dundurs_constant)
        return SLIP_MEETS * self.model.friction * mismatch * rise * summary.max_pressure


def _drop_beside_peak(pressure: FloatArray) -> float:
    """Return the second differences of a pressure (nx, ny) at its largest value, along x and y, without their signs.

    Along the axis of a line contact, which has one cell, there is none.
    """
    row, column = np.unravel_index(pressure.argmax(), pressure.shape)
    drop = 0.0
    for values, place in ((pressure[:, column], int(row)), (pressure[row], int(column))):
        if len(values) > 1:
            before, most, after = np.pad(values, 1)[place : place + 3].tolist()  # nothing presses beyond the grid
            drop += 2.0 * most - before - after
    return drop
