"""From a result, or a file of its stresses, to the cycle of which fatigue parameters are computed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fretsolve.errors import CaseError, FileError
from fretsolve.fatigue.cycle import require_reversals, require_states
from fretsolve.fatigue.fatigue_file import FatigueCycles
from fretsolve.fatigue.request import FatigueRequest
from fretsolve.fatigue.stress_cycle import StressCycle, cycle_of, elastic_body
from fretsolve.stress.names import ComputedFile
from fretsolve.stress.request import StressRequest, least_depth, stress_request
from fretsolve.stress.stress_file import bodies_of
from fretsolve.stress.tractions import TractionHistory, cycle_ends, last_cycle
from fretsolve.system.working_folder import working_folder


@contextmanager
def stresses_beside(target: Path) -> Iterator[Path]:
    """Yield the name of a file of stresses that is removed at the end of the block. Raises OSError."""
    with working_folder(target) as folder:
        yield folder / "stress.h5"


def stresses_of_cycle(tractions: TractionHistory, request: FatigueRequest) -> StressRequest:
    """Return the stresses of the last cycle that a request takes.

    Raises CaseError, before anything is computed, also for what is wrong with material and average.
    """
    result = tractions.result
    try:
        steps = last_cycle(result)
    except CaseError as error:
        advice = "`fretsolve stress --step` writes stresses of chosen increments, which `fretsolve fatigue` takes too"
        raise CaseError(f"{error.message}; {advice}", (), result.path) from None
    try:
        require_states(len(steps))
        require_reversals(cycle_ends(result), result.steps)
    except CaseError as error:
        raise CaseError(error.message, (), result.path) from None
    try:
        if request.average is not None:
            request.average.require_length((tractions.grid.dx, tractions.grid.dy))
    except CaseError as error:
        raise CaseError(error.message, (), result.path) from None
    depths = request.stress_depths(least_depth(tractions))
    found = stress_request(tractions, steps, request.bodies, depths, window=request.window)
    for body in found.bodies:
        elastic = result.effective_case["bodies"][body - 1]
        request.material.with_elastic_constants(elastic).require(request.criteria)
    return found


def cycles_of(file: ComputedFile | None, stresses: Path, origin: Path, request: FatigueRequest) -> FatigueCycles:
    """Return the cycles in `file`, the open file of `stresses`; origin: the file that messages name.

    Raises CaseError, FileError.
    """
    if file is None:
        raise FileError("is not a file of stresses, which `fretsolve stress` writes", stresses)
    found, attributes = bodies_of(file, stresses), file.attributes
    for number in request.bodies:
        if number not in found:
            there = " and ".join(f"body {one}" for one in found)
            raise CaseError(f"there are no stresses of body {number}, only of {there}", (), origin)
    cycles, materials = {}, {}
    for number, body in found.items():
        if request.bodies and number not in request.bodies:
            continue
        own = request.material.with_elastic_constants(elastic_body(attributes, number))
        own.require(request.criteria)
        cycles[int(number)] = StressCycle(origin, body, cycle_of(body, attributes), request.average)
        materials[int(number)] = own.material
    average = request.average
    texts = {"average": "" if average is None else f"{average.kind} over {average.length:g} mm"}
    texts |= {"material": next(iter(materials.values())).model_dump_json(exclude_none=True)}
    texts |= {name: str(attributes[name]) for name in ("title", "result", "effective_case") if name in attributes}
    return FatigueCycles(request, cycles, materials, texts)
