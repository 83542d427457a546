"""The place in the case file of what no increment can solve, and what would be right there."""

from __future__ import annotations

from fretsolve.errors import CaseError, GridEdgeError, KeyPath, NoSolutionError
from fretsolve.model.load_path import Increment
from fretsolve.model.surface import map_spans
from fretsolve.setup.contact_search import contact_size
from fretsolve.setup.contact_size import AREA_MARGIN, room_for_cells, worn_reach
from fretsolve.setup.problem_setup import ProblemSetup

FEWEST_POINTS = 3
"""Points of a side of which one can be in contact and those beside it free."""


def locate(error: NoSolutionError, setup: ProblemSetup, increment: Increment) -> None:
    """Add to `error` the place of the load in the case file, and a size that would hold the contact."""
    stage = increment.stage
    key: KeyPath = stage.place(error.component)
    if isinstance(error, GridEdgeError):
        on_grid = error.component is None
        key = ("grid", "size") if on_grid else ("surface",)
        error.message += _advised_size(setup, increment) if on_grid else ""
    message = f"{error.message} (increment {increment.step}, stage {stage.number})"
    place = setup.case.source.problem(message, key)
    error.key, error.file, error.line, error.message = place.key, place.file, place.line, place.message


def _advised_size(setup: ProblemSetup, increment: Increment) -> str:
    """Return advice about a contact at the grid's edge: a size that holds it on all of the load path."""
    loads = [increment.normal, *setup.load_path.normal_loads()]
    surfaces, materials = setup.case.surface, setup.model.compliances
    try:
        center, first = setup.grid.center, max(setup.grid.size)
        size = contact_size(surfaces, materials, loads, center, first, setup.model.line)
    except CaseError:
        return "; no size would hold it"
    contact = tuple(side / AREA_MARGIN for side in size)
    if any(span < 1.05 * side for spans in map_spans(surfaces) for span, side in zip(spans, contact, strict=True)):
        return "; no size would do, since the height map ends too soon: a larger map is needed"
    worn, grid = 2.0 * AREA_MARGIN * worn_reach(setup.closed_forms), setup.grid
    of_axes = zip(grid.axes, size, grid.shape, grid.size, strict=False)  # a line has one axis
    sides = [(max(side, worn), points, present) for _, side, points, present in of_axes]
    if any(points < FEWEST_POINTS for _, points, _ in sides):
        larger = tuple(max(side, present) for side, _, present in sides)
        return f"; {_size_in_words(larger, setup)} would do with more points, which resolve the contact"
    roomy = tuple(side * room_for_cells(points) for side, points, _ in sides)
    if all(advised <= 1.05 * present for advised, (_, _, present) in zip(roomy, sides, strict=True)):
        wider = tuple(1.5 * present for _, _, present in sides)  # since shear or moments widen the contact
        return f"; the size would hold the contact under the normal load alone: try {_size_in_words(wider, setup)}"
    return f"; {_size_in_words(roomy, setup)} would do"


def _size_in_words(size: tuple[float, ...], setup: ProblemSetup) -> str:
    """Return the key `size` of a case, which is one number in a line contact."""
    sides = [f"{side:.3g} mm" for side in size]
    return f"size: {sides[0]}" if setup.model.line else f"size: [{', '.join(sides)}]"
