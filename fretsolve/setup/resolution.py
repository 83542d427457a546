"""Count the cells across the contact: by closed forms before a run, in its result after it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fretsolve.case import CylinderSurface
from fretsolve.setup.contact_size import MARGIN
from fretsolve.setup.problem_setup import ProblemSetup

if TYPE_CHECKING:
    from fretsolve.result import Result

FEWEST_CELLS = 20
"""Cells across the contact below which results are off by per cents."""


def cells_across(setup: ProblemSetup) -> float | None:
    """Return the cells along the shorter side of the contact where it is largest; None if no closed form gives it."""
    grid, surface = setup.grid, setup.case.surface[0]
    width = setup.closed_forms.contact_width(max(grid.size))
    if width is None:
        return min(grid.shape) / MARGIN if setup.case.grid.size is None else None
    if isinstance(surface, CylinderSurface):
        return width / math.hypot(grid.dx * math.sin(surface.axis), grid.dy * math.cos(surface.axis))
    return width / max(grid.dx, grid.dy)


def in_cells(number: float) -> str:
    """Write a number of cells, never rounded up to a limit that it misses."""
    return f"{number:.2g}" if number < 1.0 else f"{math.floor(10.0 * number) / 10.0:.1f}"


def warning_of_result(setup: ProblemSetup, result: Result) -> str | None:
    """Warn if the finished contact has too few cells, where no closed form could warn before the run."""
    if not result.increments or cells_across(setup) is not None:
        return None
    most = int(result.history["contact_cells"].max())
    needed = math.ceil(0.25 * math.pi * FEWEST_CELLS**2)
    if most >= needed:
        return None
    return (
        f"grid.points: the contact has at most {most} cell{'s' * (most != 1)}; errors below a few per cent need"
        f" {needed} or more, as many as a round contact of {FEWEST_CELLS} cells across has"
    )
