"""Solve the increments of a line contact, and compute the columns of its history that differ."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.contact.increment.increment import IncrementSolver, Solved
from fretsolve.contact.increment.line_increment import LineIncrementSolver, PointsAtDepth
from fretsolve.contact.zones.edge_law import LEVER_ALONG, EdgeLaw, ZoneFields
from fretsolve.contact.zones.zone_cells import MARGIN_CELLS, Links, ZoneCells
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import Fields, Summary, Zone
from fretsolve.system.arrays import FloatArray, Vector

Interval = tuple[float, float]


@dataclass(frozen=True)
class LineZones:
    """Intervals (mm) of a line contact: intervals in contact and intervals that stick, each from left to right."""

    contact: tuple[Interval, ...] = ()
    stick: tuple[Interval, ...] = ()


def width(intervals: tuple[Interval, ...]) -> float:
    """Return the length (mm) of intervals together."""
    return math.fsum(right - left for left, right in intervals)


def line_zones(fields: ZoneFields, grid: LineGrid, materials: Compliances) -> LineZones:
    """Return the zones of an increment. fields: (nx, 1), shear and slip (2, nx, 1)."""
    contact = fields.zone != Zone.OPEN
    if not contact.any():
        return LineZones()
    zones = fields.zones(contact)
    part = ZoneCells.around(zones, grid)
    inside = part.inside[:, :, part.beyond]
    zone, before = (inside[:, 1:] != inside[:, :-1]).nonzero()  # the last cells before an edge: outside, inside, ..
    starts = np.arange(before.size) % 2 == 0
    inner, outer = before + starts, before + ~starts
    links = Links(
        zone,
        inner * part.width + part.beyond,
        outer * part.width + part.beyond,
        along_y=np.zeros(before.size, bool),
        length=np.full(before.size, grid.dx),
    )
    lever = np.full(before.size, LEVER_ALONG)
    law = EdgeLaw(part, links, fields, materials)
    beyond = law.shares(lever) - law.inset(lever)
    beyond[np.isnan(beyond)] = 0.5  # where no smooth front fits: at the grid's end, at a sharp edge, in few cells
    corner = np.array([part.corner(number)[0] for number in range(len(zones))])
    first = part.first[0] - MARGIN_CELLS
    edges = corner[zone] + grid.dx * (inner - first[zone] + (outer - inner) * beyond)
    # both laws may see an edge past the middle of a cell that is alone: then the zone is empty
    found = edges.reshape(-1, 2)
    crossed = found[:, 0] > found[:, 1]
    found[crossed] = found[crossed].mean(axis=1, keepdims=True)
    intervals: tuple[tuple[Interval, ...], ...] = tuple(
        tuple((left, right) for left, right in found[zone[::2] == number].tolist()) for number in range(len(zones))
    )
    return LineZones(intervals[0], intervals[-1] if fields.sticks else ())


@dataclass(frozen=True)
class LineContact:
    """A line contact with the solver of its increments."""

    setup: ProblemSetup
    solver: LineIncrementSolver

    @classmethod
    def of(cls, setup: ProblemSetup, solver: IncrementSolver) -> LineContact:
        """Return the line contact of a problem."""
        assert isinstance(solver, LineIncrementSolver)
        (one, other), depth = setup.case.bodies, setup.case.reference_depth
        solver.points = None if depth is None else PointsAtDepth(solver.grid, (one, other), depth)
        return cls(setup, solver)

    def rigid_start(self, fields: Fields, rigid: Vector) -> Vector:
        """Return the rigid displacements that the next increment counts from; rigid: from the history."""
        return self.solver.rigid_start(fields.pressure, fields.shear, rigid)

    def with_displacements(self, summary: Summary, solved: Solved, increment: Increment) -> Summary:
        """Return a row of the history with rigid displacements of points at depth, NaN for unknown ones.

        Imposed ones are as they are, since the solution has them up to its tolerance.
        """
        delta_z, delta_x = self.solver.displacements(solved)
        normal, tangential = increment.normal, increment.tangential
        delta_z = delta_z if normal.forced[0] or normal.compliance is not None else normal.values[0]
        delta_x = delta_x if tangential.forced[0] or tangential.compliance is not None else tangential.values[0]
        return replace(summary, delta_z=delta_z, delta_x=delta_x, delta_y=math.nan)

    def sizes(self, solved: Solved, slip_before: FloatArray) -> dict[str, float]:
        """Return areas per mm, half-widths and extents of contact and stick zone; NaN for extents along y."""
        fields = ZoneFields(
            solved.pressure, solved.gap, solved.shear, solved.friction_limit, solved.slip, solved.zone, slip_before
        )
        grid = self.setup.grid
        assert isinstance(grid, LineGrid)
        zones = line_zones(fields, grid, self.setup.model.compliances)
        sizes: dict[str, float] = {}
        for zone, intervals in (("contact", zones.contact), ("stick", zones.stick)):
            area = min(width(intervals), sizes.get("contact_area", math.inf))
            low, high = (intervals[0][0], intervals[-1][1]) if intervals else (math.nan, math.nan)
            sizes |= {
                f"{zone}_area": area,
                f"{zone}_radius": 0.5 * area,
                f"{zone}_half_width_x": 0.5 * (high - low) if intervals else 0.0,
                f"{zone}_half_width_y": math.nan,
                f"{zone}_center_x": 0.5 * (low + high),
                f"{zone}_center_y": math.nan,
            }
        return sizes
