"""Solve the increments of a case one after another, as a generator of states."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.case.models import Case
from fretsolve.elastic.fftw import load_wisdom, measured_plans, save_wisdom
from fretsolve.errors import CaseError, GridEdgeError, KeyPath, NoSolutionError
from fretsolve.increment.certificate import Solution
from fretsolve.increment.increment import IncrementSolver, Solved
from fretsolve.increment.working_state import InitialState, Trend
from fretsolve.kernels import load, readying_seconds
from fretsolve.model.load_path import Increment, LoadPath
from fretsolve.model.required_terms import Model
from fretsolve.model.surface import map_border, map_spans
from fretsolve.result.state import Change, Fields, State, Summary, Zone, nothing
from fretsolve.setup.contact_size import AREA_MARGIN, contact_size, worn_reach
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.slip_and_work import limit_to_contact, mean_pressure
from fretsolve.simulation.zones.area_contact import UNMEASURED, AreaContact
from fretsolve.system.arrays import DoubleArray, FloatArray, Vector, vector_lengths

LARGEST_GROWTH = 3.0
"""Load step over the one before it up to which an increment is estimated by that one."""

LEAST_TOLERANCE = 1e-8
"""Tolerance from which the rounding of `Change` does no harm."""

LEAST_CELLS = 96 * 96
"""Cells from which an increment of a run that may be saved is so estimated. It takes mode I.3 on 128 x 128 cells to 0.8
of the time. Up to 64 x 64 a saved run takes as long either way, since the estimate's part is saved, too."""

if TYPE_CHECKING:
    from fretsolve.simulation.zones.line_contact import LineContact
    from fretsolve.wear.worn_surfaces import WornSurfaces

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
    measured: Callable[[int], bool] | None = None,
) -> Iterator[State]:
    """Yield the states of a problem as `run` does.

    measured: for runs that are not saved, whether the zones are measured after an increment; else their sizes are NaN.
    """
    load_wisdom()
    limits = setup.case.solver.tolerance, setup.case.solver.max_iterations
    separation, precision = setup.separation(), _precision(setup)
    border = map_border(setup.case.surface, setup.grid.x, setup.grid.y)
    kernels = load(setup.compiled)
    solver = _solver_type(setup.model)(
        setup.grid, separation, setup.model, *limits, threads, border, precision, kernels
    )
    contact = _contact(setup, solver)
    friction = setup.friction_on_grid()
    fields, displacement = (start.fields, start.displacement) if start is not None else _unloaded(separation)
    change = start.change if start is not None else None
    wear = None if setup.wear is None else _worn_surfaces(setup, contact.solver, separation, start)
    starts_with_gap = _starts_with_gap(setup)
    summaries, plans = list(history), measured_plans()
    path = setup.load_path.followed(summaries)
    while (step := len(summaries)) < (path := path.after(summaries)).increments:
        began = _working_seconds()
        increment = path.increment(step, summaries)
        before = path.increment(step - 1, summaries).normal if step else None
        rigid = contact.rigid_start(fields, _rigid(summaries))
        trend = _trend(change, path, summaries)
        try:
            bound = None if friction is None else friction.bound(fields, _coefficient(increment, setup, summaries))
            if bound is not None and setup.model.friction_evolves:
                from fretsolve.friction.weakening import require_stable  # few cases need it

                require_stable(setup.case.friction, fields.pressure, bound, contact.solver.level.operator)
            gap = fields.gap if step and starts_with_gap else None
            begin = InitialState(
                fields.pressure, fields.shear, displacement, rigid, before, trend=trend, friction=bound, gap=gap
            )
            if increment.stretch is not None:
                from fretsolve.increment.bulk_mismatch import with_mismatch  # few cases have bulk stress

                # scaled slips of friction along two axes do not turn as a whole
                turns = setup.model.orthotropy is None
                begin = with_mismatch(begin, increment.stretch, setup.grid, turns=turns)
            if wear is not None:
                begin = wear.begin(increment, begin, fields, path, summaries)
            solved = contact.solver.solve(increment, begin)
            if friction is not None:
                friction.require_known(solved.solution.pressure > 0.0, setup.grid, setup.case)
        except NoSolutionError as error:
            _locate(error, setup, increment)
            raise
        if measured_plans() > plans:
            # Before the state is yielded: a resumed run must transform by the same plans.
            save_wisdom()
            plans = measured_plans()
        # from the slip of this increment, which the next line adds to that before
        sizes = contact.sizes(solved) if measured is None or measured(step) else UNMEASURED
        trend = change = None  # before the arrays of the new state are made
        begin = replace(begin, trend=None)
        last = fields
        fields, displacement, work = _fields(solved, last, setup)
        change = _change(begin, solved) if _has_trend(setup, path, step + 1, saved=measured is None) else None
        work_total = (summaries[-1].work_total if step else 0.0) + work
        summary = _summary(solved, increment, sizes, work, work_total, _working_seconds() - began)
        summary = contact.with_displacements(summary, solved)
        if wear is not None:
            pressure = mean_pressure(last.pressure, fields.pressure)
            summary = wear.count(increment, summary, last, fields, solved.solution, pressure, path, summaries)
            fields = _read_only(wear.fields(fields, setup.case.output.fields))
        del solved, begin, last  # frees what the state does not need
        summaries.append(summary)
        yield State(summary, fields, displacement, change=change, wear=None if wear is None else wear.state)


