"""Solve the increments of a contact on an area, and compute the sizes of its zones."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fretsolve.case.history import FEWEST_SPOT_CELLS, SPOTS
from fretsolve.increment.increment import IncrementSolver, Solved
from fretsolve.result.layout import may_have_spots
from fretsolve.result.state import Fields, Summary
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.zones.compiled_sizes import ZoneSize, compiled_sizes
from fretsolve.simulation.zones.edge_shares import ZoneFields
from fretsolve.simulation.zones.zone_areas import zone_area
from fretsolve.simulation.zones.zone_edges import ZoneEdge, contact_edge, stick_edge
from fretsolve.simulation.zones.zone_extents import Extent, zone_extent
from fretsolve.system.arrays import FloatArray, Vector

UNMEASURED = {
    f"{zone}_{name}": math.nan for zone in ("contact", "stick") for name in ("area", "radius", *Extent._fields)
}
"""The sizes of zones that are not measured, by the names that sizes have."""


class _Outline(NamedTuple):
    """The edge of a contact with the fields that it follows from, and its size."""

    pressure: FloatArray
    gap: FloatArray
    edge: ZoneEdge | None
    size: ZoneSize


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
        self._outline: _Outline | None = None
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
        kernels = self.solver.team.kernels.zones
        if kernels is None:
            contact, stick = self._sizes_by_edges(fields)
        else:
            contact, stick = compiled_sizes(kernels, fields, self._setup.grid, model.compliances)
        area = min(stick.area, contact.area)
        values = (*_radius_too(contact.area), *contact.extent, *_radius_too(area), *stick.extent)
        sizes: dict[str, Any] = dict(zip(UNMEASURED, values, strict=True))
        return sizes | (spot_counts(solved.pressure) if self._may_have_spots else {})

    def _sizes_by_edges(self, fields: ZoneFields) -> tuple[ZoneSize, ZoneSize]:
        """Return the sizes of contact and stick zone."""
        contact = self._outline = self._contact(fields.pressure, fields.gap)
        stick = stick_edge(fields, self._setup.grid, self._setup.model.compliances, contact.edge)
        size = contact.size if stick is contact.edge else ZoneSize(zone_area(stick), zone_extent(stick))
        return contact.size, size

    def _contact(self, pressure: FloatArray, gap: FloatArray) -> _Outline:
        """Return the outline of the contact: the last one, if shear moves uncoupled surfaces at a constant load."""
        last = self._outline
        if last is not None and np.array_equal(pressure, last.pressure) and np.array_equal(gap, last.gap):
            return last
        edge = contact_edge(pressure, gap, self._setup.grid, self._setup.model.compliances)
        return _Outline(pressure, gap, edge, ZoneSize(zone_area(edge), zone_extent(edge)))
