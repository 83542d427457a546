"""Least errors by the cells, of side h, for what no coarse run need show: errors that agree by chance on all grids."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import EXTENTS
from fretsolve.problem.model.required_terms import Model
from fretsolve.problem.setup.closed_forms import spence_ratio
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.surface.edges import Edge, edges, rounding
from fretsolve.result.state import ESTIMATED, State, Summary, Zone
from fretsolve.system.arrays import DoubleArray, grown, vector_lengths

Shares = tuple[float, float, float]

TORQUE_ARM = 1.5
"""Shear traction at the edge of a round punch under a torque, over the traction under the force torque / radius."""

TURNS_SEEN = 2
"""Added to the number of increments of a stage that turns the shear: few increments err less than by first order."""


@dataclass(frozen=True)
class ShearPath:
    """The path of the shear so far, in parts of what friction carries: forces, and the torque over its arm.

    at: where it is, (3,); way: in the last increment, (3,); largest: how far from 0 it has been, at most 1; length: of
    all ways; turned: ways across the direction of the shear, each over TURNS_SEEN more than its stage's increments.
    """

    at: Shares = (0.0, 0.0, 0.0)
    way: Shares = (0.0, 0.0, 0.0)
    largest: float = 0.0
    length: float = 0.0
    turned: float = 0.0

    def after(self, summary: Summary, carried: float, count: int) -> ShearPath:
        """Return the path after an increment; carried: the force (N) that friction carries; count: of its stage."""
        if carried <= 0.0:
            return ShearPath(largest=self.largest, length=self.length, turned=self.turned)
        arm = torque_arm(summary)
        at = summary.Qx / carried, summary.Qy / carried, summary.Mz / (arm * carried) if arm else 0.0
        way = at[0] - self.at[0], at[1] - self.at[1], at[2] - self.at[2]
        share, length, before = math.hypot(*at), math.hypot(*way), math.hypot(*self.at)
        along = sum(a * b for a, b in zip(way, self.at, strict=True)) / before if before else length
        across = math.sqrt(max(length**2 - along**2, 0.0))
        turned = self.turned + across / (count + TURNS_SEEN)
        return ShearPath(at, way, max(self.largest, min(share, 1.0)), self.length + length, turned)

    @property
    def left(self) -> float:
        """The part of the friction limit that is left, 0 where the bodies slide."""
        return max(1.0 - math.hypot(*self.at), 0.0)

    @property
    def moves_on(self) -> bool:
        """True if the last increment moved the shear farther from 0, by more than round-off."""
        return sum(a * b for a, b in zip(self.at, self.way, strict=True)) > 1e-5


def torque_arm(summary: Summary) -> float:
    """Return the arm (mm) by which a torque counts like a force."""
    return summary.contact_radius / TORQUE_ARM


ROUNDED_CELLS = 2.0
"""Cells over which a rounding is in contact, up to which all grids round the body's outline to their cells."""


@dataclass(frozen=True)
class Cells:
    """The cells of a problem.

    side: the longer one of a cell (mm); edges: tips and edges of the surfaces; sharp: whether a body ends within a
    cell; flattening: pressure (MPa) that would flatten what the cells do not see of height maps; ridges: pressure (MPa)
    of their ridges beyond the pressure of cells; maps: whether there are any; uniform: whether the friction limit is
    everywhere the model's coefficient times the pressure.
    """

    model: Model
    side: float
    edges: tuple[Edge, ...]
    sharp: bool
    flattening: float
    ridges: float
    maps: bool
    uniform: bool

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
        """Return the cells with the holes of a height map that the contact reaches: there a body ends sharply, too."""
        if not self.maps or np.isfinite(state.fields.gap).all():
            return self
        edge = Edge(0.0, grown(~np.isfinite(state.fields.gap)))
        return replace(self, sharp=True, edges=(*self.edges, edge)) if edge.touches(state.fields.pressure) else self

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


