"""Constants of the error bars of each quantity."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from fretsolve.case.history import EXTENTS, TANGENTIAL
from fretsolve.model.required_terms import Model
from fretsolve.result.state import ESTIMATED
from fretsolve.system.arrays import DoubleArray

WIDTH = 0.88
"""Factor on the sum of all parts of a bar on areas. Each part holds nearly all errors of its own kind, and several are
seldom that large at once. In line contacts, where nothing averages around an edge, they are so more often, and the
factor is 1."""

ALL = 1.2
"""Cap on the least relative errors of energies: where nothing is known of them, all and room for WIDTH."""


@dataclass(frozen=True)
class QuantityEstimate:
    """The constants of a quantity.

    order, smooth_order: with which its discretisation error falls, where a body ends and where none does; sequences of
    grids show 1.3 to 2, but fluctuate with the place of the edges in their cells. shown, smooth_shown: factor on the
    errors that two grids show, there and there. safety: factor on the first-order error of the increments in the value
    as run. linked: least error of the increments over the relative one in the dissipated energy: few increments may
    agree by chance in what slip adds up to, as in a shear after a torsion in one increment, and not in the energy,
    whose parts are all positive. floor: least error over the largest value so far, on cells as long as the contact
    radius.
    """

    order: float = 1.0
    smooth_order: float = 1.6
    shown: float = 0.7
    smooth_shown: float = 1.0
    safety: float = 2.4
    linked: float = 0.0
    floor: float = 0.07


# Their edges, where the pressure falls smoothly, are found to a small part of a cell, on all grids.
BY_LOAD = QuantityEstimate(order=1.2, floor=0.08, smooth_order=2.0, smooth_shown=1.0)
# Their change by the increments on the coarse grid is mostly that of the edge within the cells. What grids show of them
# counts in full also between like bodies.
END_OF_ZONE = QuantityEstimate(order=0.9, smooth_order=0.9, shown=1.0, smooth_shown=1.25, safety=2.0)
ENERGY = QuantityEstimate(order=0.75, smooth_order=1.3, smooth_shown=1.4, safety=1.9)
SHEARED = QuantityEstimate(order=0.85, linked=0.3)
DIFFERENT = {
    **dict.fromkeys(("P", "delta_z"), BY_LOAD),
    "contact_radius": QuantityEstimate(smooth_order=2.0, smooth_shown=0.75),
    "stick_radius": QuantityEstimate(shown=0.75, smooth_shown=0.75, safety=1.0, linked=0.22),
    "max_pressure": replace(BY_LOAD, floor=0.22),
    **dict.fromkeys(EXTENTS, END_OF_ZONE),
    **dict.fromkeys(("phi_x", "phi_y"), QuantityEstimate(smooth_shown=0.7)),
    **dict.fromkeys(("work", "work_total"), ENERGY),
    **dict.fromkeys(TANGENTIAL, SHEARED),
    # Of torsions on 24 to 40 points three of four errors were below 0.4 times (h/a)^2, and the coarse runs hid some.
    "phi_z": replace(SHEARED, floor=0.4),
}


def width(model: Model) -> float:
    """Return the factor on the sum of all parts of a bar."""
    return 1.0 if model.line else WIDTH


def room(model: Model) -> float:
    """Return by how much larger a part that is known exactly, or bounds an error, is taken, so that a bar holds it."""
    return 1.0 / width(model)


def _columns(estimates: list[QuantityEstimate]) -> list[DoubleArray]:
    return [np.array([getattr(one, field.name) for one in estimates]) for field in fields(QuantityEstimate)]


ORDER, SMOOTH_ORDER, SHOWN, SMOOTH_SHOWN, SAFETY, LINKED, FLOOR = _columns(
    [DIFFERENT.get(name, QuantityEstimate()) for name in ESTIMATED]
)
"""The constants by quantity, in the order of `ESTIMATED`."""

CONTACT, STICK, PRESSURE, WORK, TOTAL = map(
    ESTIMATED.index, ("contact_radius", "stick_radius", "max_pressure", "work", "work_total")
)
LOAD, MX, MY, MZ, QX, QY, DELTA_X, DELTA_Y, DELTA_Z = map(
    ESTIMATED.index, ("P", "Mx", "My", "Mz", "Qx", "Qy", "delta_x", "delta_y", "delta_z")
)
"""Places in that order."""

PRESSED = np.array([ESTIMATED.index(name) for name in ("P", "delta_z", "contact_radius", "max_pressure")])
"""Places of what the pressure gives."""

CONTACT_EXTENTS, STICK_EXTENTS = (
    np.array([place for place, name in enumerate(ESTIMATED) if name in EXTENTS and name.startswith(zone)])
    for zone in ("contact", "stick")
)
"""Places of half-widths and middles of the zones."""

WIDTHS_ALONG_X = np.array([ESTIMATED.index(f"{zone}_half_width_x") for zone in ("contact", "stick")])
"""Places of the half-widths along x."""

SHEAR_LOADS = np.array([QX, QY, MZ])
"""Places of the tangential loads."""

BY_AREA = np.array([LOAD, QX, QY, DELTA_X, DELTA_Y, DELTA_Z])
"""Places of the forces and displacements: on a larger area displacements take more force, and loads less
displacement."""

PHI_X, PHI_Y, PHI_Z = map(ESTIMATED.index, ("phi_x", "phi_y", "phi_z"))
"""Places of the turns about x, y and z."""

TILTS = np.array([PHI_X, PHI_Y])
"""Places of the tilts."""

TURNS = np.array([*TILTS, PHI_Z])
"""Places of all turns."""