def _coefficient(increment: Increment, setup: ProblemSetup, history: Sequence[Summary]) -> float | None:
    """Return the coefficient of friction that the load path sets in an increment, None without one.

    That of a cycle is by the number of cycles so far, where solved ones stand for others.
    """
    friction = setup.case.friction
    if setup.wear is None or friction.cycles is None:
        return increment.friction
    return friction.in_cycle((history[-1].cycles if history else 0.0) + 1.0)


def _has_trend(setup: ProblemSetup, path: LoadPath, step: int, *, saved: bool) -> bool:
    """Return whether to estimate `step` by the increment before it: in a stage, under shear, within the rounding.

    saved: whether the states may be saved, which takes longer with the change of an increment.
    """
    model, solver, growth = setup.model, setup.case.solver, path.growth(step)
    usual = model.has_shear and model.bulk is None and not model.line and model.orthotropy is None
    usual = usual and (not saved or math.prod(setup.grid.shape) >= LEAST_CELLS)
    accurate = solver.precision == "double" and solver.tolerance >= LEAST_TOLERANCE
    return usual and accurate and growth is not None and growth <= LARGEST_GROWTH


def _trend(change: Change | None, path: LoadPath, summaries: Sequence[Summary]) -> Trend | None:
    """Return what the next increment is expected to change, from the change over the last one."""
    if change is None:
        return None
    growth = path.growth(len(summaries))
    assert growth is not None  # else there is no change
    return Trend(growth, change, _rigid(summaries) - _rigid(summaries[:-1]))


def _starts_with_gap(setup: ProblemSetup) -> bool:
    """Return whether increments start with the gap before them, which tells the normal displacement.

    That is where shear causes a part of it, so that two convolutions are needed otherwise.
    """
    model, single = setup.model, setup.case.solver.precision == "single"
    coupled = model.has_shear and model.terms.normal_tangential_coupling
    return coupled and not (single or model.line) and setup.wear is None and model.orthotropy is None


def _rigid(summaries: Sequence[Summary]) -> Vector:
    """Return the rigid displacements after the last of some increments, (6,)."""
    return np.array([getattr(summaries[-1], name) for name in RIGID]) if summaries else np.zeros(6)


def _change(initial: InitialState, solved: Solved) -> Change:
    """Return the change over an increment."""
    solution = solved.solution
    change = Change(
        pressure=(solution.pressure - initial.pressure).astype(np.float32),
        shear=(solution.shear - initial.shear).astype(np.float32),
        displacement=solution.displacement - initial.displacement,
    )
    for array in vars(change).values():
        array.flags.writeable = False
    return change


def _solver_type(model: Model) -> type[IncrementSolver]:
    """Return the class that solves a model's increments. Most cases need none of the others."""
    if model.line:
        from fretsolve.increment.line_increment import LineIncrementSolver

        return LineIncrementSolver
    if model.orthotropy is not None:
        from fretsolve.increment.orthotropic_increment import OrthotropicIncrementSolver

        return OrthotropicIncrementSolver
    return IncrementSolver


def _contact(setup: ProblemSetup, solver: IncrementSolver) -> AreaContact | LineContact:
    """Return the contact of a problem."""
    if not setup.model.line:
        return AreaContact(setup, solver)
    from fretsolve.simulation.zones.line_contact import LineContact  # other cases need none of it

    return LineContact.of(setup, solver)


def _worn_surfaces(
    setup: ProblemSetup, solver: IncrementSolver, separation: DoubleArray, start: State | None
) -> WornSurfaces:
    """Return the surfaces of a problem with wear, which change in place the `separation` that the solver refers to."""
    from fretsolve.wear.worn_surfaces import WornSurfaces  # other cases need none of it

    assert setup.wear is not None
    return WornSurfaces(setup.wear, setup.case.friction, solver, separation, None if start is None else start.wear)


def _working_seconds() -> float:
    """Return a clock that stands still while kernels are compiled or read from disk, once in a process."""
    return time.perf_counter() - readying_seconds()


def _unloaded(separation: FloatArray) -> tuple[Fields, FloatArray]:
    """Return fields and displacement before the first increment: the surfaces touch at their nearest points."""
    nearest = np.min(separation, where=np.isfinite(separation), initial=np.inf)
    gap = separation - (nearest if np.isfinite(nearest) else 0.0)
    scalar, vector = nothing(separation.shape), nothing((2, *separation.shape))
    return Fields(scalar, vector, vector, scalar, scalar, np.zeros(separation.shape, np.uint8), gap), vector