ROUGH_PEAK = 3.0
"""Largest pressure that unresolved heights add, over the root mean square one that flattens them: sqrt(2 ln n) for n
independent Gaussian peaks in contact, here a hundred."""

SLIP_MEETS = 1.3
"""By how much slip towards a stick zone that no cell sees raises the largest pressure at most, over mu beta p (1 +
ln(h/c)) with the radius c of that zone: it was up to 1.2 times that without the logarithm."""

ANNULUS = 0.1
"""Least relative error of what an increment dissipates over (h/w)^(3/2) (h/a)^(1/2) with the width w of the slip
annulus, a cell at least: its edge may lie anywhere in the cells, which is averaged around the contact, so that line
contacts lack the second factor."""

UNSEEN = 0.21
"""Energy that slip within a cell of the edge dissipates on the way to gross slip, over (mu P)^2 S/a (h/a)^3 with the
tangential compliance S: by Mindlin 27/144 of a sphere and by Cattaneo 8/12 pi of a cylinder, per length."""


def hidden_pressure(cells: Cells, state: State) -> float:
    """Return how much pressure (MPa) cells may hide; infinity where a sharp tip or edge is in contact."""
    pressure, summary, modulus = state.fields.pressure, state.summary, cells.model.compliances.contact_modulus
    if not summary.max_pressure:
        return 0.0
    at_edges = max((edge.hidden_pressure(pressure, cells.side, modulus) for edge in cells.edges), default=0.0)
    return ROUGH_PEAK * cells.flattening + cells.ridges + at_edges + _where_slip_meets(cells, summary)


def _where_slip_meets(cells: Cells, summary: Summary) -> float:
    """Return by how much slip towards a stick zone that no cell sees may raise the largest pressure.

    The shear traction mu p turns round there, which raises p between dissimilar bodies with the logarithm of the
    distance.
    """
    stick = spence_ratio(cells.model) * summary.contact_radius
    if not (cells.mismatch and stick):
        return 0.0
    if cells.model.line:  # whose stick zone has two edges however it is sheared
        stick = min(stick, summary.stick_radius or stick)
    rise = 1.0 + math.log(cells.side / stick) if stick < cells.side else cells.side / stick
    return SLIP_MEETS * cells.model.friction * cells.mismatch * rise * summary.max_pressure


def hidden_in_annulus(cells: Cells, summary: Summary) -> float:
    """Return the least error (mJ) of what an increment dissipates by the width of its slip annulus in cells."""
    around = 1.0 if cells.model.line else math.sqrt(min(cells.side / (summary.contact_radius or cells.side), 1.0))
    return ANNULUS * _cells_share(cells, summary) * around * summary.work


def unseen_energy(cells: Cells, state: State, load: float, radius: float, path: ShearPath) -> float:
    """Return the energy (mJ) that no cell shows, up to now; load: largest P (N); radius: of the contact (mm).

    An annulus that is narrower than a cell dissipates with the third power of its width, which is a third of a sphere's
    radius, half of a cylinder's, times the part of the friction limit to which it is sheared. Pressing dissimilar
    bodies slips once. Roundings that fit into a cell have more.
    """
    share, ways = (1.0, max(path.length, 1.0)) if cells.mismatch else (path.largest, path.length)
    if not (radius and share):
        return 0.0
    friction, modulus = cells.model.friction, cells.model.compliances.contact_modulus
    pair, order = cells.model.compliances, 2.0 if cells.model.line else 3.0
    compliance = pair.A if cells.model.line else pair.tangential / radius  # energies of a line are per length
    annulus = UNSEEN * math.pow(min(cells.side / radius, share / order), 3) * (friction * load) ** 2 * compliance
    annulus *= _cells_share(cells, state.summary)
    edges = sum(edge.hidden_energy(state.fields.pressure, cells.side, modulus, friction) for edge in cells.edges)
    return (annulus / share + share**2 * edges) * ways


