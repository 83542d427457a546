"""Least errors of tangential motion that no coarse run shows, and that the increments after it carry on.

Where one increment presses and shears a contact, or presses it and pulls a body, cells that come into contact late take
part in the whole shear. They may slip although cells that are pressed and sheared little by little would stick. Coarse
grids have no such cells where the contact grows by less than a cell.

Unlike bodies that are pressed and tilted slip towards a stick zone beside the middle. Where it fits into a cell, their
displacement is known to what the surfaces stretch within that, then and later.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np

from fretsolve.case.history import TANGENTIAL
from fretsolve.model.required_terms import Model
from fretsolve.result.state import ESTIMATED, Summary
from fretsolve.simulation.error_bars.coarse_runs import values_of
from fretsolve.simulation.error_bars.quantity_estimates import (
    ALL,
    CONTACT,
    DELTA_X,
    DELTA_Y,
    DELTA_Z,
    MZ,
    QX,
    QY,
    STICK,
    STICK_EXTENTS,
    TOTAL,
    WORK,
)
from fretsolve.simulation.error_bars.shear_path import UNSHEARED
from fretsolve.system.arrays import DoubleArray

LATE, LATE_ENERGY, LATE_EDGE, LATER_EDGE = 0.2, 2.0, 0.5, 0.1
"""Least errors by late contact: of what the increment changes, over the part of the contact radius that it adds; the
relative one of the energy dissipated in it and later, over that part, ALL at most; and those of its stick radius, and
of later ones, over what it adds to the contact radius."""

UNLOADED, APPROACH = 0.34, 0.8
"""Least relative error of the contact radius of unlike bodies that are unloaded, over (beta mu / (mu + beta))^2 and one
over the increments that pressed up to that load. Where all sticks, an unloading goes back to the states that few
increments had pressed. And of the approach, over that of the radius, also where few increments press."""

UNLOADED_STICK, UNLOADED_ORDER = 0.4, 2.0
"""Least error of the stick radius of unlike bodies that are unloaded, over the contact radius and min(mu/beta, 1),
after one increment that pressed up to the present load; after k it is that over k^UNLOADED_ORDER. Spheres that 1 to 8
increments pressed and 4 unloaded to 0.05 to 0.8 of the load had up to 0.34 after one, 0.07 after two, 0.02 after
more."""

MOVED = np.array([name in TANGENTIAL for name in ESTIMATED])
"""Which of `ESTIMATED` are tangential."""


@dataclass(frozen=True, eq=False)
class MissedMotion:
    """The least errors so far.

    late: largest ones by late contact, in the order of `ESTIMATED`; energy: relative one of what has been dissipated
    beyond `before` (mJ); edge, later_edge: those of the last stick radius and of all later ones (mm); middle: that of
    displacements between unlike bodies whose stick zone no cell has seen (mm); radius: relative one of the last
    contact radius between unlike bodies that are unloaded, or pressed by few increments.
    """

    late: DoubleArray
    energy: float = 0.0
    before: float = 0.0
    edge: float = 0.0
    later_edge: float = 0.0
    middle: float = 0.0
    radius: float = 0.0

    def after(self, middle: float, edge: float = 0.0, radius: float = 0.0) -> MissedMotion:
        """Return them after an increment.

        middle, edge: its least errors of the displacements and the stick radius; radius: see the class.
        """
        return replace(self, edge=max(edge, self.later_edge), middle=max(self.middle, middle), radius=radius)

    def after_late_contact(
        self, before: Summary | None, now: Summary, friction: float, pulled: float = 0.0
    ) -> MissedMotion:
        """Add those of an increment, if it presses and shears; before: None for the first.

        pulled: force (N) by which a change of bulk stress shears. Where nothing touched before, all contact is late.
        """
        change = values_of(now) - (0.0 if before is None else values_of(before))
        added, sheared = float(change[CONTACT]), math.hypot(*change[[QX, QY]], change[MZ] / now.contact_radius, pulled)
        if not (added > 0.0 and sheared > UNSHEARED * friction * now.P):
            return self
        grown = added / now.contact_radius
        return replace(
            self,
            late=np.fmax(self.late, LATE * grown * np.where(MOVED, np.abs(change), 0.0)),  # a middle may be NaN
            energy=max(self.energy, min(LATE_ENERGY * grown, ALL)),
            before=self.before if self.energy or before is None else before.work_total,
            edge=max(self.edge, LATE_EDGE * added),
            later_edge=max(self.later_edge, LATER_EDGE * added),
        )

    def add_to(self, least: DoubleArray, summary: Summary) -> None:
        """Add them to the `least` errors of `ESTIMATED`."""
        least += self.late
        least[[DELTA_X, DELTA_Y]] += self.middle
        least[[WORK, TOTAL]] += self.energy * np.array([summary.work, summary.work_total - self.before])
        least[[STICK, *STICK_EXTENTS]] += self.edge
        least[CONTACT] = math.hypot(least[CONTACT], self.radius * summary.contact_radius)
        least[DELTA_Z] = math.hypot(least[DELTA_Z], APPROACH * self.radius * summary.delta_z)


NOTHING_MISSED = MissedMotion(np.zeros(len(ESTIMATED)))


def pressed_up_to(summaries: Sequence[Summary], peak: float) -> int:
    """Return how many increments, 1 at least, pressed up to the present P where that is below its largest one; else 0.

    peak: the largest P so far (N).
    """
    now = summaries[-1].P
    if not 0.0 < now < (1.0 - UNSHEARED) * peak:
        return 0
    loads = takewhile(lambda load: load < peak, (row.P for row in summaries))
    return max(sum(load <= (1.0 + UNSHEARED) * now for load in loads), 1)


def of_unloading(model: Model, increments: int) -> float:
    """Return the least relative error of the contact radius of unlike bodies that are unloaded, 0 of others.

    increments: those of `pressed_up_to`.
    """
    if not (model.coupled and model.friction and increments):
        return 0.0
    mismatch = abs(model.compliances.dundurs_constant)
    return UNLOADED * (mismatch * model.friction / (model.friction + mismatch)) ** 2 / increments


def edge_of_unloading(model: Model, summary: Summary, increments: int) -> float:
    """Return the least error (mm) of the stick radius of unlike bodies that are unloaded, 0 of others.

    increments: those of `pressed_up_to`.
    """
    if not (model.coupled and increments):
        return 0.0
    part = min(model.friction / abs(model.compliances.dundurs_constant), 1.0)
    return UNLOADED_STICK * part * summary.contact_radius / math.pow(increments, UNLOADED_ORDER)
