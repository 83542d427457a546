"""Least errors of the radii, half-widths and middles of the contact and of the stick zone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.required_terms import Model
from fretsolve.result.state import State, Zone
from fretsolve.setup.closed_forms import spence_ratio
from fretsolve.simulation.error_bars.least_errors.unseen_slip import UnseenSlip
from fretsolve.simulation.error_bars.quantity_estimates import CONTACT, CONTACT_EXTENTS, STICK, STICK_EXTENTS, room
from fretsolve.simulation.error_bars.shear_path import UNSHEARED, ShearPath
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, IndexArray, vector_lengths

CONTACT_EDGE, MAP_EDGE, MAP_EDGE_LINE = 0.0075, 0.01, 0.06
"""Least error of the contact radius over h, and on height maps; that of a stick zone which fills the contact is the
same. MAP_EDGE_LINE is that of line contacts on waves, whose two edges nothing averages: waves of 4 to 16 cells had up
to 0.053."""

DOUBTFUL_CELL, DOUBTFUL_GAP, DOUBTFUL_PRESSURE = 0.5, 2, 0.03
"""Least error of the half-width of a line contact on waves over h for each place where it may be open or closed: gaps
of up to DOUBTFUL_GAP cells, troughs of a pressure below DOUBTFUL_PRESSURE times the largest one, and parts with less at
most. A contact on 24 cells bridged a gap of 1.3 h by a cell with 0.001 of the largest pressure, 0.7 h off."""

UNLIKE_EDGE = 0.4
"""Least error of the contact radius of unlike bodies in line contact, over e h. Slip changes the order of the pressure
at the edge from 1/2 by e = atan(beta mu)/pi with Dundurs' beta. Both edges may lie alike in their cells. On 24 to 64
points, with beta of .1 to .5 and friction of .05 to 1.5, errors were 0.25 to 0.41 times that where they are above
CONTACT_EDGE."""

FEW_CONTACT, FEW_CELLS, FEW_ORDER = 0.4, 1.5, 4
"""The same of contacts of few cells, over h, up to a radius of FEW_CELLS h; with the power FEW_ORDER of h/a less
beyond. In the first increments of a load path 97 of 100 errors were below 0.38, 0.2 and 0.06 h at radii of 1 to 1.5, 2
and 2.5 cells."""

CONTACT_END, STICK_END, SHARP_END = 0.03, 0.1, 0.5
"""The same of half-widths and middles over h, which depend on the ends of a zone alone."""

SHARP_EDGE = 0.1
"""Least error of radii over h where a body ends sharply, or by a rounding that fits into a cell: all grids round its
outline to their cells."""

PART_STICK, PART_STICK_LIKE, PART_STICK_ORDER = 0.45, 0.085, 1.5
"""Least error of the radius of a stick zone that does not fill the contact, over a (h/a)^PART_STICK_ORDER; that between
like bodies without ends, under one coefficient of friction."""

EARLIER_EDGE, BESIDE, BELOW_LARGEST = 0.25, 1.2, 0.12
"""Least error of the stick radius over h where it is within BESIDE h of the smallest one so far, or of that at the last
turn, and the shear is not at its largest share: an earlier edge lies so close that the fields cannot tell one from the
other. BELOW_LARGEST is that of all other radii where the shear is not at its largest share, or has turned: their edge
moves into cells that earlier loads have sheared."""

FEW_STICK, FEW_STICK_LIKE = 0.35, 0.22
"""Least error of the stick radius c over h^2/c, as the edge of a stick zone of few cells averages over few of them;
that on areas between like bodies as of PART_STICK_LIKE: 19 of 20 errors were below 0.07 (seeds 54 to 62), the largest
of torsions 0.18."""

UNSEEN_STICK = 1.2
"""Radius over h of a round stick zone that may exist although no cell sticks."""

OPENED_STICK = 0.5
"""Least error of the stick radius over h in line contacts of unlike bodies whose pressing lets no cell stick. A shear
opens a stick zone, beside the middle: of 11 random ones three had 0.45 to 0.62, and five less than 0.1. What the grids
show comes on top."""

NEAR_GROSS_SLIP = 0.3
"""Part of the friction limit left, below which the least error of the stick radius grows as it shrinks, where a body
ends: a flat punch slips everywhere at once."""

THIN_EDGE = 0.15
"""Least error of the stick radius over h where the slip annulus is thinner than a cell."""

AT_LIMIT = 3e-3
"""Distance from the friction limit, over it, within which a cell that sticks may as well slip. A load that comes back
to where a cycle about a mean has slipped before brings a whole ring of cells there, of which other increments let a
part slip, and a little more load all. So the least error of the stick radius is all that such cells add to it. They do
stick where the shear is held or goes back."""

HELD_EDGE = 0.25
"""Least error over h of the stick radius without such cells. It is added to what they add, since they are counted as
whole ones. Seven random cases had up to 0.17."""


@dataclass(frozen=True)
class ZoneErrors:
    """The least errors of the zones of a problem.

    side: the longer side of a cell (mm); ends: whether a body ends; uniform: whether the friction limit is everywhere
    the model's coefficient times the pressure; maps: whether there are height maps; unseen: slip that no cell shows.
    """

    model: Model
    side: float
    ends: bool
    uniform: bool
    maps: bool
    unseen: UnseenSlip

    def put_into(self, least: DoubleArray, state: State, outline: float, ratio: float, shear_path: ShearPath) -> None:
        """Put them into the `least` errors of `ESTIMATED`.

        outline: that of the outline of the contact (mm); ratio: side over contact radius.
        """
        outline = math.hypot(outline, self._waves(state))
        end = SHARP_END * self.side if outline >= SHARP_EDGE * self.side else outline
        least[CONTACT_EXTENTS] = math.hypot(CONTACT_END * self.side, end)
        least[CONTACT] = self._contact_radius(state.summary, outline)
        stick = self._stick_radius(state.summary, outline, ratio, shear_path)
        stick += self._by_steps(state.summary, shear_path)
        held, held_rows = self._held_at_limit(state) if shear_path.moves_on else (0.0, 0.0)
        least[STICK] = stick + held + HELD_EDGE * self.side if held else stick
        least[STICK_EXTENTS] = max(math.hypot(STICK_END * self.side, end, held_rows), least[STICK])

    def _contact_radius(self, summary: Summary, outline: float) -> float:
        """Return the least error (mm) of the contact radius, and of a stick radius that is as large."""
        small = FEW_CELLS * self.side
        few = small / max(summary.contact_radius, small) if summary.contact_radius else 0.0
        smallest = room(self.model) * (MAP_EDGE if self.maps else CONTACT_EDGE)
        edge = math.hypot(smallest * _slenderness(summary), FEW_CONTACT * few**FEW_ORDER, self._unlike_edge)
        return math.hypot(edge * self.side, outline)

    def _waves(self, state: State) -> float:
        """Return the least error (mm) of the outline of a line contact whose pressure has several peaks, 0 of others.

        Each part of it has that of a contact of few cells, too, if it has several.
        """
        if not (self.model.line and self.maps):
            return 0.0
        pressure, gap = state.fields.pressure[:, 0], state.fields.gap[:, 0]
        rises = np.diff(pressure, prepend=0.0, append=0.0) > 0.0
        if np.count_nonzero(rises[:-1] & ~rises[1:]) <= 1:
            return 0.0
        ends = np.flatnonzero(np.diff(pressure > 0.0, prepend=False, append=False))
        lengths = np.diff(ends)[::2] if len(ends) > 2 else np.array([])
        few = 2.0 * FEW_CELLS / np.maximum(lengths, 2.0 * FEW_CELLS)
        by_parts = float(np.linalg.norm(FEW_CONTACT * few**FEW_ORDER))
        places = _doubtful_places(pressure, gap, rises, ends)
        return math.hypot(MAP_EDGE_LINE, by_parts, DOUBTFUL_CELL * math.sqrt(places)) * self.side

    @property
    def _unlike_edge(self) -> float:
        """The least error of the contact radius over h by what slip does to the pressure at the edge."""
        if not (self.model.line and self.model.coupled):
            return 0.0
        return UNLIKE_EDGE * math.atan(abs(self.model.compliances.dundurs_constant) * self.model.friction) / math.pi

    def _stick_radius(self, summary: Summary, outline: float, ratio: float, shear_path: ShearPath) -> float:
        """Return the least error of the stick radius; outline: that of the contact."""
        if summary.stick_radius == 0.0 and self.model.friction > 0.0:
            # one less than a cell wide that is as long as the contact is in this proportion
            unseen = room(self.model) * UNSEEN_STICK * math.sqrt(_slenderness(summary)) * self.side
            return min(unseen, summary.contact_radius * shear_path.strained)
        thin = self.unseen.sheared_annulus(summary, shear_path.memory.slipping)
        unseen = room(self.model) * max(thin - (summary.contact_radius - summary.stick_radius), 0.0)
        width = self.unseen.annulus(summary)
        if 0 < summary.stick_cells < summary.contact_cells or width:
            like = self.uniform and not (self.model.coupled or self.ends)
            part = PART_STICK_LIKE if like else PART_STICK
            if self.ends:
                part *= max(NEAR_GROSS_SLIP / shear_path.left, 1.0)
            part *= ratio**PART_STICK_ORDER * math.sqrt(_slenderness(summary)) * summary.contact_radius
            few = FEW_STICK_LIKE if like and not self.model.line else FEW_STICK
            few *= self.side * min(self.side / (summary.stick_radius or self.side), 1.0)
            earlier = self._earlier_edge(summary, shear_path) if like else self._opened(summary, shear_path)
            return math.hypot(outline, part, few, earlier, self._thin_annulus(summary), unseen) + width
        return math.hypot(self._contact_radius(summary, outline), unseen)

    def _by_steps(self, summary: Summary, shear_path: ShearPath) -> float:
        """Return by how much the stick radius (mm) of the run's increments differs from that of a steady change.

        Where load and shear change together, each increment of the run shears the whole contact that it has pressed.
        """
        if self.ends:
            return 0.0
        memories = shear_path.memory, shear_path.at_once
        steady, stepped = (self.unseen.stick_share(memory.slipping) for memory in memories)
        return room(self.model) * abs(steady - stepped) * summary.contact_radius

    def _earlier_edge(self, summary: Summary, shear_path: ShearPath) -> float:
        """Return the least error (mm) of a stick radius by earlier edges of the stick zone."""
        if not shear_path.is_below_largest:
            return BELOW_LARGEST * self.side if shear_path.turned > UNSHEARED else 0.0
        beside = shear_path.edges.apart(summary.stick_radius) < BESIDE * self.side
        return (EARLIER_EDGE if beside else BELOW_LARGEST) * self.side

    def _opened(self, summary: Summary, shear_path: ShearPath) -> float:
        """Return the least error (mm) of a stick radius that shear has opened between unlike bodies, 0 of others."""
        if not (self.model.line and self.model.coupled and shear_path.length > UNSHEARED):
            return 0.0
        return OPENED_STICK * self.side if spence_ratio(self.model) * summary.contact_radius < self.side else 0.0

    def _thin_annulus(self, summary: Summary) -> float:
        """Return the least error (mm) of a stick radius that leaves an annulus thinner than cells; 0 of others."""
        width = summary.contact_radius - summary.stick_radius
        return THIN_EDGE * self.side if width < self.side else 0.0

    def _held_at_limit(self, state: State) -> tuple[float, float]:
        """Return what cells that stick next to the friction limit add to the stick radius and its half-widths (mm).

        0 where friction varies, whose limit is not asked for here.
        """
        sticks = state.fields.zone == Zone.STICK
        if not (self.uniform and self.model.may_slip and sticks.any()):
            return 0.0, 0.0
        limit = (1.0 - AT_LIMIT) * self.model.friction * state.fields.pressure
        surely = sticks & (vector_lengths(state.fields.shear) < limit)
        part = float(np.count_nonzero(surely) / np.count_nonzero(sticks))
        left = part if self.model.line else math.sqrt(part)
        rows = max(_span(sticks.any(axis)) - _span(surely.any(axis)) for axis in (0, 1))
        known = room(self.model)
        return known * (1.0 - left) * state.summary.stick_radius, 0.5 * known * rows * self.side


def _doubtful_places(pressure: FloatArray, gap: FloatArray, rises: BoolArray, ends: IndexArray) -> int:
    """Return the number of places where a line contact on waves may be open or closed.

    rises: whether the pressure rises into each cell, and beyond the last one; ends: where its parts begin and end.
    """
    faint = DOUBTFUL_PRESSURE * pressure.max()
    troughs = ~rises[:-1] & rises[1:] & (pressure > 0.0) & (pressure < faint)
    parts = (pressure[start:end] for start, end in zip(ends[::2], ends[1::2], strict=True))
    gaps = (gap[start:end] for start, end in zip(ends[1:-1:2], ends[2::2], strict=True))
    weak = sum(part.max() < faint for part in parts)
    narrow = sum(len(one) <= DOUBTFUL_GAP and bool(np.isfinite(one).all()) for one in gaps)  # holes stay open
    return int(np.count_nonzero(troughs) + weak + narrow)


def _span(rows: BoolArray) -> int:
    """Return how many rows there are from the first true one to the last."""
    places = np.flatnonzero(rows)
    return int(places[-1] - places[0]) + 1 if places.size else 0


def _slenderness(summary: Summary) -> float:
    """Return the longer over the shorter half-width of the contact."""
    widths = summary.contact_half_width_x, summary.contact_half_width_y
    return max(widths) / min(widths) if min(widths) > 0.0 else 1.0
