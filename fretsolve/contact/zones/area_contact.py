"""Solve the increments of a contact on an area, and compute the sizes of its zones to a small part of a cell.

Straight segments join the points at which an edge crosses the links between cells, one in each square between four
centres. If no smooth front fits the fields, the square's cells are counted instead. A zone reaches as far as the
farthest of the points at which its edge crosses links along x, or along y. Each row of cells has such a point on either
side. The farthest point and its neighbours lie on a parabola, whose vertex may be between the rows' middles.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fretsolve.case.history import FEWEST_SPOT_CELLS, SPOTS
from fretsolve.contact.increment.increment import IncrementSolver, Solved
from fretsolve.contact.zones.edge_law import LEVER, LEVER_ALONG, LEVER_MOST, LEVER_SLANTING, EdgeLaw, ZoneFields
from fretsolve.contact.zones.zone_cells import MARGIN_CELLS, Front, ZoneCells
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.layout import may_have_spots
from fretsolve.result.state import Fields, Summary
from fretsolve.system.arrays import TINY, FloatArray, Vector


class Extent(NamedTuple):
    """Half of a zone's width along x and y, and the middle of that width (mm); without a zone 0 and NaN."""

    half_width_x: float = 0.0
    half_width_y: float = 0.0
    center_x: float = math.nan
    center_y: float = math.nan


class ZoneSize(NamedTuple):
    """The area (mm^2) of a zone and its extent; no zone by default."""

    area: float = 0.0
    extent: Extent = Extent()


def zone_sizes(fields: ZoneFields, grid: Grid, materials: Compliances) -> tuple[ZoneSize, ZoneSize]:
    """Return the sizes of contact and stick zone. If nothing slips, they are the same."""
    contact = fields.pressure > 0.0
    if not contact.any():
        return ZoneSize(), ZoneSize()
    zones = fields.zones(contact)
    part = ZoneCells.around(zones, grid)
    front = Front.of(part)
    edges = _Edges(part, front, EdgeLaw(part, front.links, fields, materials))
    found = [ZoneSize(edges.area(number), extent) for number, extent in enumerate(edges.extents())]
    if len(zones) == 1 and not fields.sticks:
        found.append(ZoneSize())
    return found[0], found[-1]


class _Edges:
    """The edges of zones in the n squares between centres that they cross.

    Shares are inside of each square's links, as `Front.starts`, (4, n); run and length: of the edge within each square,
    along x and y, (2, n), and in all, (n,) (mm); inset: of the edge in cells, by its direction there, (n,).
    """

    def __init__(self, part: ZoneCells, front: Front, law: EdgeLaw):
        self._part, self._front = part, front
        sides = np.array([[part.grid.dx], [part.grid.dy]])
        lever = np.full(front.count.shape, LEVER)
        self._shares = front.starts
        for _ in range(2):  # the first pass finds the edge's direction
            self._shares.ravel()[front.crossed] = law.shares(lever[front.square])
            self._run = np.abs(self._shares[1::2] - self._shares[::2]) * sides
            self._length = np.maximum(np.hypot(*self._run), TINY)
            cosine, sine = self._run / self._length
            lever = np.minimum(LEVER_ALONG + LEVER_SLANTING * (2.0 * cosine * sine), LEVER_MOST)
            if 1 in part.grid.shape:
                lever[:] = LEVER_ALONG
        self._inset = np.empty_like(lever)
        self._inset[front.square] = law.inset(lever[front.square])

    def area(self, number: int) -> float:
        """Return the area (mm^2) of a zone, from the squares between four centres: whole and crossed squares."""
        front, dx, dy = self._front, self._part.grid.dx, self._part.grid.dy
        own = slice(*np.searchsorted(front.zone, (number, number + 1)))
        shares, (run_x, run_y), count = self._shares[:, own], self._run[:, own], front.count[own]
        x, y = shares[::2] + shares[1::2]
        part_inside = np.where(count <= 2, 0.5 * x * y, 1.0 - 0.5 * (2.0 - x) * (2.0 - y))
        fits = ~(front.opposite[own] | np.isnan(part_inside))
        ones, twos, threes = np.bincount(count[fits], minlength=4)[1:].tolist()
        counted = (int(count.sum()) - (ones + 2 * twos + 3 * threes)) / 4.0
        area = (front.whole[number] + counted + part_inside[fits].sum()) * dx * dy
        inset = self._inset[own] * ((run_y * dx**2 + run_x * dy**2) / np.maximum(run_y * dx + run_x * dy, TINY))
        return float(max(area - _rim(self._length[own][fits], inset[fits], 0.25 * (ones - threes)), 0.0))

    def extents(self) -> list[Extent]:
        """Return the extent of each zone."""
        part, front = self._part, self._front
        links = front.links
        # the outer cells' places along their links, from the zone's middle
        row, column = np.divmod(links.outer, part.width)
        across, zone = links.along_y.view(np.uint8), links.zone
        middle, half = 0.5 * (part.last + part.first), 0.5 * (part.last - part.first)
        place = np.where(links.along_y, column, row) - middle[across, zone]
        # crossings within two cells of the zone's ends
        depth = (half + 1.0)[across, zone] - np.abs(place)
        near = (depth < 1.5).nonzero()[0]
        depth = depth[near]
        beyond = self._shares.ravel()[front.crossed[near]] - self._inset[front.square[near]] - depth
        # the farthest crossing of each row, towards -x, +x, -y, +y, in cells beyond the zone's outermost middles
        line = np.where(links.along_y, row, column)[near]
        towards = 4 * zone[near] + 2 * across[near] + (place[near] > 0.0)
        ends = np.full((4 * len(part.inside), max(part.inside.shape)), -math.inf)
        np.fmax.at(ends, (towards, line), beyond)
        if (unknown := np.isnan(beyond)).any():  # where no smooth edge fits
            unknown &= ends[towards, line] == -math.inf
            np.maximum.at(ends, (towards[unknown], line[unknown]), 0.5 - depth[unknown])
        farthest, found = _farthest(ends).reshape(-1, 4).tolist(), []
        dx, dy = part.grid.dx, part.grid.dy
        for number, (low_x, high_x, low_y, high_y) in enumerate(farthest):
            (half_x, half_y), (x, y) = half[:, number].tolist(), part.corner(number)
            found.append(
                Extent(
                    dx * (half_x + 0.5 * (low_x + high_x)),
                    dy * (half_y + 0.5 * (low_y + high_y)),
                    x + dx * (half_x + MARGIN_CELLS + 0.5 * (high_x - low_x)),
                    y + dy * (half_y + MARGIN_CELLS + 0.5 * (high_y - low_y)),
                )
            )
        return found


