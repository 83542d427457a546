"""Solve the increments of a case one after another, as a generator of states."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from fretsolve.case.dimensions import in_small_unit
from fretsolve.case.history import PAIRS
from fretsolve.case.models import Case
from fretsolve.contact.increment.increment import IncrementSolver, OrthotropicIncrementSolver, Solved
from fretsolve.contact.increment.line_increment import LineIncrementSolver
from fretsolve.contact.increment.mirrored_increment import MirroredIncrementSolver
from fretsolve.contact.increment.states import InitialState, Prediction, with_mismatch
from fretsolve.contact.zones.area_contact import AreaContact
from fretsolve.contact.zones.line_contact import LineContact
from fretsolve.elastic.kernels import load, readying_seconds
from fretsolve.errors import CaseError, GridEdgeError, KeyPath, NoSolutionError
from fretsolve.problem.friction.limit import FrictionLimit, FrictionOnGrid, require_stable, require_stable_on_rig
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.model.rig import Rig
from fretsolve.problem.setup.picked_settings import AREA_MARGIN, room_for_cells, worn_reach
from fretsolve.problem.setup.problem import ProblemSetup, may_be_mirrored
from fretsolve.problem.surface.separation import is_mirrored, map_border, map_spans, map_without_point
from fretsolve.result.history import History
from fretsolve.result.state import Before, Fields, State, Summary, Zone
from fretsolve.simulation.fields_of_increment import fields_of, mean_pressure, precision_of, read_only, unloaded
from fretsolve.simulation.problem_setup import contact_size, set_up
from fretsolve.system.arrays import BoolArray, DoubleArray, Vector, vector_lengths

LOADS, RIGID = zip(*PAIRS, strict=True)


def run(
    case: Case | ProblemSetup, start: State | None = None, history: Sequence[Summary] = (), threads: int = 1
) -> Iterator[State]:
    """Solve `case` and yield a `State` per increment, each certified.

    start, history: the last state and the summaries of all increments so far, to go on from; threads: number of threads
    that share the transforms, on which no bit of a state depends.
    Raises NoSolutionError if an increment has no solution or none was found; the states before it hold.
    """
    if not isinstance(case, Case | ProblemSetup):
        raise TypeError(f"a case is needed, as load_case gives it, not {case!r}")
    if (start.summary.step + 1 if start is not None else 0) != len(history):
        raise ValueError("start must be the state after the last increment of history, or both be left out")
    yield from states_of(case if isinstance(case, ProblemSetup) else set_up(case), start, history, threads)


def states_of(
    setup: ProblemSetup,
    start: State | None = None,
    history: Sequence[Summary] = (),
    threads: int = 1,
    solver: Callable[[], IncrementSolver] | None = None,
) -> Iterator[State]:
    """Yield the states of a problem as `run` does.

    solver: gives the solver of another run of the same problem without wear, which may take turns with this one: an
    increment depends on its start alone.
    """
    contact = _contact(setup, increment_solver(setup, setup.separation(), threads) if solver is None else solver())
    separation = contact.solver.separation
    team = contact.solver.team
    friction = setup.friction_on_grid()
    fields, displacement = (start.fields, start.displacement) if start is not None else unloaded(separation)
    wear = None
    if setup.wear is not None:  # which changes in place the `separation` that the solver refers to
        from fretsolve.wear.worn_surfaces import WornSurfaces  # other cases do not need it

        worn = None if start is None else start.wear
        wear = WornSurfaces(setup.wear, setup.case.friction, contact.solver, separation, worn)
    # lines are solved directly; in scaled tractions and in single precision differences of displacements are no slip
    predicts = setup.model.has_shear and not setup.model.line
    predicts = predicts and setup.model.orthotropy is None and precision_of(setup) is np.float64
    past = None if start is None else start.before
    summaries = history if isinstance(history, History) else History(history)
    path = setup.load_path.followed(summaries)
    # The slip before a loss of contact has left no shear traction. Nothing is kept of that since then alone, so that
    # edges of the stick zone follow from the increment's, as where cells have slipped before.
    lost = _loses_contact(summaries)
    touched = None
    if any(surface.kind == "heights" for surface in setup.case.surface):
        touched = np.zeros(setup.grid.shape, bool)
    while (step := len(summaries)) < (path := path.after(summaries)).increments:
        began = _working_seconds()
        increment = path.increment(step, summaries)
        before = path.increment(step - 1, summaries).normal if step else None
        rigid = contact.rigid_start(fields, _rigid(summaries))
        try:
            coefficient = _coefficient(increment, setup, summaries)
            limit = _friction_limit(friction, fields, coefficient, setup, contact.solver)
            begin = InitialState(fields.pressure, fields.shear, displacement, rigid, limit, before)
            if past is not None and (growth := path.growth(step)) is not None:
                moved = _rigid(summaries) - _rigid(summaries[-2:-1])
                begin = replace(begin, prediction=Prediction.of(growth, fields, displacement, past, moved))
            if increment.strain_mismatch is not None:
                # scaled slips of friction along two axes do not turn as a whole
                turns = setup.model.orthotropy is None
                begin = with_mismatch(begin, increment.strain_mismatch, setup.grid, turns=turns)
            if wear is not None:
                begin = wear.begin(increment, begin, fields, path, summaries)
            solved = contact.solver.solve(increment, begin)
            friction.require_known(solved.pressure > 0.0, setup.grid, setup.case)
        except NoSolutionError as error:
            locate(error, setup, increment)
            raise
        # from the slip of this increment, which the next line adds to that before
        sizes = contact.sizes(solved, np.zeros_like(fields.slip) if lost else fields.slip)
        last = fields
        goes_on = predicts and path.growth(step + 1) is not None  # else nothing is to be kept or saved
        past = Before(last.pressure, last.shear, displacement) if goes_on else None
        fields, displacement, work = fields_of(solved, last, setup, team)
        if setup.model.friction_evolves:
            _require_stable_on_rig(setup, increment, limit, last, fields, contact.solver)
        total = (summaries[-1].work_total if step else 0.0) + work
        summary = _summary(solved, increment, sizes, work, total, _working_seconds() - began)
        summary = contact.with_displacements(summary, solved, increment)
        if setup.model.rig is not None:
            summary = _with_actuator(summary, setup.model.rig, increment)
        if wear is not None:
            mean = mean_pressure(last.pressure, fields.pressure)
            summary = wear.count(summary, increment, last, fields, solved, mean)
            fields = read_only(wear.fields(fields, setup.case.output.fields))
        if touched is not None:
            touched |= fields.pressure > 0.0
        del solved, begin, last  # frees what the state does not need
        summaries.append(summary)
        lost = lost or _loses_contact(summaries[-2:])
        yield State(summary, fields, displacement, wear=None if wear is None else wear.state, before=past)
    if touched is not None and touched.any():
        _require_map_point(setup, touched, increment)


def increment_solver(
    setup: ProblemSetup, separation: DoubleArray, threads: int, to_map_end: bool = False
) -> IncrementSolver:
    """Return the solver of a problem's increments.

    separation: of the undeformed surfaces; to_map_end: whether the contact may reach the last cells of a height map, as
    if it were the end of the material. Otherwise such an increment has no solution.
    """
    border = None if to_map_end else map_border(setup.case.surface, setup.grid.x, setup.grid.y)
    return _solver_type(setup, separation)(
        setup.grid,
        separation,
        setup.model,
        setup.case.solver.tolerance,
        setup.case.solver.max_iterations,
        threads,
        border,
        precision_of(setup),
        load(setup.compiled),
    )


def _require_map_point(setup: ProblemSetup, touched: BoolArray, increment: Increment) -> None:
    """Raise NoSolutionError if no point of a height map lies in what has been in contact, (nx, ny)."""
    height_map = map_without_point(setup.case.surface, setup.grid, touched)
    if height_map is None:
        return
    apart = " x ".join(in_small_unit(step, 4) for step in height_map.spacing)
    error = NoSolutionError(
        f"no point of the height map lies in the contact, so nothing is known of the surface there: its points are"
        f" {apart} apart; check unit and spacing, or take a finer map"
    )
    locate(error, setup, increment)
    raise error


def _friction_limit(
    friction: FrictionOnGrid, fields: Fields, coefficient: float | None, setup: ProblemSetup, solver: IncrementSolver
) -> FrictionLimit:
    """Return the friction limit in an increment that starts from `fields`; coefficient: that the load path sets.

    Raises WeakeningError where friction falls so fast with slip that slip runs away.
    """
    limit = friction.limit(fields, coefficient)
    if setup.model.friction_evolves:
        require_stable(setup.case.friction, fields.pressure, limit, solver.level.operator.tangential)
    return limit


def _require_stable_on_rig(
    setup: ProblemSetup,
    increment: Increment,
    limit: FrictionLimit,
    last: Fields,
    fields: Fields,
    solver: IncrementSolver,
) -> None:
    """Raise WeakeningError where the contact slides as a whole, and friction falls faster with slip than a rig unloads.

    limit: in the increment from `last` to `fields`.
    """
    compliance, zone = solver.in_series(increment), fields.zone
    if not compliance.any() or (zone == Zone.STICK).any() or not (zone == Zone.SLIP).any():
        return
    modes, tangential = solver.level.tangential.modes, solver.level.operator.tangential
    given = np.empty(fields.shear.shape)

    def on_rig(shear: DoubleArray, out: DoubleArray) -> None:
        tangential(shear, out)
        modes.displacement(compliance @ modes.resultants(shear), given)
        out += given

    motions = [RIGID[3 + mode] for mode in increment.tangential.sprung_index]
    try:
        require_stable_on_rig(setup.case.friction, last.pressure, limit, on_rig, fields.shear, motions)
    except NoSolutionError as error:
        locate(error, setup, increment)
        raise


def _coefficient(increment: Increment, setup: ProblemSetup, history: Sequence[Summary]) -> float | None:
    """Return the coefficient of friction that the load path sets in an increment, None without one.

    That of a cycle is by the number of cycles so far, where solved ones stand for others.
    """
    friction = setup.case.friction
    if setup.wear is None or friction.cycles is None:
        return increment.friction
    return friction.in_cycle((history[-1].cycles if history else 0.0) + 1.0)


def _loses_contact(history: Sequence[Summary]) -> bool:
    return any(before.contact_cells and not after.contact_cells for before, after in pairwise(history))


def _rigid(summaries: Sequence[Summary]) -> Vector:
    """Return the rigid displacements after the last of some increments, (6,)."""
    return np.array([getattr(summaries[-1], name) for name in RIGID]) if summaries else np.zeros(6)


def _solver_type(setup: ProblemSetup, separation: DoubleArray) -> type[IncrementSolver]:
    """Return the class that solves a problem's increments."""
    model = setup.model
    if model.line:
        return LineIncrementSolver
    if model.orthotropy is not None:
        return OrthotropicIncrementSolver
    if may_be_mirrored(setup.case, model, setup.grid) and is_mirrored(setup.grid, separation):
        return MirroredIncrementSolver
    return IncrementSolver


