"""Find the size of the potential contact area from the loads, for `size: auto` and for the advice of errors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fretsolve.case.keys.surface_specs import Surface
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, KeyPath
from fretsolve.model.grid import Grid, LineGrid
from fretsolve.model.load_control import LoadControl
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms
from fretsolve.model.surface import separation
from fretsolve.setup.closed_forms.area_forms import ClosedForms
from fretsolve.setup.closed_forms.normal_forms import Load, pressing, round_contact
from fretsolve.system.arrays import BoolArray, DoubleArray

Size = tuple[float, float]

AREA_MARGIN = 1.2
"""Sides of the area over the frictionless contact's extent about the centre."""

COUPLED_MARGIN = 1.1
"""Half a side over the reach of a contact that shear moves. Tried with friction from 0.3 to 30 on unlike bodies."""

COUPLED_LINE_MARGIN = 1.5
"""Side over the width of a line contact that shear moves."""

FEWEST_COARSE_POINTS, COARSENED, FREE_COARSE_CELLS = 8, 3, 1.0
"""Points per side of the coarsest run for error bars, at least, since with fewer a contact has no inside; by what they
are fewer than those of the run; and cells of that grid to leave free on each side of the contact. With 0.67 of them,
which AREA_MARGIN leaves, a coarse run found no solution in 28 of 140 contacts on 16 points (twelve surfaces, like and
unlike bodies, pressed alone and sheared to 0.9 of mu P), with 1 in none of them."""

TRIAL_POINTS, TRIAL_LINE_POINTS, TRIAL_TOLERANCE, MOST_TRIALS = 48, 96, 1e-3, 60
FILLED = (0.55, 0.95)
"""A trial has the right size where the contact fills this part of it, in both directions."""


def automatic_size(forms: ClosedForms, loads: Sequence[LoadControl]) -> Size:
    """Return the sides (mm) that hold the contact under all `loads`: by Hertz for a sphere, else by a search.

    Raises CaseError where no size holds the contact.
    """
    case, compliances, hertz = forms.case, forms.model.compliances, forms.largest
    if (concave := concave_sphere(case)) is not None:
        raise concave
    if hertz is not None and case.surface[0].kind == "sphere" and case.surface[0].center == case.grid.center:
        reach = max(hertz.contact_radius, worn_reach(forms))
        side = 2.0 * max(AREA_MARGIN * reach, COUPLED_MARGIN * _sheared_reach(forms))
        return side, side
    if forms.model.line and (width := forms.contact_width(0.0)) and case.surface[0].center == case.grid.center:
        side = (COUPLED_LINE_MARGIN if forms.model.coupled and forms.model.moved else AREA_MARGIN) * width
        return side, side
    try:
        first = min(
            _own_size(surface, compliances.contact_modulus, forms.loads, ("surface", index, surface.kind))
            for index, surface in enumerate(case.surface)
        )
        unworn = contact_size(case.surface, compliances, loads, case.grid.center, first, forms.model.line)
    except CaseError as error:
        raise case.source.problem(error.message, error.key) from None
    least = 2.0 * AREA_MARGIN * worn_reach(forms)
    return max(unworn[0], least), max(unworn[1], least)


def coarse_points(points: int, factor: int) -> int:
    """Return the points of a side on which a coarse run has a `factor`-th of `points`, at least.

    An even number becomes an even one, so that mirror images stay solved on one half of the grid.
    """
    found = max(min(points, FEWEST_COARSE_POINTS), math.ceil(points / factor))
    return found + found % 2 * (points % 2 == 0)


def room_for_coarse_runs(points: int) -> float:
    """Return the factor on an automatic side of `points` that lets the coarse runs of error bars hold the contact.

    It is 1 from 33 points on.
    """
    return room_for_cells(coarse_points(points, COARSENED))


def room_for_cells(points: int) -> float:
    """Return the factor on a side with AREA_MARGIN that leaves cells free on each side of a contact.

    points: of the side, at least 3. It is 1 from 12 points on.
    """
    return max(1.0, points / (points - 2.0 * FREE_COARSE_CELLS) / AREA_MARGIN)


def worn_reach(forms: ClosedForms) -> float:
    """Return how far from the grid's middle (mm) the worn contact reaches at most, 0 where none is known."""
    if forms.case.wear is None:
        return 0.0
    from fretsolve.setup.closed_forms.wear_forms import worn_radius  # few cases have wear

    radius = worn_radius(forms)
    return radius + max(map(abs, np.subtract(forms.case.surface[0].center, forms.case.grid.center))) if radius else 0.0


