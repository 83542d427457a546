"""A case made ready to be solved: the model it needs, its grid and its load path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.case.load_components import TANGENTIAL
from fretsolve.errors import CaseError
from fretsolve.model.grid import Grid
from fretsolve.model.load_path import LoadPath
from fretsolve.model.required_terms import Model, derive_model
from fretsolve.model.surface import map_border, separation
from fretsolve.reference.closed_forms import spence_stick_ratio
from fretsolve.setup.accuracy import picks, points_for, refinement, settled
from fretsolve.setup.contact_size import MARGIN, contact_size, first_trial, hertz_radius

if TYPE_CHECKING:

    from fretsolve.case import Case
    from fretsolve.system.arrays import BoolArray, DoubleArray


RANGE_OF_SINGLE = 1e28
"""Compliance of a cell, or one over it, in mm per MPa: within 1e-38 to 3e38 with ten digits of room."""


@dataclass(frozen=True)
class ProblemSetup:
    """A case made ready: the model it needs, its grid and its load path.

    case: with all that its accuracy has picked; picked: that in words.
    """

    case: Case
    model: Model
    grid: Grid
    load_path: LoadPath
    picked: tuple[str, ...] = ()

    def separation(self) -> DoubleArray:
        """Undeformed separation of the surfaces on the grid, ``(nx, ny)`` in mm.

        Raises FileError where a height map cannot be read, CaseError where it does not fit the case.
        """
        try:
            return separation(self.case.surface, self.grid.x, self.grid.y)
        except CaseError as error:
            raise _in_file(error, self.case) from None

    def map_border(self) -> BoolArray | None:
        """Cells where a height map ends within the grid, ``(nx, ny)``; None without a map. Raises FileError."""
        return map_border(self.case.surface, self.grid.x, self.grid.y)


def set_up(case: Case) -> ProblemSetup:
    """Model, grid (sized by the loads where the case says `auto`) and load path of `case`, and what its accuracy picks.

    Raises CaseError or FileError where the surfaces cannot be had or no size holds the contact.
    """
    asked, case = case, settled(case)
    model = derive_model(case)
    load_path = LoadPath(case.stages(), model, refinement(case.solver.accuracy, _pressed_width(case, model)))
    size = case.grid.size or _automatic_size(case, model, load_path)
    points = case.grid.points or points_needed(case, model, load_path, size)
    case = case.model_copy(update={"grid": case.grid.model_copy(update={"points": points})})
    grid = Grid.from_size(points, size, case.grid.center)
    _require_range_of_precision(case, model, grid)
    return ProblemSetup(case, model, grid, load_path, picks(asked, points, load_path))


def _require_range_of_precision(case: Case, model: Model, grid: Grid) -> None:
    """Raise CaseError where influence coefficients leave the range of single precision, if the case asks for it."""
    yielding = max(grid.dx, grid.dy) / model.compliances.contact_modulus
    if case.solver.precision == "single" and not 1.0 / RANGE_OF_SINGLE < yielding < RANGE_OF_SINGLE:
        message = (
            f"a cell yields by {yielding:.2g} mm under 1 MPa, which has no room in single precision (1e-38 to 3e38);"
            " precision: double, or lengths and moduli nearer to those of metals, would do"
        )
        raise case.source.problem(message, ("solver", "precision"))


def points_needed(case: Case, model: Model, load_path: LoadPath, size: tuple[float, float]) -> tuple[int, int]:
    """Points along x and y that the case's accuracy takes on an area of `size` (mm), by the contact's share of it.

    The contact counts as all of the area where its size cannot be told.
    """
    assert case.solver.accuracy is not None
    try:
        holds_contact = size if case.grid.size is None else _automatic_size(case, model, load_path)
    except CaseError:
        holds_contact = size
    extent = holds_contact[0] / MARGIN, holds_contact[1] / MARGIN
    sheared_width = 0.0 if model.coupled else load_path.slip_width
    return points_for(case.solver.accuracy, size, extent, sheared_width, _pressed_width(case, model))


def _pressed_width(case: Case, model: Model) -> float:
    """Width over contact radius of the annulus that slips where bodies that differ are pressed together; Spence.

    0 where nothing is asked for, where nothing slips, and under tangential loads, most of whose work is their own.
    """
    if case.solver.accuracy is None or not model.coupled:
        return 0.0
    if any(value and name in TANGENTIAL for stage in case.stages() for name, value in stage.targets):
        return 0.0
    return 1.0 - spence_stick_ratio(model.friction, model.compliances.dundurs_constant)


def _automatic_size(case: Case, model: Model, load_path: LoadPath) -> tuple[float, float]:
    """The closed form for a sphere on a flat, a search on coarse grids for everything else."""
    loads = load_path.normal_loads()
    concave = concave_sphere(case)
    if concave is not None:
        raise concave
    sphere = case.surface[0]
    if sphere.kind == "sphere" and sphere.radius > 0.0:
        radius = max(hertz_radius(load, sphere.radius, model.compliances.contact_modulus) for load in loads)
        centred = sphere.center == case.grid.center and len(case.surface) == 1
        upright = not any(load.values[1] or load.values[2] for load in loads)
        if radius > 0.0 and centred and upright:
            return 2.0 * MARGIN * radius, 2.0 * MARGIN * radius
    try:
        first = first_trial(case.surface, model.compliances, loads)
        return contact_size(case.surface, model.compliances, loads, case.grid.center, first)
    except CaseError as error:
        raise _in_file(error, case) from None


def concave_sphere(case: Case) -> CaseError | None:
    """The error of a case whose only surface is a concave sphere; None of any other."""
    sphere = case.surface[0]
    if len(case.surface) > 1 or sphere.kind != "sphere" or sphere.radius > 0.0:
        return None
    return case.source.problem(
        f"{sphere.radius:g} mm is concave, so the bodies would touch at the grid's edge only; a convex sphere has a"
        " positive radius, a ball in a socket takes both spheres",
        ("surface", 0, "sphere", "radius"),
    )


def _in_file(error: CaseError, case: Case) -> CaseError:
    """The same error with its place in the case file."""
    return case.source.problem(error.message, error.key)
