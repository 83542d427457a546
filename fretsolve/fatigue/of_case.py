"""Compute the fatigue parameters that a case asks for by `output.fatigue`, at the end of its run."""

from __future__ import annotations

from pathlib import Path

from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.fatigue.averaging import Average
from fretsolve.fatigue.cycle import require_reversals, require_states
from fretsolve.fatigue.fatigue_file import write_fatigue
from fretsolve.fatigue.material_file import MaterialSource
from fretsolve.fatigue.names import fatigue_path
from fretsolve.fatigue.of_result import cycles_of, stresses_beside, stresses_of_cycle
from fretsolve.fatigue.request import SMALLER, FatigueRequest
from fretsolve.result import Result
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.stress.names import opened_computed
from fretsolve.stress.of_case import request_before, room_problem
from fretsolve.stress.stress_file import write_stress
from fretsolve.stress.tractions import TractionHistory, cycle_stages
from fretsolve.system.files import writing

KEY = ("output", "fatigue")


def case_request(case: Case) -> FatigueRequest:
    """Return what a case with `output.fatigue` asks for."""
    spec = case.output.fatigue
    assert spec is not None
    return FatigueRequest(
        MaterialSource(spec.material, case.source, (*KEY, "material")),
        spec.criteria,
        None if spec.average is None else Average(spec.average.kind, spec.average.length),
        spec.bodies,
        spec.depths,
    )


def require_fatigue(setup: ProblemSetup, free_disk: int | None = None) -> None:
    """Raise CaseError, before the run, if the fatigue parameters of a case could not be computed after it.

    free_disk: bytes for the stresses of the cycle, None where that is unknown.
    """
    case, grid = setup.case, setup.grid
    request = case_request(case)
    for number, body in enumerate(case.bodies, start=1):
        chosen = number in request.bodies if request.bodies else number == (1 if case.bodies[1] == "rigid" else 2)
        if chosen and body != "rigid":
            request.material.with_elastic_constants(body.model_dump()).require(request.criteria)
    if request.average is not None:
        try:
            request.average.require_length((grid.dx, grid.dx if setup.model.line else grid.dy))
        except CaseError as error:
            raise case.source.problem(error.message, (*KEY, "average")) from None
    stored, ends = _cycle(setup)
    states = len(stored)
    try:
        require_states(states)
        require_reversals(ends, stored)
    except CaseError as error:
        raise case.source.problem(error.message, ("output", "every")) from None
    depths = request.stress_depths(0.5 * max(grid.dx, grid.dy))
    problem = room_problem(request_before(request.bodies, depths, states, grid.shape), free_disk, SMALLER)
    if problem is not None:
        raise case.source.problem(problem, KEY)


def write_case_fatigue(result: Result, case: Case, threads: int = 1) -> Path:
    """Write the fatigue parameters of a finished run beside its result, and return the name of the file.

    Raises CaseError, FileError.
    """
    target, request, tractions = fatigue_path(result.path), case_request(case), TractionHistory(result)
    with writing(target), stresses_beside(target) as stresses:
        write_stress(tractions, stresses_of_cycle(tractions, request), stresses, threads)
        with opened_computed(stresses) as file:
            write_fatigue(cycles_of(file, stresses, result.path, request), target)
    return target


def _cycle(setup: ProblemSetup) -> tuple[list[int], list[int]]:
    """Return the increments of the last cycle that will be stored, with the one before it, and its stages' ends."""
    path, every = setup.load_path, setup.case.output.every
    stages = cycle_stages(setup.case, len(path.last_steps))
    assert stages is not None  # the case has been checked
    first, last = stages
    ends = [path.last_steps[stage - 1] for stage in range(max(first, 1), last + 1)]
    begin = ends[0] if first else 0
    stored = [step for step in range(begin, ends[-1] + 1) if (step + 1) % every == 0 or step == path.increments - 1]
    return stored, ends