def _sheared_reach(forms: ClosedForms) -> float:
    """Return how far from the centre (mm) a sphere's contact reaches on the load path, moved by the coupling to shear.

    A tangential force Q within the radius a has uz of about beta Q / (pi E* a) at the edge, by the field of a point
    force (Cerruti), up on one side and down on the other. A sphere of radius R tilted so touches R beta Q / (pi E* a^2)
    beside its centre. Q is at most mu P, and 2 E* a times a displacement.
    """
    sphere, model = forms.case.surface[0], forms.model
    modulus, coupling = model.compliances.contact_modulus, abs(model.compliances.dundurs_constant)
    if sphere.kind != "sphere" or not model.terms.normal_tangential_coupling:
        return 0.0
    reach = 0.0
    for load, hertz in zip(forms.loads, forms.hertz, strict=True):
        if hertz is not None:
            radius = hertz.contact_radius
            stiffness = 2.0 * modulus * radius
            forces = [load.get(f"Q{axis}", stiffness * load.get(f"delta_{axis}", 0.0)) for axis in "xy"]
            force = min(model.friction * hertz.load, math.hypot(*forces))
            reach = max(reach, radius + sphere.radius * coupling * force / (math.pi * modulus * radius**2))
    return reach


def concave_sphere(case: Case) -> CaseError | None:
    """Return the error of a case whose only surface is a concave sphere; None for any other."""
    sphere = case.surface[0]
    if len(case.surface) > 1 or sphere.kind != "sphere" or sphere.radius > 0.0:
        return None
    return case.source.problem(
        f"{sphere.radius:g} mm is concave, so the bodies would touch only at the grid's edge; a convex sphere has a"
        " positive radius, a ball in a socket takes both spheres",
        ("surface", 0, "sphere", "radius"),
    )


def contact_size(
    surfaces: Sequence[Surface],
    compliances: Compliances,
    loads: Sequence[LoadControl],
    center: Size,
    first: float,
    line: bool = False,
) -> Size:
    """Search for the sides (mm) of an area about `center` that holds the frictionless contact under all of `loads`.

    The search solves on coarse grids and begins with the side `first` (mm); line: on one row of cells. Raises CaseError
    where the contact always reaches the edge, as that of an endless cylinder does.
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
    surfaces: Sequence[Surface], compliances: Compliances, load: LoadControl, grid: Grid, center: Size
) -> tuple[Grid, BoolArray] | None:
    """Return a coarse grid on the area of `grid`, and its cells in frictionless contact but those at the edge.

    None where the coarse cells miss a surface, or the area is too small to carry the load.
    """
    from scipy.ndimage import binary_erosion

    if line := isinstance(grid, LineGrid):
        coarse: Grid = LineGrid.of_length(min(TRIAL_LINE_POINTS, grid.nx), grid.size[0], center[0])
    else:
        coarse = Grid.from_size((min(TRIAL_POINTS, grid.nx), min(TRIAL_POINTS, grid.ny)), grid.size, center)
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
        from fretsolve.model.height_map import load_height_map  # other surfaces need none of it

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
        if line:
            grid: Grid = LineGrid.of_length(TRIAL_LINE_POINTS, float(size[0]), center[0])
        else:
            grid = Grid.from_size((TRIAL_POINTS, TRIAL_POINTS), (float(size[0]), float(size[1])), center)
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


def _contact(gap: DoubleArray, compliances: Compliances, load: LoadControl, grid: Grid) -> BoolArray | None:
    """Return the cells in frictionless contact on a trial grid; None where the grid is too small to carry the load."""
    # Imported here, since most cases are sized by a formula.
    from fretsolve.elastic.operator_on_grid import operator_on
    from fretsolve.solvers.normal import NormalSolver

    if not np.isfinite(gap).any():
        return None
    p, mx, my = load.imposed_resultant
    for mode, moment, centers in ((1, mx, grid.y), (2, my, grid.x)):
        if load.forced[0] and load.forced[mode] and not centers.min() <= moment / p <= centers.max():
            return None
    operator = operator_on(grid, compliances, Terms(False, False, False))
    pressure = np.zeros(grid.shape)
    NormalSolver(operator, grid).solve(gap, load, pressure, TRIAL_TOLERANCE, 200, np.zeros(3))
    return pressure > 0.0