def _rim(length: FloatArray, inset: FloatArray, turns: float) -> float:
    """Return the area between the segments and a smooth front `inset` from them, which turns `turns` times in all.

    A curved front of length l bulges past its chord by l^3/12 times its curvature, here the mean one, and an inset d
    takes its length times d less half the angle turned times d^2.
    """
    total = float(length.sum())
    if total == 0.0:
        return 0.0
    taken = float((inset * length).sum())
    bulge = float((length**3).sum()) / (12.0 * total)
    return taken - 2.0 * math.pi * turns * (bulge + 0.5 * (taken / total) ** 2)


def _farthest(ends: FloatArray) -> FloatArray:
    """Return how far zones reach, (n,), from where they end in each row, (n, rows), -inf where not near their own end.

    A row and the rows beside it, which end no farther, lie on a parabola, whose vertex may be between their middles.
    The vertex of each such row counts, so that rounding does not decide between rows which end alike.
    """
    before, most, after = ends[:, :-2], ends[:, 1:-1], ends[:, 2:]
    with np.errstate(invalid="ignore"):
        back, ahead = most - before, most - after
        both = back + ahead
    curved = (back >= 0.0) & (ahead >= 0.0) & (both > 0.0) & (both < math.inf)
    farthest = most.copy()
    farthest[curved] += (ahead[curved] - back[curved]) ** 2 / (8.0 * both[curved])  # at a corner there is no more
    return np.asarray(farthest.max(axis=1))


def spot_counts(pressure: FloatArray) -> dict[str, int]:
    """Return the number of spots under a pressure, and of spots with few cells; cells touch at sides or corners."""
    from scipy import ndimage  # few cases may have several spots

    labels, count = ndimage.label(pressure > 0.0, structure=np.ones((3, 3)))
    cells = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    return dict(zip(SPOTS, (int(count), int(np.count_nonzero(cells < FEWEST_SPOT_CELLS))), strict=True))


def _radius_too(area: float) -> tuple[float, float]:
    return area, math.sqrt(area / math.pi)


class AreaContact:
    """A contact on an area with the solver of its increments."""

    def __init__(self, setup: ProblemSetup, solver: IncrementSolver):
        self.solver = solver
        self._setup = setup
        self._may_have_spots = may_have_spots(setup.case.effective())

    def rigid_start(self, fields: Fields, rigid: Vector) -> Vector:
        """Return the rigid displacements that the next increment counts from: the history's displacements `rigid`."""
        return rigid

    def with_displacements(self, summary: Summary, solved: Solved, increment: Increment) -> Summary:
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
        of_zone = ("area", "radius", *Extent._fields)
        names = (f"{zone}_{name}" for zone in ("contact", "stick") for name in of_zone)
        sizes: dict[str, Any] = dict(zip(names, values, strict=True))
        return sizes | (spot_counts(solved.pressure) if self._may_have_spots else {})
