"""Solve the increments of a line contact, and compute the columns of its history that differ."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fretsolve.contact.increment.increment import IncrementSolver, Solved
from fretsolve.contact.increment.line_increment import LineIncrementSolver, SunkenPoint
from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.contact.zones.line_edges import line_zones, width
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import Fields, Summary
from fretsolve.system.arrays import FloatArray, Vector


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
        solver.sunken = None if depth is None else SunkenPoint(solver.grid, (one, other), depth)
        return cls(setup, solver)

    def rigid_start(self, fields: Fields, rigid: Vector) -> Vector:
        """Return the rigid displacements that the next increment counts from; rigid: those of the history."""
        return self.solver.rigid_start(fields.pressure, fields.shear, float(rigid[2]))

    def with_displacements(self, summary: Summary, solved: Solved) -> Summary:
        """Return a row of the history with NaN for the rigid displacements that hold the free constant."""
        return replace(summary, delta_z=self.solver.approach(solved), delta_x=math.nan, delta_y=math.nan)

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