def _cells_share(cells: Cells, summary: Summary) -> float:
    """Return (h/w)^(3/2) with the width w of the slip annulus, 1 where that is less than a cell."""
    width = max(summary.contact_radius - summary.stick_radius, cells.side)
    return math.pow(cells.side / width, 1.5)


SUM, TORSION, MOMENT = 0.02, 0.2, 0.02
"""Least relative errors over (h/a)^2 of forces, displacements and pressures, of a torque and its turn, which act by
their arm near the edge, and of moments over P a or Q a with their tilts, which add up tractions of opposite effect."""

CONTACT_EDGE, FEW_CELLS, STICK_EDGE, ROW = 0.01, 0.7, 0.15, 0.1
"""Least errors over h of the contact radius, of one of few cells over (h/a)^2, of a stick radius, and of half-widths
and middles, which depend on the last row of cells."""

OUTLINE, OUTLINE_ROW = 0.13, 0.5
"""Least errors over h of radii, and of half-widths and middles, where a body ends, whose outline all grids round to
their cells. Loads, displacements and energies have the relative error of the radius, moments and turns with it."""

THIN = 0.1
"""Least relative error over h/a of forces and displacements where an annulus of no width slips, times 3 for torques and
turns: the shear traction rises towards an edge that cells place to a part of one. It falls with the width."""

UNSEEN_STICK = 1.2
"""Radius over h of a round stick zone that may exist although no cell sticks."""

AT_LIMIT = 3e-3
"""Distance from the friction limit, over it, within which a cell that sticks may as well slip. A load that comes back
to where a cycle has slipped before brings a whole ring of cells there."""

TURNED = 0.03
"""Least relative error of tangential values over `ShearPath.turned`: few increments and twice as many turn alike."""


def floors(cells: Cells, state: State, largest: Mapping[str, float], path: ShearPath, in_annuli: float) -> DoubleArray:
    """Return the least errors of `ESTIMATED`, in their order; a pressure at a sharp edge has an infinite error.

    largest: largest absolute values so far; in_annuli: least error (mJ) of all energy by slip annuli.
    """
    summary, cells = state.summary, cells.reached_by(state)
    # Where the contact has opened, the largest radius counts: its errors remain.
    radius = summary.contact_radius or largest["contact_radius"]
    if not radius:
        return np.zeros(len(ESTIMATED))
    ratio = min(cells.side / radius, 1.0)
    rounded = cells.rounded(state)
    outline = OUTLINE * rounded * ratio
    thin = THIN * ratio / (1.0 + (2.0 * (radius - summary.stick_radius) / cells.side) ** 3)
    sums = _of_sums(cells, largest, path, (radius, outline, thin if path.length else 0.0))
    found = {**sums, **_of_zones(cells, state, path, rounded)}
    found["max_pressure"] = SUM * ratio**2 * largest["max_pressure"] + hidden_pressure(cells, state)
    unseen = unseen_energy(cells, state, largest["P"], radius, path)
    last = math.hypot(*path.way) / path.length if path.length else 0.0
    known = outline + (in_annuli / summary.work_total if summary.work_total else 0.0)
    found["work_total"] = known * summary.work_total + unseen
    found["work"] = known * summary.work + last * unseen
    least = np.array([found[name] for name in ESTIMATED])
    if cells.flattening and summary.max_pressure:  # bodies that touch at their peaks alone are unknown
        heights = min(cells.flattening / summary.max_pressure, 1.0) ** 2
        least += heights * np.array([abs(getattr(summary, name)) for name in ESTIMATED])
    return least


