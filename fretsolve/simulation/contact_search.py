"""Search for the contact on coarse grids without friction, where no closed form gives its size.

It solves, and so stands above the solvers: `size: auto`, the advice of errors and maps of friction use it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretsolve.case.keys.body_specs import Surface
from fretsolve.contact.solvers.normal import NormalSolver
from fretsolve.elastic.operator_on_grid import operator_on
from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms
from fretsolve.problem.model.surface import separation
from fretsolve.problem.setup.closed_forms import ClosedForms, Load, pressing, round_contact
from fretsolve.problem.setup.picked_settings import AREA_MARGIN, Size, worn_reach
from fretsolve.system.arrays import BoolArray, DoubleArray

TRIAL_POINTS, TRIAL_LINE_POINTS = 48, 96
"""Cells per side of a trial, and of one of a line: enough to find the contact's extent within a few per cent."""

MOST_TRIALS = 60
"""Trials after which no size is found: 40 doublings lead from 1 nm to 1 m."""

FILLED = (0.55, 0.95)
"""A trial has the right size where the contact fills this part of it, in both directions."""


def searched_size(forms: ClosedForms, loads: Sequence[LoadControl]) -> Size:
    """Return the sides (mm) that hold the contact under all `loads`. Raises CaseError where no size does."""
    case, compliances = forms.case, forms.model.compliances
    first = min(
        _own_size(surface, compliances.contact_modulus, forms.loads, ("surface", index, surface.kind))
        for index, surface in enumerate(case.surface)
    )
    unworn = contact_size(case.surface, compliances, loads, case.grid.center, first, forms.model.line)
    least = 2.0 * AREA_MARGIN * worn_reach(forms)
    return max(unworn[0], least), max(unworn[1], least)


def contact_size(
    surfaces: Sequence[Surface],
    compliances: Compliances,
    loads: Sequence[LoadControl],
    center: Size,
    first: float,
    line: bool = False,
) -> Size:
    """Search for the sides (mm) of an area about `center` that holds the frictionless contact under all of `loads`.

    The search begins with the side `first` (mm); line: on one row of cells. Raises CaseError where the contact always
    reaches the edge, as that of an endless cylinder does.
    """
    extent = np.zeros(2)
    for load in dict.fromkeys(loads):
        if not load.forced[0] or load.values[0] > 0.0:
            extent = np.maximum(extent, _extent(surfaces, compliances, load, center, first, line))
    if not extent.any():
        message = "auto finds no contact anywhere on the load path; give the size of the potential contact area"
        raise CaseError(message, ("grid", "size"))
    extent[extent == 0.0] = extent.max()
    return AREA_MARGIN * float(extent[0]), AREA_MARGIN * float(extent[1])


def surely_in_contact(
    surfaces: Sequence[Surface], compliances: Compliances, center: Size, load: LoadControl, grid: Grid
) -> tuple[Grid, BoolArray] | None:
    """Return a coarse grid on the area of `grid`, and its cells in frictionless contact but those at the edge.

    None where the coarse cells miss a surface, or the area is too small to carry the load.
    """
    from scipy.ndimage import binary_erosion

    line = isinstance(grid, LineGrid)
    coarse = _trial_grid(grid.size, center, line, grid.shape)
    try:
        contact = _contact(separation(surfaces, coarse.x, coarse.y), compliances, load, coarse)
    except CaseError:
        return None
    return None if contact is None else (coarse, binary_erosion(contact, np.ones((3, 1 if line else 3))))


def _own_size(surface: Surface, contact_modulus: float, loads: Sequence[Load], key: KeyPath) -> float:
    """Return a side (mm) of the order of a surface's contact, where the search begins; 1 mm without contact."""
    if surface.kind == "punch":
        return 2.0 * (surface.radius or surface.half_width or 0.0)
    if surface.kind == "heights":
        from fretsolve.problem.model.height_map import load_height_map  # other surfaces need none of it

        found = load_height_map(surface, key)
        return max(*found.span, *found.spacing)
    contacts = (round_contact(surface, contact_modulus, *pressing(load)) for load in loads)
    return 2.0 * AREA_MARGIN * max((contact.contact_radius for contact in contacts if contact), default=0.0) or 1.0


def _extent(
    surfaces: Sequence[Surface], compliances: Compliances, load: LoadControl, center: Size, first: float, line: bool
) -> DoubleArray:
    """Return the sides (mm) of the least rectangle about `center` that holds the contact, zeros without contact."""
    size = np.array([first, first])
    refused: CaseError | None = None
    for _ in range(MOST_TRIALS):
        grid = _trial_grid((float(size[0]), float(size[1])), center, line)
        try:
            contact, refused = _contact(separation(surfaces, grid.x, grid.y), compliances, load, grid), None
        except CaseError as error:  # the grid is too small to meet the surface, or the surface itself is wrong
            contact, refused = None, error
        if contact is None:
            size *= 2.0
            continue
        if not contact.any():
            return np.zeros(2)
        reach_x = np.abs(grid.x - center[0])[contact.any(axis=1)].max() + 0.5 * grid.dx
        reach_y = np.abs(grid.y - center[1])[contact.any(axis=0)].max() + 0.5 * grid.dy
        extent = 2.0 * np.array([reach_x, reach_x if line else reach_y])
        filled = extent / size
        if (filled > FILLED[0]).all() and (filled < FILLED[1]).all():
            return extent
        size = np.where(filled >= FILLED[1], 1.6 * size, np.maximum(AREA_MARGIN * extent, 0.1 * size))
        if size.max() > 1e3 * size.min():  # such a contact counts as endless
            break
    tried = f"tried up to {size.max():.3g} mm"
    message = f"auto finds no size that holds the contact ({tried}); give a size, or a surface that ends"
    raise refused or CaseError(message, ("grid", "size"))


def _trial_grid(size: Size, center: Size, line: bool, shape: tuple[int, int] | None = None) -> Grid:
    """Return a coarse grid of `size` (mm) about `center`, of no more points than a grid of `shape`."""
    most = TRIAL_LINE_POINTS if line else TRIAL_POINTS
    nx, ny = (min(most, points) for points in shape or (most, most))
    return LineGrid.of_length(nx, size[0], center[0]) if line else Grid.from_size((nx, ny), size, center)


def _contact(gap: DoubleArray, compliances: Compliances, load: LoadControl, grid: Grid) -> BoolArray | None:
    """Return the cells in frictionless contact on a trial grid; None where the grid is too small to carry the load."""
    if not np.isfinite(gap).any():
        return None
    p, mx, my = load.imposed_resultant
    for mode, moment, centers in ((1, mx, grid.y), (2, my, grid.x)):
        if load.forced[0] and load.forced[mode] and not centers.min() <= moment / p <= centers.max():
            return None
    operator = operator_on(grid, compliances, Terms(False, False, False))
    pressure = np.zeros(grid.shape)
    NormalSolver(operator, grid).solve(gap, load, pressure, 1e-3, 200, np.zeros(3))
    return pressure > 0.0
