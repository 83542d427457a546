"""Make a case ready to be solved: the model it needs, its load path and its grid, sized by the loads on demand.

Where no closed form gives the size of the contact, it is searched for on coarse grids without friction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.keys.body_specs import Surface
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import LoadPath, imposed_along
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Model, Terms, derive_model
from fretsolve.problem.setup.closed_forms import ClosedForms, Load, pressing, round_contact
from fretsolve.problem.setup.picked_settings import (
    AREA_MARGIN,
    Picks,
    Size,
    first_points,
    in_words,
    room_for_coarse_runs,
    settled,
    size_by_closed_form,
    worn_reach,
)
from fretsolve.problem.setup.problem import ProblemSetup, closed_forms_of, compiling_pays, moves_with_loads, placed
from fretsolve.problem.setup.wear_law import wear_law
from fretsolve.problem.surface.separation import separation
from fretsolve.system.arrays import BoolArray, DoubleArray, grown

if TYPE_CHECKING:
    from fretsolve.problem.setup.unresolved_heights import HeightMaps

SINGLE_RANGE = 1e28
"""Largest compliance of a cell in single precision in mm per MPa, and over 1 the smallest. The format ends at 1e38."""


def set_up(case: Case, compiled: bool | None = None, picks: Picks | None = None) -> ProblemSetup:
    """Derive the model, the load path and the grid of `case`, and pick the settings for its accuracy.

    compiled: whether the compiled kernels are to be used, None where the case decides; picks: of a round of the
    accuracy, None for the first round.
    Raises CaseError or FileError where a surface cannot be read, no size holds the contact, or influence coefficients
    leave the range of single precision.
    """
    with placed(case):
        return _set_up(case, compiled, picks)


def _set_up(asked: Case, compiled: bool | None, picks: Picks | None) -> ProblemSetup:
    case = settled(asked, picks)
    friction = None
    if case.friction_varies:
        from fretsolve.problem.friction.law import friction_law  # few cases have one

        friction = friction_law(case)
    wear = None if case.wear is None else wear_law(case.wear)
    model = derive_model(case, None if friction is None else friction.largest)
    _require_slip(case, model)
    at_contact = None
    if moves_with_loads(case):
        from fretsolve.problem.setup.rig_forms import RigForms  # other cases do not need them

        at_contact = RigForms(case, model, imposed_along(case.stages(), model)).at_contact
    load_path = LoadPath(case.stages(), model, case.solver.refinement or 1.0, at_contact)
    forms = closed_forms_of(case, model, load_path.imposed)
    automatic_size = cache(partial(_automatic_size, forms, load_path))
    size = case.grid.size or _with_room(automatic_size(), case, model)
    _require_deep(case, size)
    heights = cache(partial(_read_heights, case, model, load_path, size))
    points = case.grid.points or (first_points(forms, size, automatic_size) if picks is None else picks.points)
    grid = _grid(model, points, size, case)
    _require_single_range(case, model, grid)
    _require_two_cells_per_wave(case, grid)
    picked = in_words(asked, case, points, load_path)
    case = case.model_copy(update={"grid": case.grid.model_copy(update={"points": points})})
    sure_contact = partial(surely_in_contact, case.surface, model.compliances, case.grid.center)
    setup = ProblemSetup(
        case, model, grid, load_path, forms, heights, automatic_size, sure_contact, picked, False, friction, wear
    )
    compiled = compiling_pays(setup.seconds_saved) if compiled is None else compiled
    return replace(setup, compiled=True) if compiled else setup  # a copy would look for mirror images again


def _automatic_size(forms: ClosedForms, load_path: LoadPath) -> Size:
    """Return the sides (mm) that hold the contact: by Hertz for a sphere, else by a search."""
    if (known := size_by_closed_form(forms)) is not None:
        return known
    with placed(forms.case):
        return searched_size(forms, load_path.normal_loads())


def _with_room(size: Size, case: Case, model: Model) -> Size:
    """Return automatic sides (mm) that hold the contact also on the cells of the coarse runs of error bars."""
    points = case.grid.points
    if points is None or not case.solver.error_bars:  # an accuracy picks points that leave the room anyway
        return size
    nx, ny = (points[0], points[0]) if model.line else points
    return size[0] * room_for_coarse_runs(nx), size[1] * room_for_coarse_runs(ny)


def _read_heights(case: Case, model: Model, load_path: LoadPath, size: Size) -> HeightMaps:
    from fretsolve.problem.setup.unresolved_heights import HeightMaps  # few cases ask for it

    size = (size[0], 1.0) if model.line else size  # the area of a mm of the line
    with placed(case):
        modulus = model.compliances.contact_modulus
        return HeightMaps.of(case.surface, case.grid.center, size, load_path.imposed, modulus)


def _grid(model: Model, points: tuple[int, int], size: Size, case: Case) -> Grid:
    if not model.line:
        return Grid.from_size(points, size, case.grid.center)
    length, depth, material = size[0], case.reference_depth, model.compliances
    # With a reference depth, a force in the grid's middle does not sink the points there.
    log_length = length if depth is None else depth * math.exp(-0.5 * (material.A + material.B) / material.A)
    return LineGrid.of_length(points[0], length, case.grid.center[0], log_length)


def _require_slip(case: Case, model: Model) -> None:
    if case.wear is not None and not model.has_shear:
        message = "the load path shears nothing, so that nothing wears; a stage that moves Qx or delta_x is needed"
        raise case.source.problem(message, ("wear",))


def _require_deep(case: Case, size: Size) -> None:
    """Raise CaseError if the reference depth of a line contact is less than the grid's length."""
    depth = case.reference_depth
    if depth is not None and depth < size[0]:
        raise case.source.problem(
            f"{depth:g} mm is less than the grid's length; {size[0]:g} mm or more is needed, since delta_z is about"
            " points far below",
            ("reference_depth",),
        )


