"""Make a case ready to be solved: the model it needs, its load path and its grid, sized by the loads on demand."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING

from fretsolve.case.models import Case
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.required_terms import Model, derive_model
from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.problem.setup.picked_settings import (
    Size,
    picks,
    points_needed,
    refinement,
    room_for_coarse_runs,
    settled,
    size_by_closed_form,
)
from fretsolve.problem.setup.problem import ProblemSetup, closed_forms_of, compiling_pays, placed
from fretsolve.system.arrays import BoolArray

if TYPE_CHECKING:
    from fretsolve.problem.setup.unresolved_heights import HeightMaps

SINGLE_RANGE = 1e28
"""Largest compliance of a cell in single precision in mm per MPa, and over 1 the smallest. The format ends at 1e38."""


def set_up(case: Case, compiled: bool | None = None) -> ProblemSetup:
    """Derive the model, the load path and the grid of `case`, and pick the settings for its accuracy.

    compiled: whether the compiled kernels are to be used, None where the case decides.
    Raises CaseError or FileError where a surface cannot be read, no size holds the contact, or influence coefficients
    leave the range of single precision.
    """
    with placed(case):
        return _set_up(case, compiled)


def _set_up(asked: Case, compiled: bool | None) -> ProblemSetup:
    case = settled(asked)
    friction = None
    if case.friction_varies:
        from fretsolve.problem.friction.law import friction_law  # few cases have one

        friction = friction_law(case)
    wear = None
    if case.wear is not None:
        from fretsolve.problem.setup.wear_law import wear_law  # few cases have one

        wear = wear_law(case.wear)
    model = derive_model(case, None if friction is None else friction.largest)
    _require_slip(case, model)
    load_path = LoadPath(case.stages(), model, refinement(case.solver.accuracy, model))
    forms = closed_forms_of(case, model, load_path.imposed)
    automatic_size = cache(partial(_automatic_size, forms, load_path))
    size = case.grid.size or _with_room(automatic_size(), case, model)
    _require_deep(case, size)
    heights = cache(partial(_read_heights, case, model, load_path, size))
    points = case.grid.points or points_needed(forms, load_path, size, heights, automatic_size)
    grid = _grid(model, points, size, case)
    _require_single_range(case, model, grid)
    picked = picks(asked, case, points, load_path)
    case = case.model_copy(update={"grid": case.grid.model_copy(update={"points": points})})
    sure_contact = partial(_sure_contact, case, model)
    setup = ProblemSetup(
        case, model, grid, load_path, forms, heights, automatic_size, sure_contact, picked, False, friction, wear
    )
    compiled = compiling_pays(setup.seconds_saved) if compiled is None else compiled
    return replace(setup, compiled=True) if compiled else setup  # a copy would look for mirror images again


def _automatic_size(forms: ClosedForms, load_path: LoadPath) -> Size:
    """Return the sides (mm) that hold the contact: by Hertz for a sphere, else by a search."""
    if (known := size_by_closed_form(forms)) is not None:
        return known
    from fretsolve.simulation.contact_search import searched_size  # most cases are sized by a formula

    with placed(forms.case):
        return searched_size(forms, load_path.normal_loads())


def _with_room(size: Size, case: Case, model: Model) -> Size:
    """Return automatic sides (mm) that hold the contact also on the cells of the coarse runs of error bars."""
    points = case.grid.points
    if points is None or not case.solver.error_bars:  # an accuracy picks points that leave the room anyway
        return size
    nx, ny = (points[0], points[0]) if model.line else points
    return size[0] * room_for_coarse_runs(nx), size[1] * room_for_coarse_runs(ny)


def _sure_contact(case: Case, model: Model, load: LoadControl, grid: Grid) -> tuple[Grid, BoolArray] | None:
    from fretsolve.simulation.contact_search import surely_in_contact  # few cases have a map of friction

    return surely_in_contact(case.surface, model.compliances, case.grid.center, load, grid)


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
    """Raise CaseError if a case with wear has nothing that slips."""
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


def _require_single_range(case: Case, model: Model, grid: Grid) -> None:
    """Raise CaseError if the influence coefficients leave the range of a case's single precision."""
    compliance = max(grid.dx, grid.dy) / model.compliances.contact_modulus
    if case.solver.precision == "single" and not 1.0 / SINGLE_RANGE < compliance < SINGLE_RANGE:
        raise case.source.problem(
            f"a cell yields by {compliance:.2g} mm under 1 MPa, which single precision (1e-38 to 3e38) cannot hold; use"
            " precision: double, or lengths and moduli nearer to those of metals",
            ("solver", "precision"),
        )
