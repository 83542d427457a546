"""Warn of contacts, stick zones, edges and heights that the cells do not resolve."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from fretsolve.case.dimensions import cell_counts
from fretsolve.case.keys.surface_specs import PunchSurface
from fretsolve.errors import dotted
from fretsolve.model.edges import CYLINDER_END, depth_in_rounding, rounding
from fretsolve.setup.contact_size import AREA_MARGIN, room_for_coarse_runs
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.reference.line import HertzLine


FEWEST_CELLS, FEWEST_STICK_CELLS, FEWEST_END_CELLS = 20, 3, 2
"""Cells across the contact below which results are off by per cents; across the stick zone for its size to count; in
the contact with the rounding of an end, with which the pressure there is 5 % too low."""

STEEPEST_MAP = 1.0
"""Root mean square slope of a height map above which something is wrong, rather than rough."""


def about_resolution(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a contact or a stick zone that few cells lie across."""
    cells = cells_across(setup)
    if cells is not None and cells < FEWEST_CELLS:
        yield (
            f"grid.points: only {_in_cells(cells)} cells across the contact;"
            f" {FEWEST_CELLS} or more are needed for errors below a few per cent"
        )
    stick = setup.closed_forms.smallest_stick
    across = 2.0 * stick.value / max(setup.grid.dx, setup.grid.dy) if stick is not None else math.inf
    if stick is not None and across < FEWEST_STICK_CELLS:
        yield (
            f"grid.points: the stick zone shrinks to {_in_cells(across)} cells across in stage {stick.stage + 1}"
            f" ({stick.source}: c = {stick.value:.3g} mm); its size is reliable from {FEWEST_STICK_CELLS} cells on"
        )


def about_edges(setup: ProblemSetup) -> Iterator[str]:
    """Warn of sharp ends, and of roundings that cells do not resolve."""
    side = max(setup.grid.dx, setup.grid.dy)
    if (line := cylinder_contact(setup)) is not None:
        yield from about_end(setup, line)
    for place, surface in enumerate(setup.case.surface):
        radius = rounding(surface)
        if surface.kind == "cylinder" and surface.crown_radius and setup.closed_forms.largest is not None:
            continue  # the contact ends before the cylinder
        if surface.kind == "cylinder" and radius == 0.0:
            key = setup.case.source.typed(("surface", place, "cylinder", "length"))
            yield (
                f"{dotted(key)}: the ends of the cylinder are sharp, so that the pressure there is infinite and the"
                " largest one depends on the grid; end_radius rounds them"
            )
        if radius and radius < side:
            name = "end_radius" if surface.kind == "cylinder" else "edge_radius"
            key = setup.case.source.typed(("surface", place, surface.kind, name))
            yield (
                f"{dotted(key)}: the rounding of {radius:.3g} mm fits into a cell of {side:.3g} mm, so that the edge"
                " counts as sharp: the largest pressure is much too small"
            )
        elif radius and surface.kind == "punch" and len(setup.case.surface) == 1:
            yield from about_punch(setup, surface, radius)


def about_punch(setup: ProblemSetup, punch: PunchSurface, radius: float) -> Iterator[str]:
    """Warn of a punch whose contact hardly enters the rounding of its edge."""
    load = max((forces.get("P", 0.0) for forces in setup.closed_forms.loads), default=0.0)
    side, size = max(setup.grid.dx, setup.grid.dy), punch.radius or punch.half_width or 0.0
    flat = size if setup.model.line else (size - radius) * (1.0 if punch.radius else 2.0 / math.sqrt(math.pi))
    if load <= 0.0 or flat <= 0.0:
        return
    # near the edge of the flat part the pressure is that of a rigid flat punch, K / s^(1/2) at the distance s
    factor = load / (math.pi * math.sqrt(2.0 * flat) * (1.0 if setup.model.line else 2.0 * flat))
    depth = depth_in_rounding(factor, radius, setup.model.compliances.contact_modulus)
    if depth < FEWEST_END_CELLS * side:
        key = setup.case.source.typed(("surface", 0, "punch", "edge_radius"))
        yield (
            f"{dotted(key)}: the contact reaches about {depth:.2g} mm into the rounding of the edge, and cells are"
            f" {side:.2g} mm: the largest pressure, there, depends on the grid"
        )


