"""Least errors of tangential motion that no coarse run shows, and that the increments after it carry on.

Where one increment presses and shears a contact, cells that come into contact late take part in the whole shear. They
may slip although cells that are pressed and sheared little by little would stick. Coarse grids have no such cells where
the contact grows by less than a cell.

Unlike bodies that are pressed and tilted slip towards a stick zone beside the middle. Where no cell sees it, all of
them slip, and their displacement is known to what the surfaces stretch within a cell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import TANGENTIAL
from fretsolve.result.state import ESTIMATED, Summary
from fretsolve.simulation.coarse_runs import values_of
from fretsolve.simulation.quantity_estimates import DELTA_X, DELTA_Y, STICK, TOTAL, WORK
from fretsolve.system.arrays import DoubleArray

LATE, LATE_ENERGY, LATE_EDGE = 0.2, 2.0, 0.5
"""Least errors by late contact: of what the increment changes, over the part of the contact radius that it adds; the
relative one of the energy dissipated in it and later, over that part, 1 at most; and that of its stick radius over what
it adds to the contact radius."""

MOVED = np.array([name in TANGENTIAL for name in ESTIMATED])
"""Which of `ESTIMATED` are tangential."""


@dataclass(frozen=True, eq=False)
class MissedMotion:
    """late: least errors by late contact so far, in the order of `ESTIMATED`; energy: relative one of the dissipated
    energy; edge: least error of the last stick radius (mm); middle: of displacements between unlike bodies whose stick
    zone no cell has seen (mm).
    """

    late: DoubleArray
    energy: float = 0.0
    edge: float = 0.0
    middle: float = 0.0

    def after_late_contact(self, before: Summary, now: Summary) -> MissedMotion:
        """Add those of an increment that presses and shears, `now`, and is alone in its stage."""
        added = now.contact_radius - before.contact_radius
        if not (before.contact_radius and added > 0.0):
            return self
        grown = added / now.contact_radius
        late = self.late + LATE * grown * np.abs(values_of(now) - values_of(before)) * MOVED
        energy = max(self.energy, min(LATE_ENERGY * grown, 1.0))
        return replace(self, late=late, energy=energy, edge=LATE_EDGE * added)

    def after(self, middle: float) -> MissedMotion:
        """Return them after an increment; middle: its least error of the displacements."""
        return replace(self, edge=0.0, middle=max(self.middle, middle))

    def add_to(self, least: DoubleArray, summary: Summary) -> None:
        """Add them to the `least` errors of `ESTIMATED`."""
        least += self.late
        least[[DELTA_X, DELTA_Y]] += self.middle
        least[[WORK, TOTAL]] += self.energy * np.array([summary.work, summary.work_total])
        least[STICK] += self.edge


NOTHING_MISSED = MissedMotion(np.zeros(len(ESTIMATED)))