def _require_two_cells_per_wave(case: Case, grid: Grid) -> None:
    """Raise CaseError if waves of a rough surface are shorter than two cells, which would see longer ones instead."""
    side = max(grid.dx, grid.dy)
    for index, surface in enumerate(case.surface):
        if surface.kind == "roughness" and surface.cutoff < 2.0 * side * (1.0 - 1e-9):
            raise case.source.problem(
                f"{surface.cutoff:g} mm is under two cells of the grid ({side:.3g} mm each); {2.0 * side:.3g} mm or"
                " more is needed, or more points",
                ("surface", index, "roughness", "cutoff"),
            )


def _require_single_range(case: Case, model: Model, grid: Grid) -> None:
    """Raise CaseError if the influence coefficients leave the range of a case's single precision."""
    compliance = max(grid.dx, grid.dy) / model.compliances.contact_modulus
    if case.solver.precision == "single" and not 1.0 / SINGLE_RANGE < compliance < SINGLE_RANGE:
        raise case.source.problem(
            f"a cell yields by {compliance:.2g} mm under 1 MPa, which single precision (1e-38 to 3e38) cannot hold; use"
            " precision: double, or lengths and moduli nearer to those of metals",
            ("solver", "precision"),
        )


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
    reaches the edge, as the contact of an endless cylinder does.
    """
    if all(surface.kind == "roughness" for surface in surfaces):
        message = "a rough flat does not end, so that no size holds its contact; add a surface, such as a punch"
        raise CaseError(message, ("grid", "size"))
    extent = np.zeros(2)
    for load in dict.fromkeys(loads):
        if not load.forced[0] or load.values[0] > 0.0:
            extent = np.maximum(extent, _extent(surfaces, compliances, load, center, first, line))
    if not extent.any():
        message = (
            "auto finds no contact, as nothing on the load path presses the bodies together; a force P > 0 N or an"
            " approach delta_z > 0 mm does"
        )
        raise CaseError(message, ("grid", "size"))
    extent[extent == 0.0] = extent.max()
    return AREA_MARGIN * float(extent[0]), AREA_MARGIN * float(extent[1])


def surely_in_contact(
    surfaces: Sequence[Surface], compliances: Compliances, center: Size, load: LoadControl, grid: Grid
) -> tuple[Grid, BoolArray] | None:
    """Return a coarse grid on the area of `grid`, and its cells in frictionless contact except at the edge.

    None where the coarse cells miss a surface, or the area is too small to carry the load.
    """
    line = isinstance(grid, LineGrid)
    coarse = _trial_grid(grid.size, center, line, grid.shape)
    try:
        contact = _contact(separation(surfaces, coarse.x, coarse.y), compliances, load, coarse)
    except CaseError:
        return None
    if contact is None:
        return None
    # beyond the grid nothing touches, but a line goes on along y
    apart = grown(np.pad(~contact, ((1, 1), (0, 0) if line else (1, 1)), constant_values=True))
    return coarse, ~apart[1:-1, slice(None) if line else slice(1, -1)]


def _own_size(surface: Surface, contact_modulus: float, loads: Sequence[Load], key: KeyPath) -> float:
    """Return a side (mm) of the order of a surface's contact, where the search begins; 1 mm without contact."""
    if surface.kind == "punch":
        return 2.0 * (surface.radius or surface.half_width or 0.0)
    if surface.kind == "heights":
        from fretsolve.problem.surface.load_map import load_height_map  # other surfaces do not need it

        found = load_height_map(surface, key)
        return max(*found.span, *found.spacing)
    if surface.kind == "roughness":
        return surface.period
    contacts = (round_contact(surface, contact_modulus, *pressing(load)) for load in loads)
    return 2.0 * AREA_MARGIN * max((contact.contact_radius for contact in contacts if contact), default=0.0) or 1.0


def _extent(
    surfaces: Sequence[Surface], compliances: Compliances, load: LoadControl, center: Size, first: float, line: bool
) -> DoubleArray:
    """Return the sides (mm) of the least rectangle about `center` that holds the contact, zeros without contact."""
    size = np.array([first, first])
    refused: CaseError | None = None
    # 40 doublings lead from 1 nm to 1 m
    for _ in range(60):
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
        if (filled > 0.55).all() and (filled < 0.95).all():
            return extent
        size = np.where(filled >= 0.95, 1.6 * size, np.maximum(AREA_MARGIN * extent, 0.1 * size))
        if size.max() > 1e3 * size.min():  # such a contact counts as endless
            break
    tried = f"tried up to {size.max():.3g} mm"
    message = f"auto finds no size that holds the contact ({tried}): the surfaces stay close along"
    message += " one direction, as an endless cylinder or concave radii do; give a size, or a surface that ends"
    raise refused or CaseError(message, ("grid", "size"))


def _trial_grid(size: Size, center: Size, line: bool, shape: tuple[int, int] | None = None) -> Grid:
    """Return a coarse grid of `size` (mm) about `center`, of no more points than a grid of `shape`."""
    # enough to find the contact's extent within a few per cent
    most = 96 if line else 48
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
    from fretsolve.contact.solvers.normal import NormalSolver  # most cases are sized by a formula
    from fretsolve.elastic.operator_on_grid import operator_on

    operator = operator_on(grid, compliances, Terms(False, False, False))
    pressure = np.zeros(grid.shape)
    NormalSolver(operator, grid).solve(gap, load, pressure, 1e-3, 200, np.zeros(3))
    return pressure > 0.0
