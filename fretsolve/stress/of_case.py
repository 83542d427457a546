"""Write the stresses that a case asks for by `output.stress`, at the end of its run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fretsolve.case.keys.output_spec import StressSpec
from fretsolve.result import Result
from fretsolve.result.state import stage_ends
from fretsolve.stress.halfspace.influence import COMPONENTS, TRACTIONS, Body, Component
from fretsolve.stress.names import stress_path
from fretsolve.stress.request import GRADED, StressRequest, WindowKind, disk_problem, memory_problem, stress_request
from fretsolve.stress.stress_file import write_stress
from fretsolve.stress.tractions import TractionHistory
from fretsolve.system.files import writing

AS_KEYS = "fewer depths or components, a larger every, or window: auto is needed"
"""What makes `output.stress` smaller."""


def case_request(tractions: TractionHistory, spec: StressSpec) -> StressRequest:
    """Return what a case asks for of its result. Raises CaseError."""
    return stress_request(
        tractions,
        increments_of(tractions.result, spec.every),
        spec.bodies,
        spec.depths,
        window=spec.window,
        stored=spec.components,
    )


def increments_of(result: Result, every: int | None) -> tuple[int, ...]:
    """Return every n-th of the increments with fields and the last one, or, for None, those at the ends of stages."""
    if every is not None:
        return tuple(step for step in result.steps if (step + 1) % every == 0 or step == result.steps[-1])
    ends = set(stage_ends(result.history["stage"]).tolist())
    return tuple(step for step in result.steps if step in ends or step == result.steps[-1])


def write_case_stress(result: Result, spec: StressSpec, threads: int) -> Path:
    """Write the stresses of a finished run beside its result, and return the name of the file.

    Raises CaseError, FileError.
    """
    target = stress_path(result.path)
    tractions = TractionHistory(result)
    with writing(target):
        write_stress(tractions, case_request(tractions, spec), target, threads)
    return target


def request_before(
    bodies: Sequence[Body],
    depths: Sequence[float],
    increments: int,
    shape: tuple[int, int],
    window: WindowKind = "auto",
    stored: Sequence[Component] = COMPONENTS,
) -> StressRequest:
    """Return what a case asks for that is not solved yet; shape: of its grid.

    bodies, depths: none for those by default. Of the window around the contact only that is certain which a contact of
    a quarter of the grid's width has.
    """
    side = 1.0 if window == "all" else 0.4
    nx, ny = (max(1, round(side * points)) for points in shape)
    cells = slice(0, nx), slice(0, ny)
    return StressRequest(
        bodies=tuple(bodies) or (2,),
        depths=tuple(depths) or tuple(map(float, range(len(GRADED)))),
        steps=tuple(range(increments)),
        source=cells,
        target=cells,
        tractions=TRACTIONS,
        stored=tuple(stored),
    )


def room_problem(request: StressRequest, free_disk: int | None, advice: str = AS_KEYS) -> str | None:
    """Return why stresses are too large for this machine, None if they are not; advice: what would help."""
    return memory_problem(request, 1, advice) or disk_problem(request, free_disk, advice)


def increments_before(spec: StressSpec, increments: int, stages: int) -> int:
    """Return at how many increments a case asks for stresses; increments: those with fields."""
    return min(stages, increments) if spec.every is None else -(-increments // spec.every)
