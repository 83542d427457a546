"""Least errors of the discretisation, for what no coarse run shows: errors that agree by chance on all grids, stick
zones and slip annuli that fit between the cells, and heights that are finer than these."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.edges import Edge, edges, flat_part, missed_area, rounding
from fretsolve.model.required_terms import Model
from fretsolve.result.state import ESTIMATED, State
from fretsolve.setup.closed_forms import spence_ratio
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.error_bars.few_increments import add_turned
from fretsolve.simulation.error_bars.least_errors.hidden_pressure import HiddenPressure
from fretsolve.simulation.error_bars.least_errors.map_holes import Holes, holes_in_contact
from fretsolve.simulation.error_bars.least_errors.moments import add_moments_and_tilts
from fretsolve.simulation.error_bars.least_errors.thin_shear import add_thin_shear
from fretsolve.simulation.error_bars.least_errors.unseen_slip import UnseenSlip
from fretsolve.simulation.error_bars.least_errors.zone_errors import SHARP_EDGE, ZoneErrors
from fretsolve.simulation.error_bars.quantity_estimates import (
    ALL,
    BY_AREA,
    CONTACT,
    CONTACT_EXTENTS,
    DELTA_X,
    DELTA_Y,
    FLOOR,
    LOAD,
    MX,
    MY,
    MZ,
    PHI_X,
    PHI_Y,
    PRESSURE,
    STICK_EXTENTS,
    TOTAL,
    TURNS,
    WORK,
    room,
)
from fretsolve.simulation.error_bars.shear_path import UNSHEARED, ShearPath
from fretsolve.system.arrays import DoubleArray

DISSIPATED, DISSIPATED_FACETS = 0.15, 0.08
"""Least error of the dissipated energy over its own value, over the mean (h/a)^2 of `_cells_over_contact`, and on
facets of a height map over h/a with the longer side h of a cell and the contact radius a."""

ROUNDED_EDGE, ROUNDED_EDGE_LINE = 0.26, 0.6
"""Least error of radii over h where a rounding is longer than a cell, but in contact over less than one: its cells
touch or do not touch as a whole. So do those beside holes of a height map, which have no gap. In line contacts both
edges may lie alike in their cells."""

ROUNDED_CELLS, ROUNDED_CELLS_LINE = 2.0, 1.0
"""Number of cells over which a rounding is in contact, up to which ROUNDED_EDGE and ROUNDED_EDGE_LINE hold; over more
cells they fall with the square of it. On areas two errors at 3 cells were 0.1 h, all others there and beyond below
0.03 h."""

MISSED_OUTLINE = 0.6
"""Least relative error of radii over the part of its area that cells miss of a sharp body: half of that, and room for
WIDTH."""

RIDGE_EDGE = 0.4
"""The same where the edge of the contact runs over facets of a height map that are longer than the cells: RIDGE_EDGE
times the pressure at ridges, which may bound it, over that of the contact's last cell, ROUNDED_EDGE at most."""

ALONG_X = np.full(len(ESTIMATED), 0.5)
"""Part of the cells' extent along x in the mean (h/a)^2 of each value, around the edge of a round contact. A moment or
tilt about y has the lever x, which counts the edge's places by its square."""
ALONG_X[[MX, PHI_X]], ALONG_X[[MY, PHI_Y]] = 0.25, 0.75

SHARP_MOMENT, SHARP_TURN = 3.0, 5.0
"""Least relative error of moments and of turns over that of the radius of a sharp outline: at a given turn a moment
goes with the third power of the radius. Turns of sharp punches had errors of up to 7.5 times SHARP_EDGE h/a, those of
roundings in contact over some cells of up to 4 times that."""

FLATTENED = 0.5
"""Relative error by heights that the cells miss, over the square of the part of the largest pressure that would flatten
them, where that is small: where the pressure is less, near the edge, the bodies touch in part. Where it is 1 nothing is
known, and the relative error is 1."""

