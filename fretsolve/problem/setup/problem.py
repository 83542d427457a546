"""What is known of a case before it is solved: `ProblemSetup`, its mirror images, and which kernels it is to use."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from fretsolve.case.history import COMPONENTS
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, FileError, KeyPath, dotted
from fretsolve.problem.friction.limit import FrictionOnGrid
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.required_terms import Model, derive_model
from fretsolve.problem.setup.closed_forms import ClosedForms, Load
from fretsolve.problem.setup.picked_settings import Size
from fretsolve.problem.surface.separation import is_mirrored, separation
from fretsolve.system.arrays import BoolArray, DoubleArray
from fretsolve.system.environment import compiler_asked, compiler_installed

if TYPE_CHECKING:
    from fretsolve.problem.friction.law import FrictionLaw
    from fretsolve.problem.setup.rig_forms import RigForms
    from fretsolve.problem.setup.unresolved_heights import HeightMaps
    from fretsolve.problem.setup.wear_law import WearLaw

TURNED = {name for mode in (1, 4, 5) for name in COMPONENTS[mode]} | {"bulk_1_xy", "bulk_2_xy"}
"""Loads and motions that a mirror image turns round."""

FEWEST_MIRRORED_CELLS = 16 * 16
"""Cells from which halves pay. On 8 x 8 and 12 x 12 points, where calls take all of the time, mode I.3 takes 1.1 times
as long on them; on 16 x 16 0.9 times without numba and 1.05 times with it, on 64 x 64 0.94 and 0.79 times."""

LOAD_SECONDS = 0.8
"""Processor time of loading numba and the compiled kernels from disk, which is longer than most runs on small grids."""

SAVINGS = ((1e-3, 0.25e-6), (2e-3, 0.6e-6), (2e-3, 0.35e-6))
"""Seconds that the compiled kernels save per increment, and per increment and cell: in the normal problem, with the
tangential one as well, and where both are solved in turns. From 32 x 32 to 256 x 256 points the sum is right within a
third (`python benchmarks/bench_path.py`)."""


@dataclass(frozen=True)
class ProblemSetup:
    """A case with the model it needs, its grid, its load path and the closed forms that hold for it.

    case: with the settings that its accuracy picks; heights, automatic_size: read the height maps, and find the sides
    (mm) that hold the contact, when they are first called; sure_contact: returns a coarse grid with the cells that are
    surely in contact under a load; picked: the picked settings in words; compiled: whether the kernels compiled by
    numba are to be used; friction: its law, None where it is one coefficient; wear: its law, None without wear.
    """

    case: Case
    model: Model
    grid: Grid
    load_path: LoadPath
    closed_forms: ClosedForms
    heights: Callable[[], HeightMaps]
    automatic_size: Callable[[], Size]
    sure_contact: Callable[[LoadControl, Grid], tuple[Grid, BoolArray] | None]
    picked: tuple[str, ...] = ()
    compiled: bool = False
    friction: FrictionLaw | None = None
    wear: WearLaw | None = None

    def separation(self) -> DoubleArray:
        """Return the undeformed separation of the surfaces on the grid, ``(nx, ny)`` in mm.

        Raises FileError where a height map cannot be read, CaseError where it does not fit the case.
        """
        with placed(self.case):
            return separation(self.case.surface, self.grid.x, self.grid.y)

    @cached_property
    def on_rig(self) -> RigForms | None:
        """The closed forms of the contact on its rig, or of a line's motion; None without rig or depth."""
        if not moves_with_loads(self.case):
            return None
        from fretsolve.problem.setup.rig_forms import RigForms  # other cases do not need them

        return RigForms(self.case, self.model, (self.model.at_start, *self.load_path.imposed))

    @cached_property
    def mirrored_increments(self) -> int:
        """Number of increments, from the first one on, that are solved on one half of the grid, at least.

        They are mirror images of themselves about y = 0, as some rows of the grid tell.
        """
        if not may_be_mirrored(self.case, self.model, self.grid):
            return 0
        rows = self.grid.x[sorted({quarter * (self.grid.nx - 1) // 4 for quarter in range(5)})]
        field = None if self.friction is None else self.friction.field
        try:
            sampled = [separation(self.case.surface, rows, self.grid.y)]
            sampled += [] if field is None else [field.at(rows, self.grid.y)]
        except (CaseError, FileError):  # a map that the run refuses with its place in the case
            return 0
        if not all(is_mirrored(self.grid, values) for values in sampled):
            return 0
        count = 0
        for stage, increments in zip(self.case.stages(), self.load_path.counts, strict=True):
            if any(value for name, value in stage.targets if name in TURNED):
                break
            count += increments
        return count

    @property
    def share_of_cells(self) -> float:
        """Part of the grid on which increments are solved, a mean over all of them: from one half to 1."""
        return 1.0 - 0.5 * self.mirrored_increments / max(self.load_path.increments, 1)

    @property
    def seconds_saved(self) -> float:
        """Seconds that the compiled kernels save in the increments."""
        cells, model = self.share_of_cells * self.grid.nx * self.grid.ny, self.model
        in_turns = model.has_shear and model.terms.normal_tangential_coupling
        savings = SAVINGS[: 1 + model.has_shear + in_turns]
        return self.load_path.increments * sum(per_call + per_cell * cells for per_call, per_cell in savings)

    def friction_on_grid(self) -> FrictionOnGrid:
        """Return the friction on the grid, from which the friction limit of each increment follows.

        Raises CaseError where the coefficient is not one, or where a map does not give it where the contact at the end
        of a stage surely is.
        """
        if self.friction is None:
            return FrictionOnGrid(self.case.friction, varied=False)
        law = self.friction.on(self.grid)
        if law.unknown is not None and law.unknown.any():
            loads = sorted(set(self.load_path.normal_loads()), key=lambda load: load.values, reverse=True)
            for load in loads[:20]:  # the largest ones
                if (found := self.sure_contact(load, self.grid)) is not None:
                    coarse, contact = found
                    self.friction.on(coarse).require_known(contact, coarse, self.case)
        return law


def moves_with_loads(case: Case) -> bool:
    """Return whether closed forms may turn motions into loads: on a rig, or at a line's reference depth."""
    return case.rig is not None or case.reference_depth is not None


def closed_forms_of(case: Case, model: Model, loads: tuple[Load, ...]) -> ClosedForms:
    """Return the closed forms that hold for a case under `loads` one after another."""
    if moves_with_loads(case):
        from fretsolve.problem.setup.rig_forms import RigForms  # other cases do not need them

        loads = RigForms(case, model, (model.at_start, *loads)).loads[1:]
    if not model.line:
        return ClosedForms(case, model, loads)
    from fretsolve.problem.setup.line_forms import LineClosedForms  # other cases do not need them

    return LineClosedForms(case, model, loads)


def model_of_forms(case: Case) -> Model:
    """Return the model for the closed forms of a case that is not solved.

    Where friction varies they take the limit from the case, so that the coefficient of the model is a scale alone.
    """
    return derive_model(case, 1.0 if case.friction_varies else None)


def may_be_mirrored(case: Case, model: Model, grid: Grid) -> bool:
    """Return whether increments of the model may be solved on one half of the grid."""
    large = grid.nx * grid.ny >= FEWEST_MIRRORED_CELLS
    return large and not model.line and model.orthotropy is None and case.wear is None


def compiling_pays(saved: float) -> bool:
    """Return whether to use the compiled kernels where they save `saved` seconds; the environment may decide it.

    Else the case alone decides, so that a resumed run gives the same bits.
    """
    asked = compiler_asked()
    return compiler_installed() and (saved > LOAD_SECONDS if asked is None else asked)


@contextmanager
def placed(case: Case) -> Iterator[None]:
    """Give errors of surfaces and maps that are raised within the block their place in the case file."""
    try:
        yield
    except CaseError as error:
        raise error if error.file is not None else case.source.problem(error.message, error.key) from None
    except FileError as error:
        maps = [place for place, one in enumerate(case.surface) if one.kind == "heights" and one.file == error.file]
        keys: list[KeyPath] = [("surface", place, "heights", "file") for place in maps]
        if case.friction.map is not None and case.friction.map == error.file:
            keys.append(("friction", "map"))
        if not keys:
            raise
        problem = case.source.problem(f"{error.file}: {error.message}", keys[0])
        place = f"{problem.file}:{problem.line}" if problem.line is not None else str(problem.file)
        raise FileError(f"{dotted(problem.key)}: {problem.message}", place) from None