def _fields(solved: Solved, before: Fields, setup: ProblemSetup) -> tuple[Fields, FloatArray, float]:
    """Return fields and displacement after an increment, and the energy dissipated in it."""
    solution, evidence = solved.solution, solved.evidence
    slip_path, work_density, work = nothing(setup.grid.shape), nothing(setup.grid.shape), 0.0
    if setup.model.may_slip:
        slip_path, work_density, work = _accumulate(solved, before, setup)
    kept = partial(_kept, precision=_precision(setup))
    friction, bound = _friction_fields(solution, setup)
    fields = Fields(
        pressure=kept(solution.pressure),
        shear=kept(solution.shear),
        slip=kept(evidence.slip),
        slip_path=kept(slip_path),
        work_density=kept(work_density),
        zone=evidence.zone,
        gap=kept(evidence.gap),
        friction=None if friction is None else kept(friction),
        shear_bound=None if bound is None else kept(bound),
    )
    displacement = kept(solution.displacement)
    displacement.flags.writeable = False
    return _read_only(fields), displacement, work


def _read_only(fields: Fields) -> Fields:
    """Return the fields as arrays that cannot be written to: the next increment starts from these very arrays."""
    for array in vars(fields).values():
        if array is not None:
            array.flags.writeable = False
    return fields


def _friction_fields(solution: Solution, setup: ProblemSetup) -> tuple[FloatArray | None, FloatArray | None]:
    """Return the coefficient of friction and the friction limit (MPa), (nx, ny); None for what is not stored."""
    stored, coefficient = setup.case.output.fields, setup.model.friction
    friction = bound = None
    if "friction" in stored and solution.friction is None:
        friction = np.full(setup.grid.shape, coefficient)
    elif "friction" in stored and solution.friction is not None:
        friction = np.array(np.broadcast_to(solution.friction.coefficient_at(solution.pressure), setup.grid.shape))
    if "shear_bound" in stored:
        bound = solution.friction_limit(coefficient)
    return friction, bound


def _precision(setup: ProblemSetup) -> type[np.floating]:
    """Return the precision of the elastic operator and of the fields of the states."""
    return np.float32 if setup.case.solver.precision == "single" else np.float64


def _kept(field: FloatArray, precision: type[np.floating]) -> FloatArray:
    """Return `field` in the precision of the states; `nothing` stays `nothing`."""
    if not any(field.strides):
        return np.broadcast_to(precision(0.0), field.shape)
    return field.astype(precision, copy=False)


def _accumulate(solved: Solved, before: Fields, setup: ProblemSetup) -> tuple[FloatArray, FloatArray, float]:
    """Return the slip path and the dissipated energy per area since the start, and the increment's dissipated energy.

    Turns the slip of the increment in `solved` into the slip since the start, in place.
    """
    solution, evidence = solved.solution, solved.evidence
    slip = evidence.slip
    modulus = setup.model.compliances.contact_modulus
    parted = limit_to_contact(slip, before, solution, evidence, setup.grid, modulus)
    slip_path = vector_lengths(slip)
    mean, bound = mean_pressure(before.pressure, solution.pressure), solution.friction
    work_density = setup.model.friction * mean if bound is None else bound.limit(mean)
    orthotropy = setup.model.orthotropy
    work_density *= slip_path if orthotropy is None else vector_lengths(orthotropy.times(slip))
    # The slip of a sticking cell is the certificate's residual, not slip.
    work_density *= (evidence.zone == Zone.SLIP) | parted
    work = float(work_density.sum()) * setup.grid.cell_area
    slip += before.slip
    slip_path += before.slip_path
    work_density += before.work_density
    return slip_path, work_density, work


def _summary(
    solved: Solved, increment: Increment, sizes: dict[str, Any], work: float, work_total: float, wall_time: float
) -> Summary:
    solution, zone = solved.solution, solved.evidence.zone
    loads_and_motions = map(float, (*solved.evidence.resultants, *solution.rigid))
    certificate = vars(solved.evidence.certificate).items()
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
        max_pressure=float(solution.pressure.max()),
        max_shear=float(np.hypot(solution.shear[0], solution.shear[1]).max()),
        work=work,
        work_total=work_total,
        iterations_normal=solved.iterations_normal,
        iterations_tangential=solved.iterations_tangential,
        alternations=solved.staggered_iterations,
        operator_applications=solved.operator_applications,
        wall_time=wall_time,
    )


def _locate(error: NoSolutionError, setup: ProblemSetup, increment: Increment) -> None:
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
    worn = 2.0 * AREA_MARGIN * worn_reach(setup.closed_forms)
    size = (max(size[0], worn), max(size[1], worn))
    if all(advised <= 1.05 * present for advised, present in zip(size, setup.grid.size, strict=True)):
        if min(setup.grid.shape) < 8:  # the contact reaches the edge because its cells are large
            return "; the size would do with more points, which resolve the contact"
        wider = tuple(1.5 * present for present in setup.grid.size)  # since shear or moments widen the contact
        return f"; the size would hold the contact under the normal load alone: try {_size_in_words(wider, setup)}"
    return f"; {_size_in_words(size, setup)} would do"


def _size_in_words(size: tuple[float, ...], setup: ProblemSetup) -> str:
    """Return the key `size` of a case, which is one number in a line contact."""
    sides = [f"{side:.3g} mm" for side in size]
    return f"size: {sides[0]}" if setup.model.line else f"size: [{', '.join(sides)}]"
