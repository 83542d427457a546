"""Least errors of the dissipated energy: slip in annuli that cells see in part, and slip that no cell shows."""

from __future__ import annotations

import math

from fretsolve.result.state import State, Summary
from fretsolve.simulation.error_bars.cells import Cells
from fretsolve.simulation.error_bars.shear_path import ShearPath

ANNULUS = 0.3
"""Least relative error of what an increment dissipates over (h/w)^(3/2) (h/a)^(1/2) with the width w of the slip
annulus, a cell at least: its edge may lie anywhere in the cells, which is averaged around the contact, so that line
contacts lack the second factor."""

UNSEEN = 0.45
"""Energy that slip within a cell of the edge dissipates on the way to gross slip, over (mu P)^2/(E* a) (h/a)^3: by
Mindlin 0.46 of a sphere and by Cattaneo 0.42 of a cylinder, per length, whose annulus is a cell wide."""


def hidden_in_annulus(cells: Cells, summary: Summary) -> float:
    """Return the least error (mJ) of what an increment dissipates by the width of its slip annulus in cells."""
    around = 1.0 if cells.model.line else math.sqrt(min(cells.side / (summary.contact_radius or cells.side), 1.0))
    return ANNULUS * _cells_share(cells, summary) * around * summary.work


def unseen_energy(cells: Cells, state: State, load: float, radius: float, path: ShearPath) -> float:
    """Return the energy (mJ) that no cell shows, up to now; load: largest P (N); radius: of the contact (mm).

    An annulus that is narrower than a cell dissipates with the third power of its width, which is a third of a sphere's
    radius times the part of the friction limit to which it is sheared. Pressing unlike bodies slips once. Roundings
    that fit into a cell have more.
    """
    share, ways = (1.0, max(path.length, 1.0)) if cells.mismatch else (path.largest, path.length)
    if not (radius and share):
        return 0.0
    friction, modulus = cells.model.friction, cells.model.compliances.contact_modulus
    length = 1.0 if cells.model.line else radius  # energies of a line contact are per length
    annulus = UNSEEN * math.pow(min(cells.side / radius, share / 3.0), 3) * (friction * load) ** 2 / (modulus * length)
    annulus *= _cells_share(cells, state.summary)
    edges = sum(edge.hidden_energy(state.fields.pressure, cells.side, modulus, friction) for edge in cells.edges)
    return (annulus / share + share**2 * edges) * ways


def _cells_share(cells: Cells, summary: Summary) -> float:
    """Return (h/w)^(3/2) with the width w of the slip annulus, 1 where that is less than a cell."""
    width = max(summary.contact_radius - summary.stick_radius, cells.side)
    return math.pow(cells.side / width, 1.5)