def _contact(setup: ProblemSetup, solver: IncrementSolver) -> AreaContact | LineContact:
    return LineContact.of(setup, solver) if setup.model.line else AreaContact(setup, solver)


def _working_seconds() -> float:
    """Return a clock that stands still while kernels are compiled or read from disk, once in a process."""
    return time.perf_counter() - readying_seconds()


def _summary(
    solved: Solved, increment: Increment, sizes: dict[str, Any], work: float, work_total: float, wall_time: float
) -> Summary:
    zone, certificate = solved.zone, vars(solved.certificate).items()
    loads_and_motions = map(float, (*solved.resultants, *solved.rigid))
    values: dict[str, Any] = {
        **dict(zip((*LOADS, *RIGID), loads_and_motions, strict=True)),
        **increment.bulk,
        **sizes,
        **{f"residual_{name}": float(value) for name, value in certificate},
    }
    return Summary(
        step=increment.step,
        stage=increment.stage.number,
        **values,
        contact_cells=int(np.count_nonzero(zone)),
        stick_cells=int(np.count_nonzero(zone == Zone.STICK)),
        max_pressure=float(solved.pressure.max()),
        max_shear=float(vector_lengths(solved.shear).max()),
        work=work,
        work_total=work_total,
        iterations_normal=solved.iterations_normal,
        iterations_tangential=solved.iterations_tangential,
        alternations=solved.staggered_iterations,
        operator_applications=solved.operator_applications,
        wall_time=wall_time,
    )


def _with_actuator(summary: Summary, rig: Rig, increment: Increment) -> Summary:
    """Return a row of the history with the motions of the actuator, imposed ones as they are, and the rig's energy."""
    motions, loads = (np.array([getattr(summary, name) for name in names]) for names in (RIGID, LOADS))
    found: dict[str, Any] = rig.actuator(motions, loads)
    return replace(summary, **found | increment.actuator, spring_energy=rig.energy(loads))


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
    # of three points of a side one can be in contact, and the points beside it are free
    if any(points < 3 for _, points, _ in sides):
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