THIN_SLIP, THIN_SLIP_CELLS, THINNEST_SLIP = 0.12, 1.5, 0.25
"""Least relative error of what an increment dissipates in an annulus thinner than THIN_SLIP_CELLS cells, over h over
its width, which counts as THINNEST_SLIP h at least."""

EDGE_SLIP, EDGE_SLIP_LIKE, EDGE_SLIP_LINE, EDGE_SLIP_ORDER = 0.22, 0.12, 0.3, 1.5
"""The same of all annuli over (h/w)^EDGE_SLIP_ORDER (h/a)^(1/2) with their width w and the contact radius a, ALL at
most: the edge of the stick zone may lie anywhere in the cells, which is averaged around the contact. In line contacts
nothing is, and (h/a)^(1/2) is left out. In a first shear 9 of 10 errors were below 0.17 to 0.23 times that on spheres
of 8 to 50 cells per radius, and 0.26 times in line contacts, all below 0.4. EDGE_SLIP_LIKE is that on areas between
like bodies without ends in stages of three or more increments, whose errors make up for each other in part: where it is
most of the bar of `work_total`, 19 of 20 random errors were below 0.08 (300 values of seeds 54 to 62). What the coarse
runs show comes on top."""

HOLE_SLIP = 3.0
"""Factor on EDGE_SLIP_LINE in contacts that reach holes of a height map: the edge of the body, too, lies anywhere in
its cell, by some h/4. An annulus dissipates with the third power of its width."""

PRESSED_SIDEWAYS = 0.3
"""Least error of the displacements of unlike bodies on areas over (h/a)^2 min(beta, mu) P/E* a, with the largest P and
a so far. Pressing shears their surfaces against each other by about min(beta, mu) P/E* a. In a symmetric contact that
adds up to nothing, on cells to a small part of it, which counts where the shear is small: where bars without it were
too small for friction of 0.02 to 0.06 (seeds 54 to 74), errors were 0.07 to 0.55 times that."""

STRETCH, UNTILTED = 0.15, 1e-3
"""Least error of the displacements of unlike bodies that are tilted and stick within a cell, over beta p h/E*; and the
tilt times the contact radius over the approach from which on they count as tilted."""

PRESSED_STEPS, PRESSED_CELLS = 6.0, 3.0
"""Least relative error, ALL at most, of what pressing unlike bodies dissipates in an annulus thinner than PRESSED_CELLS
cells, over one over the number of increments: coarse runs see next to no annulus, and not what more increments change.
"""


