"""Tips and edges of bodies: where they are on a grid, and the pressure that cells miss there.

At a sharp edge pressures rise like K / s^(1/2) with the distance s. An edge rounded by the radius r is in contact down
to the depth d = (3 pi K r / 2 E*)^(2/3) beyond the end of its flat part. The pressure of a half-plane that ends flat
and goes on as a parabola, (E* / 2 pi r) (2 (d c)^(1/2) + x ln((d^(1/2) + c^(1/2)) / (d^(1/2) - c^(1/2)))), c = d - x,
is K / s^(1/2) far away and has its peak, 1.8 K / d^(1/2), at x = d/3 (compare Dini, Sackfield and Hills, J. Mech.
Phys. Solids 53, 2005).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.body_specs import PunchSurface, Surface
from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

PEAK = 1.8
"""Largest pressure at a rounded edge over K / d^(1/2)."""

HARDLY_SEEN = 0.28
"""Least part of the pressure that cells may miss at a rounding in contact over less than one cell: the last cell has
less than the pressure K / s^(1/2) where it sees a part of the rounding."""

SLIPPING, SEEN = 2.0, 1.5
"""Energy that slip within a rounding dissipates, over mu^2 K^2 d/E* and (K_q / mu K)^3, per length of the edge, with
the singularity K_q of the shear traction: it slips up to d K_q / mu K from the edge, by K_q (d K_q / mu K)^(1/2) / E*.
Punches in plane strain have 1.2 to 1.7, round ones 0.8. From d = SEEN cells on, these see it."""

ALIGNED = 1e-6
"""Largest sine of the angle between a cylinder and an axis of the grid at which its ends run along cells."""

CYLINDER_END = 0.65
"""Factor K at the sharp end of a cylinder over p0 b^(1/2) of its line contact; 0.57 to 0.69 for lengths of 5 b to 40 b,
from runs."""


@dataclass(frozen=True)
class Edge:
    """A tip or an edge.

    radius: of its rounding, mm, 0 if it is sharp; near: cells from which it is in reach; covered: part of a cell that
    the flat part covers where it ends along cells, which tells K from their pressure; 1 where it crosses them.
    """

    radius: float
    near: BoolArray
    covered: float = 1.0

    def touches(self, pressure: FloatArray) -> bool:
        """Return whether the edge is in contact."""
        return bool(np.max(pressure, where=self.near, initial=0.0))

    def hidden_pressure(self, pressure: FloatArray, side: float, contact_modulus: float) -> float:
        """Return by how much (MPa) the pressure at the edge may exceed the largest one of cells of `side` (mm).

        0 where the edge is not in contact or is resolved, infinity where it is sharp.
        """
        edge = float(np.max(pressure, where=self.near, initial=0.0))
        if edge == 0.0 or self.radius == 0.0:
            return math.inf if edge else 0.0
        factor = self._largest_singularity(edge, side, contact_modulus)
        depth, shown = self._depth(factor, contact_modulus), float(pressure.max())
        least = HARDLY_SEEN * shown * min(max(2.0 - depth / side, 0.0), 1.0)
        return max(PEAK * factor / math.sqrt(depth) - shown, least)

    def cells_in_contact(self, pressure: FloatArray, side: float, contact_modulus: float) -> float:
        """Return over how many cells of `side` (mm) a rounding is in contact, infinity where it is out of reach."""
        largest = float(np.max(pressure, where=self.near, initial=0.0))
        if not (self.radius and largest):
            return math.inf
        depth = self._depth(_singularity(largest, side), contact_modulus)
        if depth >= side:  # then cells see the peak
            depth = (1.5 * math.pi / PEAK) * largest * self.radius / contact_modulus
        return depth / side

    def hidden_energy(self, pressure: FloatArray, side: float, contact_modulus: float, friction: float) -> float:
        """Return what slip within the rounding dissipates (mJ) as the shear grows up to gross slip there.

        0 where the edge is sharp, and does not slip, where it is not in contact, and where cells of `side` (mm) see it.
        """
        squares, depth = self.hidden_singularity(pressure, side, contact_modulus)
        return SLIPPING * friction**2 * squares * depth / contact_modulus

    def hidden_singularity(self, pressure: FloatArray, side: float, contact_modulus: float) -> tuple[float, float]:
        """Return the sum of K^2 (MPa^2 mm) times lengths (mm) along a rounding, and how far (mm) it is in contact.

        0 for both where the edge is sharp, where it is not in contact, and where cells of `side` (mm) see it.
        """
        at_edge = pressure[self.near].astype(np.float64)
        largest = float(at_edge.max(initial=0.0))
        if largest == 0.0 or self.radius == 0.0:
            return 0.0, 0.0
        depth = self._depth(_singularity(largest, side), contact_modulus)
        if depth >= SEEN * side:
            return 0.0, 0.0
        along = 1.0 if pressure.shape[1] == 1 else side  # energies of a line contact are per length
        return _singularity(1.0, side) ** 2 * float(np.square(at_edge).sum()) * along, depth

    def _largest_singularity(self, pressure: float, side: float, contact_modulus: float) -> float:
        """Return K from the largest pressure of the last cells, of which the last one may be covered in part.

        The mean of K / s^(1/2) over the part f of a cell is 2 K f^(1/2) of the whole one, over the next cell
        2 K ((1 + f)^(1/2) - f^(1/2)), both over side^(1/2). The distance s counts from a place within the depth of the
        contact in the rounding; of these places the one counts from which the cells tell least.
        """
        whole = _singularity(pressure, side)
        if self.covered == 1.0:
            return whole
        depth = self._depth(whole / _told(self.covered), contact_modulus)
        places = self.covered + depth / side * np.linspace(0.0, 1.0, 9)
        return whole / min(_told(1.0 - (-float(place)) % 1.0) for place in places)

    def _depth(self, factor: float, contact_modulus: float) -> float:
        """Return the depth d (mm) at the factor K."""
        return depth_in_rounding(factor, self.radius, contact_modulus)


def depth_in_rounding(factor: float, radius: float, contact_modulus: float) -> float:
    """Return how far (mm) the contact reaches into a rounding, d at the factor K."""
    return float((1.5 * math.pi * factor * radius / contact_modulus) ** (2.0 / 3.0))


def _singularity(pressure: float, side: float) -> float:
    """Return K from the pressure of the last cell, which is the mean of K / s^(1/2) over it."""
    return 0.5 * pressure * math.sqrt(side)


def edges(surfaces: Sequence[Surface], grid: Grid) -> tuple[Edge, ...]:
    """Return the tips and edges of the surfaces that lie on the grid."""
    found = (_edge(surface, grid) for surface in surfaces)
    return tuple(edge for edge in found if edge is not None and edge.near.any())


def rounding(surface: Surface) -> float | None:
    """Return the radius (mm) of the rounding at which a body ends, 0 if it ends sharply, None if it does not end."""
    if surface.kind == "cylinder":
        return None if surface.length is None else surface.end_radius or 0.0
    return surface.edge_radius if surface.kind == "punch" else None


def flat_part(punch: PunchSurface, *, line: bool) -> float:
    """Return the radius (mm) of the flat part of a punch; a square part counts as a circle of equal area.

    line: in line contact it is the half-width. A punch's rounding begins within its size, in line contact beyond it.
    """
    if line:
        return punch.half_width or 0.0
    if punch.radius is not None:
        return punch.radius - punch.edge_radius
    return ((punch.half_width or 0.0) - punch.edge_radius) * 2.0 / math.sqrt(math.pi)


def _edge(surface: Surface, grid: Grid) -> Edge | None:
    """Return the edge of a surface with the cells up to one from the end of its flat part."""
    x, y = grid.x[:, None] - surface.center[0], grid.y[None, :] - surface.center[1]
    side = math.hypot(grid.dx, grid.dy)
    if surface.kind == "cone":
        return Edge(0.0, np.hypot(x, y) <= side)
    radius = rounding(surface)
    if radius is None:
        return None
    return Edge(radius, _beyond(surface, x, y) >= -radius - side, _covered(surface, grid, radius))


def _covered(surface: Surface, grid: Grid, radius: float) -> float:
    """Return the part of the last cell that the flat part of a body covers, if it ends along cells, else 1.

    Of several ends that is the part from which the pressure of the cells tells least. radius: of the rounding, which
    begins outside of a line contact's flat part, else inside of the body.
    """
    ends: list[tuple[float, float, DoubleArray, float]] = []
    x, y = (surface.center[0], grid.x, grid.dx), (surface.center[1], grid.y, grid.dy)
    if surface.kind == "punch" and surface.half_width is not None:
        line = grid.shape[1] == 1
        reach = surface.half_width - (0.0 if line else radius)
        ends = [(reach, *x)] if line else [(reach, *x), (reach, *y)]
    elif surface.kind == "cylinder" and surface.length is not None:
        reach = 0.5 * surface.length - radius
        along = abs(math.cos(surface.axis)), abs(math.sin(surface.axis))
        ends = [(reach, *axis) for axis, other in ((x, along[1]), (y, along[0])) if other < ALIGNED]
    parts = [1.0]
    for reach, center, cells, side in ends:
        first = float(cells[0]) - 0.5 * side
        for place in ((center + reach - first) / side, (first - center + reach) / side + len(cells)):
            parts.append(1.0 - (-place) % 1.0)
    return min(parts, key=_told)


def _told(part: float) -> float:
    """Return what the larger pressure of the last two cells tells of K, over what it does where the last is covered.

    part: of the last cell that is covered.
    """
    return max(math.sqrt(part), math.sqrt(1.0 + part) - math.sqrt(part))


def _beyond(surface: Surface, x: DoubleArray, y: DoubleArray) -> DoubleArray:
    """Return the distance past the end of a body, negative inside the body."""
    if surface.kind == "cylinder":
        along = np.abs(math.cos(surface.axis) * x + math.sin(surface.axis) * y)
        return np.asarray(along - 0.5 * (surface.length or math.inf))
    assert surface.kind == "punch"  # no other body ends
    if surface.radius is not None:
        return np.asarray(np.hypot(x, y) - surface.radius)
    return np.asarray(np.maximum(np.abs(x), np.abs(y)) - (surface.half_width or math.inf))