def about_end(setup: ProblemSetup, contact: HertzLine) -> Iterator[str]:
    """Warn of the ends of a cylinder that reaches the grid's edge, or whose rounding the contact hardly enters."""
    surface, grid = setup.case.surface[0], setup.grid
    if surface.kind != "cylinder":
        return
    if surface.length is None:
        key = setup.case.source.typed(("surface", 0, "cylinder"))
        yield (
            f"{dotted(key)}: it has no ends, so that it ends at the grid's edge, where the pressure is infinite and"
            " the largest one depends on the grid; plane: strain has no ends, length ends it within the grid"
        )
        return
    radius, modulus = surface.end_radius or 0.0, setup.model.compliances.contact_modulus
    cell = math.hypot(grid.dx * math.cos(surface.axis), grid.dy * math.sin(surface.axis))
    depth = depth_in_rounding(CYLINDER_END * contact.max_pressure * math.sqrt(contact.half_width), radius, modulus)
    if radius >= max(grid.dx, grid.dy) and depth < FEWEST_END_CELLS * cell:
        key = setup.case.source.typed(("surface", 0, "cylinder", "end_radius"))
        yield (
            f"{dotted(key)}: the contact reaches about {depth:.2g} mm into the rounding of the ends, and"
            f" cells are {cell:.2g} mm along the cylinder: the largest pressure, there, depends on the grid"
        )


def cylinder_contact(setup: ProblemSetup) -> HertzLine | None:
    """Return Hertz's line contact of a straight cylinder on an area; one without ends ends with the grid."""
    if setup.model.line:
        return None
    surface, grid = setup.case.surface[0], setup.grid
    endless = None
    if surface.kind == "cylinder" and surface.length is None and setup.case.grid.size is not None:
        along = (abs(math.cos(surface.axis)), abs(math.sin(surface.axis)))
        endless = min(side / part for side, part in zip(grid.size, along, strict=True) if part > 1e-9)
    return setup.closed_forms.cylinder(endless)


def about_heights(setup: ProblemSetup) -> Iterator[str]:
    """Warn of height maps that are too steep, or finer than the cells, if flattening what these miss takes a part of
    the pressure."""
    grid, heights = setup.grid, setup.heights()
    if (slope := heights.slope()) > STEEPEST_MAP:
        yield (
            f"surface: the root mean square slope of the height map is {slope:.2g}: half-spaces and linear elasticity"
            " hold for slopes small against 1; are unit and spacing right, and missing points nan?"
        )
    if (needed := heights.flattening_pressure((grid.dx, grid.dy))) > 0.0:
        resolving = cell_counts(heights.resolving_points(grid.size, grid.shape))
        coarse = " as far as the map does, which has few points per wave itself" if heights.too_coarse() else ""
        yield (
            f"grid.points: {cell_counts(grid.shape)} cells miss waves of the height map that take {needed:.3g} MPa to"
            f" flatten; {resolving} points would resolve them{coarse}"
        )


def cells_across(setup: ProblemSetup) -> float | None:
    """Return the cells across the contact where it is largest, along the axis with fewer; None without a closed form.

    Cells may be as slender as the contact.
    """
    grid, surface, hertz = setup.grid, setup.case.surface[0], setup.closed_forms.largest
    if hertz is not None:
        cosine, sine = math.cos(hertz.angle), math.sin(hertz.angle)
        along = (math.hypot(grid.dx * cosine, grid.dy * sine), math.hypot(grid.dx * sine, grid.dy * cosine))
        return min(2.0 * axis / cell for axis, cell in zip(hertz.semi_axes, along, strict=True))
    width = setup.closed_forms.contact_width(max(grid.size))
    if width is None:
        if setup.case.grid.size is not None:
            return None
        bars = setup.case.solver.error_bars
        rooms = ((cells, room_for_coarse_runs(cells) if bars else 1.0) for cells in grid.shape[: len(grid.axes)])
        return min(cells / (AREA_MARGIN * room) for cells, room in rooms)
    if surface.kind == "cylinder":
        return width / math.hypot(grid.dx * math.sin(surface.axis), grid.dy * math.cos(surface.axis))
    return width / max(grid.dx, grid.dy)


def warning_of_result(setup: ProblemSetup, contact_cells: DoubleArray) -> str | None:
    """Warn if the contact had too few cells in all increments, where no closed form could warn before the run."""
    most, needed = int(contact_cells.max(initial=0)), math.ceil(0.25 * math.pi * FEWEST_CELLS**2)
    needed = FEWEST_CELLS if setup.model.line else needed
    if not len(contact_cells) or cells_across(setup) is not None or most >= needed:
        return None
    like = "" if setup.model.line else f", as many as a round contact of {FEWEST_CELLS} cells across has"
    return (
        f"grid.points: the contact has at most {most} cell{'s' * (most != 1)}; errors below a few per cent need"
        f" {needed} or more{like}"
    )


def _in_cells(number: float) -> str:
    """Write a number of cells, never rounded up to a limit that it misses."""
    return f"{number:.2g}" if number < 1.0 else f"{math.floor(10.0 * number) / 10.0:.1f}"
