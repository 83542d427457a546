"""Solve the increments of a case one after another, as a generator of states."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence

import numpy as np

from fretsolve.case.load_components import PAIRS
from fretsolve.case.models import Case
from fretsolve.elastic.fftw_wisdom import load_wisdom, measured_plans, save_wisdom
from fretsolve.errors import CaseError, GridEdgeError, KeyPath, NoSolutionError
from fretsolve.increment.increment import IncrementSolver, Solved
from fretsolve.increment.working_state import InitialState
from fretsolve.kernels import readying_seconds
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.model.load_path import Increment
from fretsolve.model.surface import map_spans
from fretsolve.result.state import Fields, State, Summary, Zone, nothing
from fretsolve.setup.contact_size import MARGIN, contact_size
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.slip_and_work import ContactState, limit_to_contact, mean_pressure
from fretsolve.simulation.zone_areas import contact_area, stick_area
from fretsolve.system.arrays import FloatArray

FEWEST_CELLS = 8
"""Cells per side; with fewer, a contact reaches the edge because its cells are large."""

WIDER = 1.5
"""Factor on the size in the advice if shear or moments widen the contact."""

RIGID = tuple(motion for _, motion in PAIRS)


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
    setup = case if isinstance(case, ProblemSetup) else set_up(case)
    load_wisdom()
    solver = IncrementSolver(
        setup.grid,
        setup.separation(),
        setup.model,
        setup.case.solver.tolerance,
        setup.case.solver.max_iterations,
        threads,
        setup.map_border(),
        _precision(setup),
    )
    state, summaries, plans = start, list(history), measured_plans()
    for step in range(len(summaries), setup.load_path.increments):
        began = _working_seconds()
        increment = setup.load_path.increment(step, summaries)
        before = setup.load_path.increment(step - 1, summaries).normal if step else None
        try:
            solved = solver.solve(increment, _start(state, before, setup.grid))
        except NoSolutionError as error:
            _locate(error, setup, increment)
            raise
        if measured_plans() > plans:
            # Before the state is yielded: a resumed run must transform by the same plans.
            save_wisdom()
            plans = measured_plans()
        touching = _touching(state, solver.separation)
        state = _state(solved, state, touching, increment, setup, _working_seconds() - began)
        del solved  # frees what the state does not need
        summaries.append(state.summary)
        yield state


def _working_seconds() -> float:
    """Return a clock that stands still while kernels are compiled or read from disk, once in a process."""
    return time.perf_counter() - readying_seconds()


def _start(state: State | None, before: LoadControl | None, grid: Grid) -> InitialState:
    if state is None:
        return InitialState(nothing(grid.shape), nothing((2, *grid.shape)), nothing((2, *grid.shape)), np.zeros(6))
    rigid = np.array([getattr(state.summary, name) for name in RIGID])
    return InitialState(state.fields.pressure, state.fields.shear, state.displacement, rigid, before)


def _touching(state: State | None, separation: FloatArray) -> ContactState:
    """Return the contact after `state`; at first the surfaces touch at their nearest points."""
    if state is None:
        nearest = np.min(separation, where=np.isfinite(separation), initial=np.inf)
        gap = separation - (nearest if np.isfinite(nearest) else 0.0)
        return ContactState(nothing(separation.shape), gap, np.zeros(separation.shape, bool))
    return ContactState(state.fields.pressure, state.fields.gap, state.fields.zone == Zone.SLIP)


def _state(
    solved: Solved,
    previous: State | None,
    before: ContactState,
    increment: Increment,
    setup: ProblemSetup,
    wall_time: float,
) -> State:
    """Return the state after an increment, with slip and dissipated energy accumulated."""
    solution, evidence = solved.solution, solved.evidence
    areas = _areas(solved, setup)
    slip, slip_path, work_density, work = evidence.slip, nothing(setup.grid.shape), nothing(setup.grid.shape), 0.0
    if setup.model.may_slip:
        slip_path, work_density, work = _accumulate(solved, before, previous, setup)
    work_before = 0.0 if previous is None else previous.summary.work_total
    pressure, shear, slip, slip_path, work_density, gap, displacement = (
        _kept(field, _precision(setup))
        for field in (
            solution.pressure, solution.shear, slip, slip_path, work_density, evidence.gap, solution.displacement
        )
    )
    fields = Fields(pressure, shear, slip, slip_path, work_density, evidence.zone, gap)
    for array in (*vars(fields).values(), displacement):
        array.flags.writeable = False  # the next increment starts from these very arrays
    summary = _summary(solved, increment, areas, work, work_before + work, wall_time)
    return State(summary, fields, displacement)


def _precision(setup: ProblemSetup) -> type[np.floating]:
    """Return the precision of the elastic operator and of the fields of the states."""
    return np.float32 if setup.case.solver.precision == "single" else np.float64


def _kept(field: FloatArray, precision: type[np.floating]) -> FloatArray:
    """Return `field` in the precision of the states; `nothing` stays `nothing`."""
    if not any(field.strides):
        return np.broadcast_to(precision(0.0), field.shape)
    return field.astype(precision, copy=False)


def _accumulate(
    solved: Solved, before: ContactState, previous: State | None, setup: ProblemSetup
) -> tuple[FloatArray, FloatArray, float]:
    """Return the slip path and the dissipated energy per area since the start, and the increment's dissipated energy.

    Turns the slip of the increment in `solved` into the slip since the start, in place.
    """
    solution, evidence = solved.solution, solved.evidence
    slip = evidence.slip
    modulus = setup.model.compliances.contact_modulus
    parted = limit_to_contact(slip, before, solution, evidence, setup.grid, modulus)
    slip_path = np.hypot(slip[0], slip[1])
    work_density = setup.model.friction * mean_pressure(before.pressure, solution.pressure)
    work_density *= slip_path
    # The slip of a sticking cell is the certificate's residual, not slip.
    work_density *= (evidence.zone == Zone.SLIP) | parted
    work = float(work_density.sum()) * setup.grid.cell_area
    if previous is not None:
        slip += previous.fields.slip
        slip_path += previous.fields.slip_path
        work_density += previous.fields.work_density
    return slip_path, work_density, work


def _areas(solved: Solved, setup: ProblemSetup) -> tuple[float, float]:
    """Return the areas of the contact and of the stick zone, with their edges placed inside the cells."""
    solution, evidence, materials = solved.solution, solved.evidence, setup.model.compliances
    contact = contact_area(solution.pressure, evidence.gap, setup.grid, materials)
    limit = setup.model.friction * solution.pressure
    fields = solution.pressure, evidence.gap, solution.shear, limit, evidence.slip, evidence.zone
    stick = stick_area(*fields, setup.grid, materials, contact)
    return float(contact), float(stick)


def _summary(
    solved: Solved,
    increment: Increment,
    areas: tuple[float, float],
    work: float,
    work_total: float,
    wall_time: float,
) -> Summary:
    solution, zone = solved.solution, solved.evidence.zone
    contact, stick = areas
    rigid = dict(zip(RIGID, map(float, solution.rigid), strict=True))
    return Summary(
        step=increment.step,
        stage=increment.stage.number,
        **dict(zip(("P", "Mx", "My", "Qx", "Qy", "Mz"), map(float, solved.evidence.resultants), strict=True)),
        **rigid,
        contact_area=contact,
        stick_area=stick,
        contact_radius=math.sqrt(contact / math.pi),
        stick_radius=math.sqrt(stick / math.pi),
        contact_cells=int(np.count_nonzero(zone)),
        stick_cells=int(np.count_nonzero(zone == Zone.STICK)),
        max_pressure=float(solution.pressure.max()),
        max_shear=float(np.hypot(solution.shear[0], solution.shear[1]).max()),
        work=work,
        work_total=work_total,
        iterations_normal=solved.iterations_normal,
        iterations_tangential=solved.iterations_tangential,
        alternations=solved.staggered_iterations,
        operator_applications=solved.operator_applications,
        wall_time=wall_time,
        **{f"residual_{name}": float(value) for name, value in vars(solved.evidence.certificate).items()},
    )


def _locate(error: NoSolutionError, setup: ProblemSetup, increment: Increment) -> None:
    """Add to `error` the place of the load in the case file, and a size that would hold the contact."""
    stage = increment.stage
    key: KeyPath = stage.key
    if error.component in dict(stage.targets):
        key = (*key, error.component)
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
        size = contact_size(surfaces, materials, loads, setup.grid.center, max(setup.grid.size))
    except CaseError:
        return "; no size would hold it"
    contact = tuple(side / MARGIN for side in size)
    if any(span < 1.05 * side for spans in map_spans(surfaces) for span, side in zip(spans, contact, strict=True)):
        return "; no size would do, since the height map ends too soon: a larger map is needed"
    if all(advised <= 1.05 * present for advised, present in zip(size, setup.grid.size, strict=True)):
        if min(setup.grid.shape) < FEWEST_CELLS:
            return "; the size would do with more points, which resolve the contact"
        wider = tuple(WIDER * present for present in setup.grid.size)
        advice = f"try size: [{wider[0]:.3g} mm, {wider[1]:.3g} mm]"
        return f"; the size would hold the contact under the normal load alone: {advice}"
    return f"; size: [{size[0]:.3g} mm, {size[1]:.3g} mm] would do"
