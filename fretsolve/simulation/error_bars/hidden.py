"""What cells hide: pressure at heights, edges and where slip meets, and energy of slip annuli that they hardly see."""

from __future__ import annotations

import math

from fretsolve.problem.setup.closed_forms import spence_ratio
from fretsolve.result.state import State, Summary
from fretsolve.simulation.error_bars.cells import Cells
from fretsolve.simulation.error_bars.shear_path import ShearPath

SMOOTH_EDGE = 1.75
"""Largest part of the largest pressure in a cell beside the edge of a smooth contact, over (h/a)^(1/2): it is there
(2 s/a)^(1/2) up to 1.5 h from the edge. Where cells beside holes of a height map have more, the body ends sharply."""

PEAK = 3.0
"""Largest pressure that unresolved heights add, over the root mean square one that flattens them: sqrt(2 ln n) for n
independent Gaussian peaks in contact, here a hundred."""

SLIP_MEETS = 1.3
"""By how much slip towards a stick zone that no cell sees raises the largest pressure at most, over mu beta p (1 +
ln(h/c)) with the radius c of that zone: it was up to 1.2 times that without the logarithm."""

ANNULUS = 0.1
"""Least relative error of what an increment dissipates over (h/w)^(3/2) (h/a)^(1/2) with the width w of the slip
annulus, a cell at least: its edge may lie anywhere in the cells, which is averaged around the contact, so that line
contacts lack the second factor."""

UNSEEN = 0.21
"""Energy that slip within a cell of the edge dissipates on the way to gross slip, over (mu P)^2 S/a (h/a)^3 with the
tangential compliance S: by Mindlin 27/144 of a sphere and by Cattaneo 8/12 pi of a cylinder, per length."""


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

    The shear traction mu p turns round there, which between unlike bodies raises p with the logarithm of the distance.
    """
    stick = spence_ratio(cells.model) * summary.contact_radius
    if not (cells.mismatch and stick):
        return 0.0
    if cells.model.line:  # whose stick zone has two edges however it is sheared
        stick = min(stick, summary.stick_radius or stick)
    rise = 1.0 + math.log(cells.side / stick) if stick < cells.side else cells.side / stick
    return SLIP_MEETS * cells.model.friction * cells.mismatch * rise * summary.max_pressure


def hidden_in_annulus(cells: Cells, summary: Summary) -> float:
    """Return the least error (mJ) of what an increment dissipates by the width of its slip annulus in cells."""
    around = 1.0 if cells.model.line else math.sqrt(min(cells.side / (summary.contact_radius or cells.side), 1.0))
    return ANNULUS * _cells_share(cells, summary) * around * summary.work


def unseen_energy(cells: Cells, state: State, load: float, radius: float, path: ShearPath) -> float:
    """Return the energy (mJ) that no cell shows, up to now; load: largest P (N); radius: of the contact (mm).

    An annulus that is narrower than a cell dissipates with the third power of its width, which is a third of a sphere's
    radius, half of a cylinder's, times the part of the friction limit to which it is sheared. Pressing unlike bodies
    slips once. Roundings that fit into a cell have more.
    """
    share, ways = (1.0, max(path.length, 1.0)) if cells.mismatch else (path.largest, path.length)
    if not (radius and share):
        return 0.0
    friction, modulus = cells.model.friction, cells.model.compliances.contact_modulus
    pair, order = cells.model.compliances, 2.0 if cells.model.line else 3.0
    compliance = pair.A if cells.model.line else pair.tangential / radius  # energies of a line are per length
    annulus = UNSEEN * math.pow(min(cells.side / radius, share / order), 3) * (friction * load) ** 2 * compliance
    annulus *= _cells_share(cells, state.summary)
    edges = sum(edge.hidden_energy(state.fields.pressure, cells.side, modulus, friction) for edge in cells.edges)
    return (annulus / share + share**2 * edges) * ways


def _cells_share(cells: Cells, summary: Summary) -> float:
    """Return (h/w)^(3/2) with the width w of the slip annulus, 1 where that is less than a cell."""
    width = max(summary.contact_radius - summary.stick_radius, cells.side)
    return math.pow(cells.side / width, 1.5)
