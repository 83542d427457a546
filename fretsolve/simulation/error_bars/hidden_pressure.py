"""Pressure that cells hide: at heights that they miss, at tips and edges, and where slip meets."""

from __future__ import annotations

import math

from fretsolve.result.state import State, Summary
from fretsolve.setup.closed_forms.area_forms import spence_ratio
from fretsolve.simulation.error_bars.cells import Cells

SMOOTH_EDGE = 1.75
"""Largest part of the largest pressure in a cell beside the edge of a smooth contact, over (h/a)^(1/2): it is there
(2 s/a)^(1/2) up to 1.5 h from the edge. Where cells beside holes of a height map have more, the body ends sharply."""

PEAK = 3.0
"""Largest pressure that unresolved heights add, over the root mean square one that flattens them: sqrt(2 ln n) for n
independent Gaussian peaks in contact, here a hundred."""

SLIP_MEETS = 1.3
"""By how much slip towards a stick zone that no cell sees raises the largest pressure at most, over mu beta p (1 +
ln(h/c)) with the radius c of that zone: it was up to 1.2 times that without the logarithm."""


def hidden_pressure(cells: Cells, state: State) -> float:
    """Return how much pressure (MPa) cells may hide; infinity where a sharp tip or edge is in contact."""
    pressure, summary, modulus = state.fields.pressure, state.summary, cells.model.compliances.contact_modulus
    if not summary.max_pressure:
        return 0.0
    if cells.holes is not None:
        beside = float(pressure[cells.holes.near].max()) / summary.max_pressure
        if beside * math.sqrt(summary.contact_radius / cells.side) > SMOOTH_EDGE:
            return math.inf
    at_edges = max((edge.hidden_pressure(pressure, cells.side, modulus) for edge in cells.edges), default=0.0)
    return PEAK * cells.flattening + cells.ridges + at_edges + _where_slip_meets(cells, summary)


def _where_slip_meets(cells: Cells, summary: Summary) -> float:
    """Return by how much slip towards a stick zone that no cell sees may raise the largest pressure.

    The shear traction mu p turns round there, which between unlike bodies raises p with the logarithm of the
    distance, down to the stick zone (radius c by Spence): by mu beta p ln(h/c) within a cell, and somewhat outside.
    """
    stick = spence_ratio(cells.model) * summary.contact_radius
    if not (cells.mismatch and stick):
        return 0.0
    if cells.model.line:  # whose stick zone has two edges however it is sheared
        stick = min(stick, summary.stick_radius or stick)
    rise = 1.0 + math.log(cells.side / stick) if stick < cells.side else cells.side / stick
    return SLIP_MEETS * cells.model.friction * cells.mismatch * rise * summary.max_pressure
