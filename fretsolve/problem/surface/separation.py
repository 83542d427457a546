"""Undeformed separation h(x, y) of the two surfaces, the sum of what the case lists under `surface`.

Curved surfaces are replaced by their osculating paraboloids, h = r^2/2R, as in Hertz's theory. The two agree where the
half-space model holds: in contacts that are small against the radius. A negative radius is concave. Where a surface
ends (past a punch's edge, a cylinder's end, a height map's border, or in its holes) h = +inf: there is no material, and
never contact. A cell belongs to a surface if its centre does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.keys.body_specs import CylinderSurface, PunchSurface, Surface
from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, is_even_field

if TYPE_CHECKING:
    from fretsolve.problem.surface.height_map import HeightMap


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
                from fretsolve.problem.surface.load_map import height_map_separation  # other surfaces do not need it

                total += height_map_separation(surface, from_x, from_y, ("surface", index, "heights"))
            case "roughness":
                from fretsolve.problem.surface.roughness import waves_of  # other surfaces do not need it

                total += waves_of(surface).heights(from_x, from_y)
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


def map_without_point(surfaces: Sequence[Surface], grid: Grid, contact: BoolArray) -> HeightMap | None:
    """Return a height map none of whose points lies in the contact (nx, ny), None if each map has one there."""
    for place, height_map in placed_maps(surfaces):
        found = []
        for axis, cells in enumerate((grid.x, grid.y)):
            side = float(cells[1] - cells[0]) if len(cells) > 1 else math.inf
            points = surfaces[place].center[axis] + height_map.points(axis)
            index = np.floor((points - cells[0]) / side + 0.5)
            found.append(np.unique(index[(index >= 0) & (index < len(cells))]).astype(int))
        if not contact[np.ix_(*found)].any():
            return height_map
    return None


def height_maps(surfaces: Sequence[Surface]) -> Iterator[tuple[tuple[float, float], HeightMap]]:
    """Read the height maps among the surfaces; yield their centres (mm) with them."""
    for place, height_map in placed_maps(surfaces):
        yield surfaces[place].center, height_map


def placed_maps(surfaces: Sequence[Surface]) -> Iterator[tuple[int, HeightMap]]:
    """Read the height maps among the surfaces; yield their places among these with them."""
    for index, surface in enumerate(surfaces):
        if surface.kind == "heights":
            from fretsolve.problem.surface.load_map import load_height_map  # other surfaces do not need it

            yield index, load_height_map(surface, ("surface", index, "heights"))


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
