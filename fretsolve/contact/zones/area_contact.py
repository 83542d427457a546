"""Solve the increments of a contact on an area, and compute the sizes of its zones."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fretsolve.case.history import FEWEST_SPOT_CELLS, SPOTS
from fretsolve.contact.increment.increment import IncrementSolver, Solved
from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.contact.zones.zone_sizes import Extent, zone_sizes
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.layout import may_have_spots
from fretsolve.result.state import Fields, Summary
from fretsolve.system.arrays import FloatArray, Vector

UNMEASURED = {
    f"{zone}_{name}": math.nan for zone in ("contact", "stick") for name in ("area", "radius", *Extent._fields)
}
"""The sizes of zones that are not measured, by the names that sizes have."""


def spot_counts(pressure: FloatArray) -> dict[str, int]:
    """Return the number of spots under a pressure, and of those of few cells; cells touch at sides or corners."""
    from scipy import ndimage  # few cases may have several spots

    labels, count = ndimage.label(pressure > 0.0, structure=np.ones((3, 3)))
    cells = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    return dict(zip(SPOTS, (int(count), int(np.count_nonzero(cells < FEWEST_SPOT_CELLS))), strict=True))


def _radius_too(area: float) -> tuple[float, float]:
    """Return an area and the radius of the circle that has it."""
    return area, math.sqrt(area / math.pi)


class AreaContact:
    """A contact on an area with the solver of its increments."""

    def __init__(self, setup: ProblemSetup, solver: IncrementSolver):
        self.solver = solver
        self._setup = setup
        self._may_have_spots = may_have_spots(setup.case.effective())

    def rigid_start(self, fields: Fields, rigid: Vector) -> Vector:
        """Return the rigid displacements that the next increment counts from: those of the history, `rigid`."""
        return rigid

    def with_displacements(self, summary: Summary, solved: Solved) -> Summary:
        """Return a row of the history with the rigid displacements as they are meant: the solution's."""
        return summary

    def sizes(self, solved: Solved, slip_before: FloatArray) -> dict[str, Any]:
        """Return areas, radii and extents of contact and stick zone, with their edges placed inside the cells.

        Where there may be several spots, their numbers, too.
        """
        model = self._setup.model
        shear, slip, orthotropy = solved.shear, solved.slip, model.orthotropy
        if orthotropy is not None:
            shear, slip = orthotropy.inverse.times(shear), orthotropy.times(slip)
            slip_before = orthotropy.times(slip_before)
        fields = ZoneFields(solved.pressure, solved.gap, shear, solved.friction_limit, slip, solved.zone, slip_before)
        contact, stick = zone_sizes(fields, self._setup.grid, model.compliances)
        area = min(stick.area, contact.area)
        values = (*_radius_too(contact.area), *contact.extent, *_radius_too(area), *stick.extent)
        sizes: dict[str, Any] = dict(zip(UNMEASURED, values, strict=True))
        return sizes | (spot_counts(solved.pressure) if self._may_have_spots else {})
