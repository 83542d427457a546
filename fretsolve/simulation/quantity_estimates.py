"""Constants of the error bars of each quantity."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from fretsolve.case.history import EXTENTS, TANGENTIAL
from fretsolve.result.state import ESTIMATED
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True)
class QuantityEstimate:
    """The constants of a quantity.

    order: with which its discretisation error falls; sequences of grids show 1.3 to 2, but fluctuate with the place of
    the edges in their cells. between: part of the difference between the two coarse grids that counts as an error of
    the run. safety: factor on the first-order error of the increments in the value as run. linked: least error of the
    increments over the relative one in the dissipated energy: few increments may agree by chance in what slip adds up
    to, as in a shear after a torsion in one increment, and not in the energy, whose parts are all positive. floor:
    least error over the largest value so far, on cells as long as the contact radius.
    """

    order: float = 0.9
    between: float = 0.5
    safety: float = 2.5
    linked: float = 0.0
    floor: float = 0.1


TILTING = QuantityEstimate(order=1.45, between=0.35, floor=0.3)
DISSIPATED = QuantityEstimate(order=0.85, between=0.3)
CONTACT_SIZE = QuantityEstimate(between=0.25)
CONTACT_RADIUS = QuantityEstimate(order=1.0, between=0.25)
# On the coarse grid its change by the increments is mostly that of its edge within the cells.
STICK_SIZE = QuantityEstimate(between=0.25, safety=2.0)
STICK_RADIUS = QuantityEstimate(between=0.25, safety=2.0, linked=0.2)
DIFFERENT = {
    "delta_z": QuantityEstimate(order=1.4, between=0.3, floor=0.06),
    "max_pressure": QuantityEstimate(order=0.85, between=0.4, floor=0.2),
    "contact_radius": CONTACT_RADIUS,
    "stick_radius": STICK_RADIUS,
    **{name: CONTACT_SIZE if name.startswith("contact") else STICK_SIZE for name in EXTENTS},
    **dict.fromkeys(("Mx", "My", "phi_x", "phi_y"), TILTING),
    **dict.fromkeys(("work", "work_total"), DISSIPATED),
    **dict.fromkeys(TANGENTIAL, QuantityEstimate(order=1.1, between=0.45, linked=0.12)),
}

# Their edges, where the pressure or the shear traction falls smoothly, are found to a small part of a cell.
SMOOTH = {
    "contact_radius": 2.0,
    "stick_radius": 1.5,
    "max_pressure": 1.6,
    "delta_z": 1.7,
    **dict.fromkeys(TANGENTIAL, 1.35),
}


def _columns(estimates: list[QuantityEstimate]) -> list[DoubleArray]:
    return [np.array([getattr(one, field.name) for one in estimates]) for field in fields(QuantityEstimate)]


ORDER, BETWEEN, SAFETY, LINKED, FLOOR = _columns([DIFFERENT.get(name, QuantityEstimate()) for name in ESTIMATED])
"""The constants by quantity, in the order of `ESTIMATED`."""

SMOOTH_ORDER: DoubleArray = np.array([SMOOTH.get(name, order) for name, order in zip(ESTIMATED, ORDER, strict=True)])
"""The orders where bodies do not end."""

CONTACT, STICK, PRESSURE, WORK, TOTAL, MX, MY, MZ, QX, QY = map(
    ESTIMATED.index,
    ("contact_radius", "stick_radius", "max_pressure", "work", "work_total", "Mx", "My", "Mz", "Qx", "Qy"),
)
"""Places in that order."""

CONTACT_EXTENTS, STICK_EXTENTS = (
    np.array([place for place, name in enumerate(ESTIMATED) if name in EXTENTS and name.startswith(zone)])
    for zone in ("contact", "stick")
)
"""Places of half-widths and middles of the zones."""

DISPLACED = np.array([ESTIMATED.index(name) for name in ("delta_z", "delta_x", "delta_y", "phi_z")])
"""Places of the displacements, and of the turn about z: a given load needs less of them on a larger area."""

TILTS = np.array([ESTIMATED.index(name) for name in ("phi_x", "phi_y")])
"""Places of the tilts."""

RADII = np.array([CONTACT, STICK])
"""Places of the radii."""
