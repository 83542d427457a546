"""Least errors of the discretisation, for what no coarse run shows: errors that agree by chance on all grids, stick
zones and slip annuli that fit between the cells, and heights that are finer than these."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.edges import Edge, edges, rounding
from fretsolve.model.required_terms import Model
from fretsolve.result.state import State
from fretsolve.setup.closed_forms.area_forms import spence_ratio
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.quantity_estimates import (
    CONTACT,
    CONTACT_EXTENTS,
    FLOOR,
    MX,
    MY,
    PRESSURE,
    STICK,
    STICK_EXTENTS,
    TOTAL,
    WORK,
)
from fretsolve.system.arrays import DoubleArray, FloatArray

FLOOR_ORDER = 2.0
"""Least error over the largest value so far: FLOOR (h/a)^FLOOR_ORDER, with the longer side h of a cell and the contact
radius a."""

DISSIPATED, DISSIPATED_ORDER = 0.2, 1.5
"""Least error of the dissipated energy over its own value, in the same way."""

CONTACT_EDGE, STICK_EDGE = 0.01, 0.03
"""Least error of the radii over h."""

CONTACT_END, STICK_END, SHARP_END = 0.03, 0.1, 0.5
"""The same of half-widths and middles over h, which depend on the ends of a zone alone."""

PART_STICK, PART_STICK_ORDER = 0.6, 1.5
"""Least error of the radius of a stick zone that does not fill the contact, over a (h/a)^PART_STICK_ORDER."""

SHARP_EDGE = 0.1
"""Least error of radii over h where a body ends sharply, or by a rounding that fits into a cell: all grids round its
outline to their cells."""

MOMENT = 0.02
"""Least error of Mx and My over (h/a)^FLOOR_ORDER P a. They sum up pressures of opposite effect."""

PEAK = 3.0
"""Largest pressure that unresolved heights add, over the root mean square one that flattens them: sqrt(2 ln n) for n
independent Gaussian peaks in contact, here a hundred. A sine has 1.4, which partial contact does not exceed, and two
sines across each other have 2."""

UNSEEN_STICK = 0.75
"""Radius over h of a stick zone that may exist although no cell sticks."""

ANNULUS, ANNULUS_WORK, ANNULUS_CELLS = 1.3, 10.0, 1.5
"""A slip annulus of dissimilar bodies pressed together that is thinner than ANNULUS_CELLS cells is not resolved: more
increments only make it vanish. Its width w is ANNULUS times that of a sphere (Spence), and the energy that it
dissipates while the contact grows is ANNULUS_WORK mu beta (w/a)^2.5 p0^2 a^3/E*, with Dundurs' constant beta: slip of
the order beta w^2/R under a pressure of the order p0 (w/a)^(1/2) in all of the area. The factors hold for spheres and
flat punches, where the order of magnitude alone is 3 too large and 3 too small."""


@dataclass(frozen=True)
class ShearPath:
    """The path of the shear so far, as a part of what friction carries: forces, torque over the radius.

    at: where it is, (3,); largest: how far from 0 it has been, at most 1; last, length: of the way in the last
    increment and in all. A shear that slips within a rounding dissipates what it does up to gross slip times `largest`
    squared times `length`: it goes with the third power of the way from a reversal, halved.
    """

    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    largest: float = 0.0
    last: float = 0.0
    length: float = 0.0

    def after(self, summary: Summary, carried: float) -> ShearPath:
        """Return the path after one more increment; carried: the force (N) that friction carries."""
        if carried <= 0.0:
            return replace(self, last=0.0)
        # under a torque the shear traction at the edge of a round punch is 1.5 times that of a force over the radius
        arm = summary.contact_radius / 1.5
        at = summary.Qx / carried, summary.Qy / carried, summary.Mz / (carried * arm) if arm else 0.0
        last = math.dist(at, self.at)
        return ShearPath(at, max(self.largest, min(math.hypot(*at), 1.0)), last, self.length + last)


@dataclass(frozen=True)
class LeastErrors:
    """The least errors of a problem.

    side: the longer side of a cell, mm; sharp: whether a body ends within a cell; flattening: pressure (MPa) that would
    flatten what the cells do not see of height maps; ridges: pressure (MPa) of their ridges beyond that of cells;
    edges: tips and edges, where pressures are largest.
    """

    model: Model
    side: float
    sharp: bool
    flattening: float
    ridges: float
    edges: tuple[Edge, ...]

    @classmethod
    def of(cls, setup: ProblemSetup) -> LeastErrors:
        """Return the least errors of a problem. Raises FileError or CaseError where a map cannot be read."""
        cell = setup.grid.dx, setup.grid.dy
        flattening, ridges = setup.heights().flattening_pressure(cell), setup.heights().ridge_pressure(cell)
        side, surfaces = max(setup.grid.dx, setup.grid.dy), setup.case.surface
        radii = [radius for surface in surfaces if (radius := rounding(surface)) is not None]
        sharp = min(radii, default=math.inf) < side
        return cls(setup.model, side, sharp, flattening, ridges, edges(surfaces, setup.grid))

    def values(self, state: State, largest: DoubleArray, shear_path: ShearPath) -> DoubleArray:
        """Return the least errors of `ESTIMATED`, in their order; largest: their largest absolute values so far.

        That of the largest pressure is infinite where a sharp tip or edge is in contact.
        """
        summary = state.summary
        # Where the contact has opened, the largest one counts: its errors are those that are left.
        radius = summary.contact_radius or float(largest[CONTACT])
        ratio = self.side / radius if radius > self.side else 1.0
        least: DoubleArray = FLOOR * ratio**FLOOR_ORDER * largest
        ends = math.hypot(CONTACT_END, SHARP_END * self.sharp) * self.side
        least[CONTACT_EXTENTS] = ends
        least[CONTACT] = math.hypot(CONTACT_EDGE, SHARP_EDGE * self.sharp) * self.side
        width, dissipated = self._unseen_slip(summary)
        least[STICK] = self._stick_radius(summary, ratio, width)
        least[STICK_EXTENTS] = max(math.hypot(STICK_END, SHARP_END * self.sharp) * self.side, least[STICK])
        least[[WORK, TOTAL]] = DISSIPATED * ratio**DISSIPATED_ORDER * np.array([summary.work, summary.work_total])
        least[TOTAL] += dissipated
        least[[WORK, TOTAL]] += self._energy_at_edges(state, shear_path) * np.array(
            [shear_path.last, shear_path.length]
        )
        moment = MOMENT * ratio**FLOOR_ORDER * summary.P * summary.contact_radius
        for place in (MX, MY):
            least[place] = math.hypot(moment, least[place])
        if summary.max_pressure:
            peak = least[PRESSURE] + self._hidden_pressure(state.fields.pressure)
            unresolved = min(self.flattening / summary.max_pressure, 1.0)
            least += unresolved * largest
            least[[*CONTACT_EXTENTS, *STICK_EXTENTS]] += unresolved * summary.contact_radius
            least[PRESSURE] = peak
        return least

    def _stick_radius(self, summary: Summary, ratio: float, width: float) -> float:
        """Return the least error of the stick radius; ratio: side over contact radius; width: of an unseen annulus."""
        if summary.stick_radius == 0.0 and self.model.friction > 0.0:
            return UNSEEN_STICK * self.side
        edge = math.hypot(STICK_EDGE, SHARP_EDGE * self.sharp) * self.side
        if 0 < summary.stick_cells < summary.contact_cells or width:
            return math.hypot(edge, PART_STICK * ratio**PART_STICK_ORDER * summary.contact_radius) + width
        return edge

    def _hidden_pressure(self, pressure: FloatArray) -> float:
        """Return by how much the largest pressure may exceed that of the cells, by heights, ridges and edges."""
        modulus = self.model.compliances.contact_modulus
        at_edges = (edge.hidden_pressure(pressure, self.side, modulus) for edge in self.edges)
        return PEAK * self.flattening + self.ridges + max(at_edges, default=0.0)

    def _energy_at_edges(self, state: State, shear_path: ShearPath) -> float:
        """Return what slip within roundings that the cells do not see dissipates (mJ), per length of the path."""
        friction, modulus = self.model.friction, self.model.compliances.contact_modulus
        if not shear_path.largest:
            return 0.0
        energies = (edge.hidden_energy(state.fields.pressure, self.side, modulus, friction) for edge in self.edges)
        return shear_path.largest**2 * sum(energies)

    def _unseen_slip(self, summary: Summary) -> tuple[float, float]:
        """Return width (mm) and dissipated energy (mJ) of a slip annulus too thin for the cells; 0 for others."""
        width = ANNULUS * (1.0 - spence_ratio(self.model)) * summary.contact_radius
        if not 0.0 < width < ANNULUS_CELLS * self.side:
            return 0.0, 0.0
        pair, radius = self.model.compliances, summary.contact_radius
        mismatch = self.model.friction * abs(pair.dundurs_constant) * (width / radius) ** 2.5
        size = radius**2 if self.model.line else radius**3
        return width, ANNULUS_WORK * mismatch * summary.max_pressure**2 * size / pair.contact_modulus