def _of_sums(
    cells: Cells, largest: Mapping[str, float], path: ShearPath, edge: tuple[float, float, float]
) -> dict[str, float]:
    """Return the least errors of loads, displacements and turns.

    edge: radius of the contact (mm), its relative error where a body ends, and the relative error of a thin annulus.
    """
    radius, outline, thin = edge
    ratio = min(cells.side / radius, 1.0)
    part, twist = outline + SUM * ratio**2, outline + TORSION * ratio**2 + 3.0 * thin
    sheared = part + TURNED * path.turned + thin
    moment = outline + MOMENT * ratio ** (1.5 if cells.model.line else 2.0)
    force, motion = (math.hypot(largest[f"{name}x"], largest[f"{name}y"]) for name in ("Q", "delta_"))
    tilt = largest["delta_z"] / radius
    if cells.model.line:  # free constant in the approach: tilt of a cylinder under the moment P a
        tilt = 4.0 * largest["P"] / (math.pi * cells.model.compliances.contact_modulus * radius)
    return {
        "P": part * largest["P"],
        "delta_z": part * largest["delta_z"],
        **dict.fromkeys(("Qx", "Qy"), sheared * force),
        **dict.fromkeys(("delta_x", "delta_y"), sheared * motion),
        **{name: moment * largest["P"] * radius + outline * largest[name] for name in ("Mx", "My")},
        **{name: moment * tilt + outline * largest[name] for name in ("phi_x", "phi_y")},
        "Mz": twist * largest["Mz"] + moment * force * radius,
        "phi_z": twist * largest["phi_z"] + moment * motion / radius,
    }


def _of_zones(cells: Cells, state: State, path: ShearPath, rounded: float) -> dict[str, float]:
    """Return the least errors (mm) of the zones; rounded: how much of the errors where a body ends counts."""
    summary, side = state.summary, cells.side
    body = OUTLINE * rounded
    few = min(side / summary.contact_radius, 1.0) ** 2 if summary.contact_radius else 0.0
    contact = (CONTACT_EDGE + FEW_CELLS * few + body) * side
    stick = _of_stick_radius(cells, state, path)
    if summary.stick_cells > 0:
        stick = math.hypot(stick + body * side, contact)
        stick += _held_at_limit(cells, state) if path.moves_on else 0.0
    row = (ROW + (OUTLINE_ROW - ROW) * rounded) * side
    extents = {"contact": row, "stick": max(row, stick)}
    return {
        "contact_radius": contact,
        "stick_radius": stick,
        **{name: extents[name.partition("_")[0]] for name in EXTENTS},
    }


def _of_stick_radius(cells: Cells, state: State, path: ShearPath) -> float:
    """Return the least error (mm) of the stick radius by the place of its edge in the cells.

    By Cattaneo and Mindlin the stick zone is the contact under the part of the load that the shear leaves. So a zone
    that no cell shows, or an annulus around it, is known by the part of the friction limit that is left.
    """
    summary, side, model = state.summary, cells.side, cells.model
    if not (model.may_slip and model.friction):
        return 0.0
    order = 1.0 / 2.0 if model.line else 1.0 / 3.0
    if summary.stick_cells == 0:
        widths = sorted((summary.contact_half_width_x, summary.contact_half_width_y))
        slender = 1.0 if model.line or not widths[0] else widths[1] / widths[0]
        return min(UNSEEN_STICK * math.sqrt(slender) * side, math.pow(path.left, order) * summary.contact_radius)
    share = min(math.pow(1.0 - path.largest, order), spence_ratio(model))
    thin = summary.contact_radius - summary.stick_radius < 0.5 * side
    annulus = min((1.0 - share) * summary.contact_radius, side) if thin else 0.0
    return max(annulus, STICK_EDGE * side if summary.stick_cells < summary.contact_cells else 0.0)


def _held_at_limit(cells: Cells, state: State) -> float:
    """Return what cells that stick next to the friction limit add to the stick radius (mm), 0 where friction varies."""
    sticks = state.fields.zone == Zone.STICK
    if not (cells.uniform and sticks.any()):
        return 0.0
    limit = (1.0 - AT_LIMIT) * cells.model.friction * state.fields.pressure
    surely = sticks & (vector_lengths(state.fields.shear) < limit)
    part = float(np.count_nonzero(surely) / np.count_nonzero(sticks))
    return (1.0 - (part if cells.model.line else math.sqrt(part))) * state.summary.stick_radius
