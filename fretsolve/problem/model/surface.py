"""Undeformed separation h(x, y) of the two surfaces, the sum of what the case lists under `surface`, and its edges.

Curved surfaces are replaced by their osculating paraboloids, h = r^2/2R, as in Hertz's theory. The two agree where the
half-space model holds: in contacts that are small against the radius. A negative radius is concave. Where a surface
ends (past a punch's edge, a cylinder's end, a height map's border, or in its holes) h = +inf: there is no material, and
never contact. A cell belongs to a surface if its centre does.

At a sharp edge pressures rise like K / s^(1/2) with the distance s. An edge rounded by the radius r is in contact down
to the depth d = (3 pi K r / 2 E*)^(2/3) beyond the end of its flat part. The pressure of a half-plane that ends flat
and goes on as a parabola, (E* / 2 pi r) (2 (d c)^(1/2) + x ln((d^(1/2) + c^(1/2)) / (d^(1/2) - c^(1/2)))), c = d - x,
is K / s^(1/2) far away and has its peak, 1.8 K / d^(1/2), at x = d/3 (compare Dini, Sackfield and Hills, J. Mech.
Phys. Solids 53, 2005).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.keys.body_specs import CylinderSurface, PunchSurface, Surface
from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, is_even_field

if TYPE_CHECKING:
    from fretsolve.problem.model.height_map import HeightMap


EDGE_SLACK = 1e-9
"""Distance past an edge, over the size of the body, at which a cell's centre still belongs to it. Without it, rounding
would decide which of two mirrored cells does."""


def separation(surfaces: Sequence[Surface], x: DoubleArray, y: DoubleArray) -> DoubleArray:
    """Return the separation (nx, ny) in mm at cell centres `x` (nx,), `y` (ny,) in mm.

    Raises FileError if a height map cannot be read, CaseError if it does not fit the case; the key of the latter starts
    with ``("surface", index)``.
    """
    total = np.zeros((x.size, y.size))
    for index, surface in enumerate(surfaces):
        from_x, from_y = x - surface.center[0], y - surface.center[1]
        column, row = from_x[:, None], from_y[None, :]
        match surface.kind:
            case "sphere":
                _add_paraboloid(total, column, row, surface.radius, surface.radius, 0.0)
            case "ellipsoid":
                _add_paraboloid(total, column, row, surface.radius_x, surface.radius_y, surface.angle)
            case "cylinder":
                _add_cylinder(total, column, row, surface)
            case "cone":
                total += math.tan(surface.angle) * np.hypot(column, row)
            case "punch" if surface.of_line:
                total += _line_punch(column, surface)
            case "punch":
                total += _punch(column, row, surface)
            case "heights":
                from fretsolve.problem.model.height_map import height_map_separation  # other surfaces do not need it

                total += height_map_separation(surface, from_x, from_y, ("surface", index, "heights"))
    return total


def is_mirrored(grid: Grid, separation: FloatArray) -> bool:
    """Return whether surfaces (nx, ny) on a grid are mirror images of themselves about y = 0, to the last bit."""
    return grid.ny % 2 == 0 and grid.y0 == 0.0 and is_even_field(separation)


def map_border(surfaces: Sequence[Surface], x: DoubleArray, y: DoubleArray) -> BoolArray | None:
    """Return the cells at which a height map ends within the grid, (nx, ny); None if there is no map.

    Raises as `separation`.
    """
    borders = [height_map.border(x - x0, y - y0) for (x0, y0), height_map in height_maps(surfaces)]
    return np.logical_or.reduce(borders) if borders else None


def map_spans(surfaces: Sequence[Surface]) -> list[tuple[float, float]]:
    """Return the sides (mm) of the height maps among the surfaces. Raises as `separation`."""
    return [height_map.span for _, height_map in height_maps(surfaces)]


def height_maps(surfaces: Sequence[Surface]) -> Iterator[tuple[tuple[float, float], HeightMap]]:
    """Read the height maps among the surfaces; yield their centres (mm) with them."""
    for index, surface in enumerate(surfaces):
        if surface.kind == "heights":
            from fretsolve.problem.model.height_map import load_height_map  # other surfaces do not need it

            yield surface.center, load_height_map(surface, ("surface", index, "heights"))


def _add_paraboloid(
    total: DoubleArray, x: DoubleArray, y: DoubleArray, radius_1: float, radius_2: float, angle: float
) -> None:
    """Add t1^2/2R1 + t2^2/2R2, axis 1 at `angle` from x; `x` (nx, 1) and `y` (1, ny) are broadcast."""
    cosine, sine = _direction(angle)
    half_1, half_2 = 0.5 / radius_1, 0.5 / radius_2
    total += (half_1 * cosine**2 + half_2 * sine**2) * x**2
    total += (half_1 * sine**2 + half_2 * cosine**2) * y**2
    twist = 2.0 * (half_1 - half_2) * sine * cosine
    if twist:
        total += twist * x * y


def _add_cylinder(total: DoubleArray, x: DoubleArray, y: DoubleArray, cylinder: CylinderSurface) -> None:
    """Add a cylinder, straight or crowned along its axis, endless or of a given `length`.

    With `end_radius` its ends fall away tangentially, by an arc of that radius over the last `end_radius` of each
    half-length; without, they are sharp.
    """
    _add_paraboloid(total, x, y, cylinder.crown_radius or math.inf, cylinder.radius, cylinder.axis)
    if cylinder.length is not None:
        cosine, sine = _direction(cylinder.axis)
        rounding = cylinder.end_radius or 0.0
        beyond = np.abs(cosine * x + sine * y) - (0.5 * cylinder.length - rounding)
        total += _rounded_edge(beyond, rounding, cylinder.length)


def _punch(x: DoubleArray, y: DoubleArray, punch: PunchSurface) -> DoubleArray:
    """Return a flat punch, circular or square with sides along x and y; its edge is rounded within its outline."""
    size = punch.radius or punch.half_width or 0.0  # the case has checked that one of both is given
    flat = size - punch.edge_radius
    if punch.radius is None:
        beyond = np.hypot(np.maximum(np.abs(x) - flat, 0.0), np.maximum(np.abs(y) - flat, 0.0))
    else:
        beyond = np.hypot(x, y) - flat
    return _rounded_edge(beyond, punch.edge_radius, size)


def _line_punch(x: DoubleArray, punch: PunchSurface) -> DoubleArray:
    """Return a punch that is flat over its half-width; beyond, h = d^2/2R at the distance d, or no material."""
    flat = punch.half_width or 0.0
    beyond = np.maximum(np.abs(x) - flat, 0.0)
    if punch.edge_radius:
        return beyond**2 / (2.0 * punch.edge_radius)
    return np.where(beyond > EDGE_SLACK * flat, np.inf, 0.0)


def _rounded_edge(beyond: DoubleArray, edge_radius: float, size: float) -> DoubleArray:
    """Return the arc re - sqrt(re^2 - d^2) at distances d `beyond` a flat, +inf for d > re; overwrites `beyond`."""
    outside = beyond > edge_radius + EDGE_SLACK * size
    d = np.clip(beyond, 0.0, edge_radius, out=beyond)
    if edge_radius > 0.0:
        d *= d / (edge_radius + np.sqrt(np.maximum(edge_radius**2 - d * d, 0.0)))
    d[outside] = np.inf
    return d


def _direction(angle: float) -> tuple[float, float]:
    """Return cosine and sine, exactly 0 along the axes, so that a turn by 90 degrees keeps mirror symmetry."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return (0.0 if abs(cosine) < 1e-15 else cosine), (0.0 if abs(sine) < 1e-15 else sine)


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
