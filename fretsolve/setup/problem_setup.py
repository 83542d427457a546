"""Make a case ready to be solved: the model it needs, its grid and its load path."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING

from fretsolve.case.models import Case
from fretsolve.errors import CaseError, FileError, KeyPath, dotted
from fretsolve.friction.limit import FrictionOnGrid
from fretsolve.model.grid import Grid, LineGrid
from fretsolve.model.load_path import LoadPath
from fretsolve.model.required_terms import Model, derive_model
from fretsolve.model.surface import separation
from fretsolve.setup.accuracy import picks, points_needed, refinement, settled
from fretsolve.setup.closed_forms.area_forms import ClosedForms
from fretsolve.setup.closed_forms.normal_forms import Load
from fretsolve.setup.contact_size import Size, automatic_size, room_for_coarse_runs, surely_in_contact
from fretsolve.setup.kernel_choice import compiling_pays, seconds_saved
from fretsolve.setup.mirror_images import mirrored_increments
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.case.keys.wear_spec import WearSpec
    from fretsolve.friction.law import FrictionLaw
    from fretsolve.setup.unresolved_heights import HeightMaps
    from fretsolve.wear.law import WearLaw

SINGLE_RANGE = 1e28
"""Largest compliance of a cell in single precision in mm per MPa, and over 1 the smallest. The format ends at 1e38."""

MOST_TRIED_LOADS = 20
"""Normal loads of a path, the largest ones, under which a map of friction is required to cover the contact."""


@dataclass(frozen=True)
class ProblemSetup:
    """A case with the model it needs, its grid, its load path and the closed forms that hold for it.

    case: with the settings that its accuracy picks; heights: reads the height maps when it is first called; picked: the
    picked settings in words; compiled: whether the kernels compiled by numba are to be used; friction: its law, None
    where it is one coefficient; wear: its law, None without wear.
    """

    case: Case
    model: Model
    grid: Grid
    load_path: LoadPath
    closed_forms: ClosedForms
    heights: Callable[[], HeightMaps]
    picked: tuple[str, ...] = ()
    compiled: bool = False
    friction: FrictionLaw | None = None
    wear: WearLaw | None = None

    def separation(self) -> DoubleArray:
        """Return the undeformed separation of the surfaces on the grid, ``(nx, ny)`` in mm.

        Raises FileError where a height map cannot be read, CaseError where it does not fit the case.
        """
        try:
            return separation(self.case.surface, self.grid.x, self.grid.y)
        except CaseError as error:
            raise self.case.source.problem(error.message, error.key) from None
        except FileError as error:
            raise _of_the_case(error, self.case) from None

    @cached_property
    def mirrored_increments(self) -> int:
        """Number of increments, from the first one on, that are solved on one half of the grid."""
        return mirrored_increments(self.case, self.model, self.grid, self.load_path, self.friction)

    @property
    def share_of_cells(self) -> float:
        """Part of the grid on which increments are solved, a mean over all of them: from one half to 1."""
        return 1.0 - 0.5 * self.mirrored_increments / max(self.load_path.increments, 1)

    @property
    def seconds_saved(self) -> float:
        """Seconds that the compiled kernels save in the increments."""
        cells = self.share_of_cells * self.grid.nx * self.grid.ny
        return seconds_saved(self.model, cells, self.load_path.increments)

    def friction_on_grid(self) -> FrictionOnGrid:
        """Return the friction on the grid, from which the friction limit of each increment follows.

        Raises CaseError where the coefficient is not one, or where a map does not give it on the contact.
        """
        if self.friction is None:
            return FrictionOnGrid(self.case.friction, varied=False)
        law = self.friction.on(self.grid)
        if law.unknown is not None and law.unknown.any():
            self._require_friction_in_contact(self.friction)
        return law

    def _require_friction_in_contact(self, friction: FrictionLaw) -> None:
        """Raise CaseError where the contact at the end of a stage surely reaches where a map gives no coefficient."""
        case, compliances = self.case, self.model.compliances
        loads = sorted(set(self.load_path.normal_loads()), key=lambda load: load.values, reverse=True)
        for load in loads[:MOST_TRIED_LOADS]:
            found = surely_in_contact(case.surface, compliances, load, self.grid, case.grid.center)
            if found is not None:
                coarse, contact = found
                friction.on(coarse).require_known(contact, coarse, case)


def _of_the_case(error: FileError, case: Case) -> FileError:
    """Return the error of a map that cannot be read with its place in the case file."""
    maps = [place for place, one in enumerate(case.surface) if one.kind == "heights" and one.file == error.file]
    keys: list[KeyPath] = [("surface", place, "heights", "file") for place in maps]
    if case.friction.map is not None and case.friction.map == error.file:
        keys.append(("friction", "map"))
    if not keys:
        return error
    problem = case.source.problem(f"{error.file}: {error.message}", keys[0])
    place = f"{problem.file}:{problem.line}" if problem.line is not None else str(problem.file)
    return FileError(f"{dotted(problem.key)}: {problem.message}", place)


def _read_heights(case: Case, model: Model, load_path: LoadPath, size: Size) -> HeightMaps:
    from fretsolve.setup.unresolved_heights import HeightMaps  # few cases ask for it

    modulus = model.compliances.contact_modulus
    size = (size[0], 1.0) if model.line else size  # the area of a mm of the line
    try:
        return HeightMaps.of(case.surface, case.grid.center, size, load_path.imposed, modulus)
    except CaseError as error:
        raise case.source.problem(error.message, error.key) from None
    except FileError as error:
        raise _of_the_case(error, case) from None


def model_of_forms(case: Case) -> Model:
    """Return the model for the closed forms of a case that is not solved.

    Where friction varies they take the limit from the case, so that the coefficient of the model is a scale alone.
    """
    return derive_model(case, 1.0 if case.friction_varies else None)


def closed_forms_of(case: Case, model: Model, loads: tuple[Load, ...]) -> ClosedForms:
    """Return the closed forms that hold for a case under `loads` one after another."""
    if not model.line:
        return ClosedForms(case, model, loads)
    from fretsolve.setup.closed_forms.line_forms import LineClosedForms  # other cases need none of them

    return LineClosedForms(case, model, loads)


def _require_slip(case: Case, model: Model) -> None:
    """Raise CaseError if a case with wear has nothing that slips."""
    if case.wear is None or model.has_shear:
        return
    message = "the load path shears nothing, so that nothing wears; a stage that moves Qx or delta_x is needed"
    raise case.source.problem(message, ("wear",))


def _wear_law(wear: WearSpec) -> WearLaw:
    from fretsolve.wear.law import wear_law  # few cases have one

    return wear_law(wear)


def _friction_law(case: Case) -> FrictionLaw | None:
    from fretsolve.friction.law import friction_law  # few cases have one

    return friction_law(case)


def _grid(model: Model, points: tuple[int, int], size: Size, case: Case) -> Grid:
    if not model.line:
        return Grid.from_size(points, size, case.grid.center)
    length, depth, material = size[0], case.reference_depth, model.compliances
    # With a reference depth, a force in the grid's middle does not sink the points there.
    log_length = length if depth is None else depth * math.exp(-0.5 * (material.A + material.B) / material.A)
    return LineGrid.of_length(points[0], length, case.grid.center[0], log_length)


def _automatic_size(case: Case, closed_forms: ClosedForms, load_path: LoadPath) -> Size:
    """Return the sides (mm) that hold the contact, also on the cells of the coarse runs where error bars take some."""
    size, points = automatic_size(closed_forms, load_path.normal_loads()), case.grid.points
    if points is None or not case.solver.error_bars:  # an accuracy picks points that leave the room anyway
        return size
    nx, ny = (points[0], points[0]) if closed_forms.model.line else points
    return size[0] * room_for_coarse_runs(nx), size[1] * room_for_coarse_runs(ny)


def _require_deep(case: Case, size: Size) -> None:
    """Raise CaseError if the reference depth of a line contact is less than the grid's length."""
    depth = case.reference_depth
    if depth is not None and depth < size[0]:
        message = (
            f"{depth:g} mm is less than the grid's length; {size[0]:g} mm or more is needed, since delta_z is about"
        )
        raise case.source.problem(f"{message} points far below", ("reference_depth",))


