"""How many cells the contact has across: by closed forms before a run, counted in its result."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fretsolve.reference.closed_forms import love_cone
from fretsolve.setup.contact_size import MARGIN

if TYPE_CHECKING:
    from fretsolve.case import Surface
    from fretsolve.result import Result
    from fretsolve.setup.hertz import Hertz
    from fretsolve.setup.problem_setup import ProblemSetup

FEWEST_CELLS = 20
"""Cells across the contact below which results are off by per cents."""


def cells_across(setup: ProblemSetup, hertz: Hertz | None) -> float | None:
    """Cells along the shorter side of the contact where it is largest; None where no closed form tells.

    hertz: the contact at the largest load, None where Hertz's theory does not apply.
    """
    grid = setup.grid
    if hertz is not None:
        return hertz.cells_across(grid)
    surface = setup.case.surface[0]
    if len(setup.case.surface) == 1 and surface.kind == "cylinder" and surface.crown_radius is None:
        cell = math.hypot(grid.dx * math.sin(surface.axis), grid.dy * math.cos(surface.axis))
        width = _line_width(setup, surface.radius, surface.length or max(grid.size))
    else:
        cell = max(grid.dx, grid.dy)
        width = _round_width(setup, surface) if len(setup.case.surface) == 1 else None
    if width is not None:
        return width / cell
    return min(grid.shape) / MARGIN if setup.case.grid.size is None else None


def _round_width(setup: ProblemSetup, surface: Surface) -> float | None:
    """The diameter (mm) of a cone's contact by Love, the face of a punch with all of its edge; None for others."""
    if surface.kind == "punch":
        return 2.0 * (surface.radius or surface.half_width or 0.0)
    load = _largest(setup, "P")
    if surface.kind == "cone" and load > 0.0:
        return 2.0 * love_cone(load, surface.angle, setup.model.compliances.contact_modulus).contact_radius
    return None


def _line_width(setup: ProblemSetup, radius: float, length: float) -> float | None:
    """The width (mm) of a cylinder's contact with the load even along `length` (mm); Johnson, section 4.2(c)."""
    load = _largest(setup, "P")
    if load <= 0.0 or radius <= 0.0:
        return None
    return 2.0 * math.sqrt(4.0 * load * radius / (math.pi * length * setup.model.compliances.contact_modulus))


def _largest(setup: ProblemSetup, component: str) -> float:
    return max((load.get(component, 0.0) for load in setup.load_path.imposed), default=0.0)


def in_cells(number: float) -> str:
    """A number of cells, never rounded up to a limit that it misses."""
    return f"{number:.2g}" if number < 1.0 else f"{math.floor(10.0 * number) / 10.0:.1f}"


def doubt_of_result(setup: ProblemSetup, hertz: Hertz | None, result: Result) -> str | None:
    """What a person should hear of a contact of few cells, where no closed form has told before the run."""
    if not result.increments or cells_across(setup, hertz) is not None:
        return None
    most = int(result.history["contact_cells"].max())
    needed = math.ceil(0.25 * math.pi * FEWEST_CELLS**2)
    if most >= needed:
        return None
    return (
        f"grid.points: the contact has no more than {most} cell{'s' * (most != 1)}; {needed} or more, as a round one"
        f" has that is {FEWEST_CELLS} across, are needed for errors below a few per cent"
    )
