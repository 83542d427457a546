"""Size of the potential contact area from the loads: what `size: auto` means, and what an error can advise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.errors import CaseError, KeyPath
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.model.materials import Compliances
from fretsolve.model.surface import separation
from fretsolve.model.terms import Terms

if TYPE_CHECKING:
    from fretsolve.case import Surface

Size = tuple[float, float]

MARGIN = 1.2
"""Sides of the area in units of the frictionless contact's extent about the centre."""

TRIAL_POINTS = 48
TRIAL_TOLERANCE = 1e-3
MOST_TRIALS = 60
MOST_SLENDER = 1e3
"""A contact that is longer than this many times its width counts as endless."""

FILLED = (0.55, 0.95)
"""A trial has the right size where the contact fills this part of it, in both directions."""


def contact_size(
    surfaces: Sequence[Surface],
    compliances: Compliances,
    loads: Sequence[LoadControl],
    center: Size = (0.0, 0.0),
    first: float = 1.0,
) -> Size:
    """Sides (mm) of an area about `center` that holds the frictionless contact under all of `loads`, with a margin.

    Found by solving on coarse grids that follow the contact; `first` (mm) is where the search starts. Raises
    CaseError where the contact always reaches the edge, as that of an endless cylinder does.
    """
    pressed = [load for load in dict.fromkeys(loads) if not load.forced[0] or load.values[0] > 0.0]
    extent = np.zeros(2)
    for load in pressed:
        extent = np.maximum(extent, _extent(surfaces, compliances, load, center, first))
    if not extent.any():
        raise CaseError(
            "auto finds no contact anywhere on the load path; give the size of the potential contact area",
            ("grid", "size"),
        )
    extent[extent == 0.0] = extent.max()
    return MARGIN * float(extent[0]), MARGIN * float(extent[1])


def first_trial(surfaces: Sequence[Surface], compliances: Compliances, loads: Sequence[LoadControl]) -> float:
    """Side (mm) to start the search with, of the contact's order of magnitude and proportional to the unit of length.

    It is that of the surface that has the smallest contact by itself.
    """
    return min(
        _own_size(surface, compliances.contact_modulus, loads, ("surface", index, surface.kind))
        for index, surface in enumerate(surfaces)
    )


def hertz_radius(load: LoadControl, radius: float, contact_modulus: float) -> float:
    """Of a sphere's contact under P or delta_z (mm), 0 without contact."""
    if load.forced[0]:
        return math.cbrt(0.75 * load.values[0] * radius / contact_modulus)
    return math.sqrt(radius * max(load.values[0], 0.0))


def _own_size(surface: Surface, contact_modulus: float, loads: Sequence[LoadControl], key: KeyPath) -> float:
    """A length (mm) of a surface and its contact."""
    match surface.kind:
        case "punch":
            return 2.0 * (surface.radius or surface.half_width or 0.0)
        case "heights":
            from fretsolve.model.height_map import load_height_map

            found = load_height_map(surface, key)
            return max(*found.span, *found.spacing)
        case "cone":
            slope = math.tan(surface.angle)
            radii = [_love_radius(load, slope, contact_modulus) for load in loads]
        case "ellipsoid":
            radii = [hertz_radius(load, abs(surface.radius_x), contact_modulus) for load in loads]
        case _:
            radii = [hertz_radius(load, abs(surface.radius), contact_modulus) for load in loads]
    return 2.0 * MARGIN * max(radii) or 1.0


def _love_radius(load: LoadControl, slope: float, contact_modulus: float) -> float:
    """Of a cone's contact (mm); Love 1939."""
    if load.forced[0]:
        return math.sqrt(2.0 * load.values[0] / (math.pi * contact_modulus * slope))
    return 2.0 * max(load.values[0], 0.0) / (math.pi * slope)


def _extent(
    surfaces: Sequence[Surface], compliances: Compliances, load: LoadControl, center: Size, first: float
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Sides (mm) of the least rectangle about `center` that holds the contact, zeros without contact."""
    size = np.array([first, first])
    refused: CaseError | None = None
    for _ in range(MOST_TRIALS):
        grid = Grid.from_size((TRIAL_POINTS, TRIAL_POINTS), (float(size[0]), float(size[1])), center)
        try:
            gap = separation(surfaces, grid.x, grid.y)
        except CaseError as error:  # a grid too small to meet the surface, or a surface that cannot be had at all
            refused = error
            size *= 2.0
            continue
        refused = None
        contact = _contact(gap, compliances, load, grid)
        if contact is None:
            size *= 2.0
            continue
        if not contact.any():
            return np.zeros(2)
        reach_x = float(np.abs(grid.x - center[0])[contact.any(axis=1)].max()) + 0.5 * grid.dx
        reach_y = float(np.abs(grid.y - center[1])[contact.any(axis=0)].max()) + 0.5 * grid.dy
        extent = 2.0 * np.array([reach_x, reach_y])
        filled = extent / size
        if (filled > FILLED[0]).all() and (filled < FILLED[1]).all():
            return extent
        size = np.where(filled >= FILLED[1], 1.6 * size, np.maximum(MARGIN * extent, 0.1 * size))
        if size.max() > MOST_SLENDER * size.min():
            break
    if refused is not None:
        raise refused
    raise CaseError(
        f"auto finds no size that holds the contact (tried up to {size.max():.3g} mm); give one, or a surface"
        " that ends",
        ("grid", "size"),
    )


def _contact(
    gap: np.ndarray[tuple[int, int], np.dtype[np.float64]], compliances: Compliances, load: LoadControl, grid: Grid
) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]] | None:
    """Cells in contact on a trial grid; None where the grid is too small to carry the load."""
    from fretsolve.elastic.operator import ElasticOperator  # as late as here: most cases are sized by a formula
    from fretsolve.solvers.normal import NormalSolver

    if not np.isfinite(gap).any():
        return None
    p, mx, my = load.imposed_resultant
    for mode, moment, centers in ((1, mx, grid.y), (2, my, grid.x)):
        if load.forced[0] and load.forced[mode] and not centers.min() <= moment / p <= centers.max():
            return None
    operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), compliances, Terms(False, False, False))
    pressure = np.zeros(grid.shape)
    NormalSolver(operator, grid).solve(gap, load, pressure, TRIAL_TOLERANCE, 200, np.zeros(3))
    return pressure > 0.0