def set_up(case: Case, compiled: bool | None = None) -> ProblemSetup:
    """Derive the model, the load path and the grid of `case`, and pick the settings for its accuracy.

    compiled: whether the compiled kernels are to be used, None where the case decides.
    Raises CaseError or FileError where a surface cannot be read, no size holds the contact, or influence coefficients
    leave the range of single precision.
    """
    try:
        return _set_up(case, compiled)
    except FileError as error:
        raise _of_the_case(error, case) from None


def _set_up(case: Case, compiled: bool | None) -> ProblemSetup:
    asked, case = case, settled(case)
    friction = _friction_law(case) if case.friction_varies else None
    model = derive_model(case, None if friction is None else friction.largest)
    _require_slip(case, model)
    load_path = LoadPath(case.stages(), model, refinement(case.solver.accuracy, model))
    closed_forms = closed_forms_of(case, model, load_path.imposed)
    size = case.grid.size or _automatic_size(case, closed_forms, load_path)
    _require_deep(case, size)
    heights = cache(partial(_read_heights, case, model, load_path, size))
    points = case.grid.points or points_needed(closed_forms, load_path, size, heights)
    grid = _grid(model, points, size, case)
    case = case.model_copy(update={"grid": case.grid.model_copy(update={"points": points})})
    compliance = max(grid.dx, grid.dy) / model.compliances.contact_modulus
    if case.solver.precision == "single" and not 1.0 / SINGLE_RANGE < compliance < SINGLE_RANGE:
        raise case.source.problem(
            f"a cell yields by {compliance:.2g} mm under 1 MPa, which single precision (1e-38 to 3e38) cannot hold; use"
            " precision: double, or lengths and moduli nearer to those of metals",
            ("solver", "precision"),
        )
    wear = None if case.wear is None else _wear_law(case.wear)
    picked = picks(asked, case, points, load_path)
    setup = ProblemSetup(case, model, grid, load_path, closed_forms, heights, picked, False, friction, wear)
    compiled = compiling_pays(setup.seconds_saved) if compiled is None else compiled
    return replace(setup, compiled=True) if compiled else setup  # a copy would look for mirror images again