@dataclass(frozen=True)
class LeastErrors:
    """The least errors of a problem.

    cell: sides of a cell along x and y (mm), both alike in line contact; sharp: whether a body ends within a cell;
    ends: whether one ends at all; missed: part by which the cells in the outline of a sharp body miss its area, or its
    length; flattening: pressure (MPa) that would flatten what the cells do not see of height maps; ridges: pressure
    (MPa) of their ridges beyond that of cells; maps: whether there are height maps; edges: tips and edges, where
    pressures are largest; flat: radius (mm) of the flat part of a punch, None without one; uniform: whether the
    friction limit is everywhere the model's coefficient times the pressure.
    """

    model: Model
    cell: tuple[float, float]
    sharp: bool
    ends: bool
    missed: float
    flattening: float
    ridges: float
    maps: bool
    edges: tuple[Edge, ...]
    flat: float | None = None
    uniform: bool = True

    @property
    def side(self) -> float:
        """The longer side of a cell, mm."""
        return max(self.cell)

    @property
    def _unseen_slip(self) -> UnseenSlip:
        """Slip that no cell shows."""
        slender = self.side / min(self.cell)
        return UnseenSlip(self.model, self.side, slender, self.ends, self.edges, self.flat)

    @property
    def _hidden_pressure(self) -> HiddenPressure:
        """The part of the largest pressure that cells hide."""
        return HiddenPressure(self.model, self.side, self.flattening, self.ridges, self.maps, self.edges)

    @classmethod
    def of(cls, setup: ProblemSetup) -> LeastErrors:
        """Return the least errors of a problem. Raises FileError or CaseError where a map cannot be read."""
        cell = setup.grid.dx, setup.grid.dy
        flattening, ridges = setup.heights().flattening_pressure(cell), setup.heights().ridge_pressure(cell)
        side, surfaces = max(cell), setup.case.surface
        radii = [radius for surface in surfaces if (radius := rounding(surface)) is not None]
        sharp = min(radii, default=math.inf) < side
        missed = max((missed_area(surface, setup.grid) for surface in surfaces), default=0.0) if sharp else 0.0
        found = edges(surfaces, setup.grid)
        maps = any(surface.kind == "heights" for surface in surfaces)
        flats = [flat_part(surface, line=setup.model.line) for surface in surfaces if surface.kind == "punch"]
        flat = min(flats, default=None)
        uniform = not setup.case.friction_varies and setup.model.orthotropy is None
        shape = cell, sharp, bool(radii), missed
        return cls(setup.model, *shape, flattening, ridges, maps, found, flat, uniform)

    def values(self, state: State, largest: DoubleArray, shear_path: ShearPath) -> DoubleArray:
        """Return the least errors of `ESTIMATED`, in their order; largest: their largest absolute values so far.

        That of the largest pressure is infinite where a sharp tip or edge is in contact.
        """
        summary, holes = state.summary, holes_in_contact(state) if self.maps else None
        seen = 0.0 if holes is not None else self._cells_of_roundings(state)
        whole = not self.sharp and seen < 1.0
        outline = self._outline(summary, seen)
        # Where the contact has opened, the largest one counts: its errors are those that are left.
        radius = summary.contact_radius or float(largest[CONTACT])
        ratio = self.side / radius if radius > self.side else 1.0
        cells = self._cells_over_contact(summary, radius)
        least: DoubleArray = FLOOR * cells * largest
        self._add_pressed_sideways(least, largest, cells)
        on_facets = DISSIPATED_FACETS * ratio if self.ridges else 0.0
        zones = ZoneErrors(self.model, self.side, self.ends, self.uniform, self.maps, self._unseen_slip)
        zones.put_into(least, state, math.hypot(outline, MISSED_OUTLINE * self.missed * radius), ratio, shear_path)
        relative = math.hypot(DISSIPATED * cells[TOTAL], on_facets)
        least[[WORK, TOTAL]] = self._dissipated(state, relative, shear_path, self._with_holes(holes))
        add_moments_and_tilts(least, self.model, summary, largest, cells, ends=self.ends)
        if shear_path.turned:
            add_turned(least, largest, summary, shear_path)
        if not self.ends:
            add_thin_shear(least, self._unseen_slip, summary, largest, shear_path)
        if radius and (self.sharp or whole):
            place = outline if self.sharp else SHARP_EDGE * self.side
            self._add_sharp_outline(least, largest, place / radius)
        elif radius and math.isfinite(seen):
            turned = SHARP_TURN * SHARP_EDGE * self.side / radius * self._hidden_by_rounding(seen)
            least[TURNS] = np.hypot(least[TURNS], turned * largest[TURNS])
        if holes is not None:
            holes.add_to(least, self.model, summary, largest, self.cell)
        if summary.max_pressure:
            self._add_heights(least, summary, largest)
            least[PRESSURE] += self._hidden_pressure.of(state, holes.pressure if holes else 0.0)
        return least

    def _cells_over_contact(self, summary: Summary, radius: float) -> DoubleArray:
        """Return the mean (h/a)^2 of each value of `ESTIMATED`, at most 1, for errors of second order in the cells.

        The mean is over places on the edge of the contact, h is the extent of a cell across the edge. An ellipse on
        cells as slender as it is counts like a circle on square ones.
        """
        widths = summary.contact_half_width_x, summary.contact_half_width_y
        slender = widths[1] / widths[0] if min(widths) > 0.0 and not self.model.line else 1.0
        along_x, along_y = self.cell[0] ** 2 * slender, self.cell[1] ** 2 / slender
        mean: DoubleArray = ALONG_X * along_x + (1.0 - ALONG_X) * along_y
        return np.minimum(mean / radius**2, 1.0) if radius else np.ones_like(mean)

    def _add_pressed_sideways(self, least: DoubleArray, largest: DoubleArray, cells: DoubleArray) -> None:
        """Add what pressing unlike bodies moves them sideways by errors of the cells; cells: the mean (h/a)^2."""
        pair = self.model.compliances
        if self.model.line or not (self.model.coupled and largest[CONTACT]):
            return  # the displacements of a line contact have a free constant
        pressed = largest[LOAD] / (pair.contact_modulus * largest[CONTACT])
        sheared = min(abs(pair.dundurs_constant), self.model.friction) * pressed
        sideways = [DELTA_X, DELTA_Y]
        least[sideways] = np.hypot(least[sideways], PRESSED_SIDEWAYS * cells[sideways] * sheared)

    def _with_holes(self, holes: Holes | None) -> UnseenSlip:
        """Return slip that no cell shows, also at the sharp edge where the contact reaches holes of a height map."""
        unseen = self._unseen_slip
        return unseen if holes is None else replace(unseen, holes=True, edges=(*unseen.edges, holes.edge))

    def _dissipated(self, state: State, relative: float, shear_path: ShearPath, unseen: UnseenSlip) -> DoubleArray:
        """Return those of the energy dissipated in the last increment and in all, (2,).

        relative: by their own size; unseen: slip that no cell shows.
        """
        summary = state.summary
        walked = np.array([shear_path.last, shear_path.length])
        ways = max(shear_path.length, shear_path.largest)  # pressing unlike bodies slips once
        part = shear_path.last / shear_path.length if shear_path.length else 0.0
        dissipated = np.array([summary.work, summary.work_total])
        at_edge = np.array([shear_path.last_at_edge, shear_path.at_edge])
        if unseen.holes and self.model.line:
            at_edge = np.maximum(at_edge, np.minimum(HOLE_SLIP * at_edge, ALL * dissipated))
        found: DoubleArray = np.linalg.norm(
            [
                relative * dissipated + at_edge,
                unseen.energies_of_annulus(summary, shear_path.before),
                room(self.model) * unseen.energies_of_shear(summary, shear_path.largest, walked),
                unseen.at_roundings(state, shear_path.largest) * np.array(shear_path.ways_under_load),
                unseen.at_sharp_edges(state, shear_path.largest) * ways * np.array([part, 1.0]),
                unseen.beyond_roundings(state, self.sheared_by_pressing(summary), shear_path),
            ],
            axis=0,
        )
        return found

    def _add_sharp_outline(self, least: DoubleArray, largest: DoubleArray, outline: float) -> None:
        """Add what the outline of a sharp body misses, or of one whose rounding cells hardly show.

        outline: its least error over the contact radius.
        """
        moments, deep = [MX, MY, MZ], math.hypot(outline, self.missed)
        least[moments] = np.hypot(least[moments], SHARP_MOMENT * outline * largest[moments])
        least[BY_AREA] = np.hypot(least[BY_AREA], deep * largest[BY_AREA])
        energies = [WORK, TOTAL]
        least[energies] = np.hypot(least[energies], deep * largest[energies])
        least[TURNS] = np.hypot(least[TURNS], SHARP_TURN * deep * largest[TURNS])

    def _add_heights(self, least: DoubleArray, summary: Summary, largest: DoubleArray) -> None:
        """Add what heights miss that are finer than the cells, but for the largest pressure."""
        flattened = min(self.flattening / summary.max_pressure, 1.0)
        parts = room(self.model) * np.full(len(least), (FLATTENED + (1.0 - FLATTENED) * flattened) * flattened**2)
        parts[[MX, MY]], parts[PRESSURE] = flattened, 0.0
        scales = largest.copy()
        scales[[*CONTACT_EXTENTS, *STICK_EXTENTS]] = summary.contact_radius  # a middle may be at 0
        least += parts * scales

    def _outline(self, summary: Summary, seen: float) -> float:
        """Return the least error (mm) of the radii where a body ends, or where facets bound the contact.

        seen: over how many cells a rounding is in contact, 0 at holes.
        """
        if self.sharp:  # what cells miss of a line contact's width, they miss in its outline
            missed = self.missed * summary.contact_radius if self.model.line else 0.0
            return math.hypot(SHARP_EDGE * self.side, missed)
        most = ROUNDED_EDGE_LINE if self.model.line else ROUNDED_EDGE
        rounded = most * self._hidden_by_rounding(seen) * self.side
        if seen < 1.0 or not (self.ridges and summary.contact_radius):
            return rounded
        last = summary.max_pressure * math.sqrt(2.0 * min(self.side / summary.contact_radius, 0.5))
        return math.hypot(rounded, min(RIDGE_EDGE * self.ridges / last, ROUNDED_EDGE) * self.side)

    def _hidden_by_rounding(self, seen: float) -> float:
        """Return how much of the least errors at a rounding there is where that is in contact over `seen` cells."""
        cells = ROUNDED_CELLS_LINE if self.model.line else ROUNDED_CELLS
        return (cells / max(seen, cells)) ** 2

    def _cells_of_roundings(self, state: State) -> float:
        """Return over how many cells a rounding is in contact, infinity where none is."""
        modulus = self.model.compliances.contact_modulus
        found = (edge.cells_in_contact(state.fields.pressure, self.side, modulus) for edge in self.edges)
        return min(found, default=math.inf)

    def unseen_middle(self, summary: Summary) -> float:
        """Return the least error (mm) of the displacements of unlike bodies that are tilted, or 0.

        It is there where their stick zone (Spence) fits into a cell, in which their surfaces stretch by some beta p/E*
        against each other.
        """
        tilt = math.hypot(summary.phi_x, summary.phi_y) * summary.contact_radius
        stick = spence_ratio(self.model) * summary.contact_radius
        if not self.model.coupled or stick >= self.side or tilt < UNTILTED * abs(summary.delta_z):
            return 0.0
        mismatch = abs(self.model.compliances.dundurs_constant) / self.model.compliances.contact_modulus
        return STRETCH * mismatch * summary.max_pressure * self.side

    def energy_at_edge(self, summary: Summary, count: int) -> float:
        """Return the least error (mJ) of what an increment dissipates, by the width of its slip annulus in cells.

        count: number of increments of its stage.
        """
        if not (summary.work and summary.stick_radius):
            return 0.0
        width = max((summary.contact_radius - summary.stick_radius) / self.side, THINNEST_SLIP)
        like = self.uniform and not (self.model.coupled or self.ends)
        around = EDGE_SLIP_LIKE if like and count > 2 else EDGE_SLIP
        around *= math.sqrt(self.side / summary.contact_radius)
        relative = (EDGE_SLIP_LINE if self.model.line else around) / math.pow(width, EDGE_SLIP_ORDER)
        if width < THIN_SLIP_CELLS:
            relative = max(relative, THIN_SLIP / width)
        sheared = math.hypot(summary.Qx, summary.Qy, summary.Mz / summary.contact_radius)
        if width < PRESSED_CELLS and self.model.coupled and sheared < UNSHEARED * self.model.friction * summary.P:
            relative = max(relative, PRESSED_STEPS / count)
        return min(relative, ALL) * summary.work

    def sheared_by_pressing(self, summary: Summary) -> float:
        """Return the share of the friction limit that pressing unlike bodies takes near an edge, at most 1.

        At that of a flat punch that sticks, q/p is (beta/pi) ln(2a/s) a small distance s from it, here a cell.
        """
        radius, mismatch = summary.contact_radius, abs(self.model.compliances.dundurs_constant)
        if not (self.edges and self.model.coupled and self.model.friction) or radius <= self.side:
            return 0.0
        return min(mismatch * math.log(2.0 * radius / self.side) / (math.pi * self.model.friction), 1.0)
