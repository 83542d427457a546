"""What the cells of a problem are to its bodies: their sides, edges of the bodies, and heights that they miss."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.problem.model.required_terms import Model
from fretsolve.problem.model.surface import Edge, edges, rounding
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import State

ROUNDED_CELLS = 2.0
"""Cells over which a rounding is in contact, up to which all grids round the body's outline to their cells."""


@dataclass(frozen=True)
class Cells:
    """The cells of a problem.

    side: the longer one of a cell (mm); edges: tips and edges of the surfaces; sharp: whether a body ends within a
    cell; flattening, ridges: pressures (MPa) that would flatten what the cells do not see of height maps, and of their
    ridges beyond that of cells; maps: whether there are any; uniform: whether the friction limit is everywhere the
    model's coefficient times the pressure; holes: the edge of a height map's holes that the contact reaches.
    """

    model: Model
    side: float
    edges: tuple[Edge, ...]
    sharp: bool
    flattening: float
    ridges: float
    maps: bool
    uniform: bool
    holes: Edge | None = None

    @classmethod
    def of(cls, setup: ProblemSetup) -> Cells:
        """Return the cells of a problem. Raises FileError or CaseError where a map cannot be read."""
        cell, heights, surfaces = (setup.grid.dx, setup.grid.dy), setup.heights(), setup.case.surface
        return cls(
            model=setup.model,
            side=max(cell),
            edges=edges(surfaces, setup.grid),
            sharp=any((radius := rounding(surface)) is not None and radius < max(cell) for surface in surfaces),
            flattening=heights.flattening_pressure(cell),
            ridges=heights.ridge_pressure(cell),
            maps=any(surface.kind == "heights" for surface in surfaces),
            uniform=not setup.case.friction_varies and setup.model.orthotropy is None,
        )

    def reached_by(self, state: State) -> Cells:
        """Return the cells with the holes of a height map that the contact reaches: there a body ends, too."""
        if not self.maps or np.isfinite(state.fields.gap).all():
            return self
        from scipy.ndimage import binary_dilation  # height maps alone need it

        edge = Edge(0.0, binary_dilation(~np.isfinite(state.fields.gap), np.ones((3, 3))))
        return replace(self, sharp=True, holes=edge) if edge.touches(state.fields.pressure) else self

    def rounded(self, state: State) -> float:
        """Return how much of an error counts that all grids share as they round a body's outline to their cells.

        It is 1 at a sharp end, and falls with the square of the cells over which a rounding is in contact.
        """
        modulus, pressure = self.model.compliances.contact_modulus, state.fields.pressure
        seen = min((edge.cells_in_contact(pressure, self.side, modulus) for edge in self.edges), default=math.inf)
        return 1.0 if self.sharp else (ROUNDED_CELLS / max(seen, ROUNDED_CELLS)) ** 2

    @property
    def mismatch(self) -> float:
        """The size of Dundurs' constant beta where pressure and shear act on each other, else 0."""
        return abs(self.model.compliances.dundurs_constant) if self.model.coupled else 0.0
