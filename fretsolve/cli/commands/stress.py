"""Carry out ``fretsolve stress``: compute the stresses below the surface from a result, and print the largest ones.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.quantity_names import INVARIANTS
from fretsolve.cli.commands.computed_files import FileOptions, FileOrder, cycle_choice, length_of
from fretsolve.cli.commands.shakedown_lines import tell_shakedown_of
from fretsolve.cli.commands.worst_lines import UNBOUNDED, counted, error_text
from fretsolve.errors import CaseError, FileError
from fretsolve.post.export.selection import first_and_last, stored_step
from fretsolve.post.fatigue.material import placed
from fretsolve.post.names import OUTERMOST, stress_path
from fretsolve.post.stress.cycles import chosen, cycles_of, states_of, whole_path_note
from fretsolve.post.stress.peaks import Key, Peak
from fretsolve.post.stress.request import (
    Plane,
    StressRequest,
    disk_problem,
    memory_problem,
    stress_request,
    warnings_of,
)
from fretsolve.post.stress.stress_file import write_stress
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.post.stress.yielding import computed_lines, yield_lines, yield_stresses
from fretsolve.problem.setup.cost_estimate import free_bytes, rounded_bytes
from fretsolve.result import Result, open_result
from fretsolve.result.state import stage_ends
from fretsolve.system.files import require_utf8, writing
from fretsolve.system.progress import counting_bar, print_warnings

MOST_ENDS, FIRST_ENDS = 1000, 100
"""Ends of stages whose stresses are computed by default, and how many of the first of more, before the last ones."""

TITLES = {"mises": "largest von Mises stress", "tension": "largest tension", "tresca": "largest shear (Tresca)"}


@dataclass(frozen=True)
class StressOptions(FileOptions):
    """The options of `fretsolve stress`."""

    depths: Sequence[str]
    stages: Sequence[int]
    steps: Sequence[tuple[int, int]]
    cycle: str | None
    plane: Plane | None


def stress_of_result(options: StressOptions) -> int:
    """Compute the stresses of a result, write them and print the largest ones. Return the exit code."""
    needed = "a depth is the distance from the surface into a body"
    depths = [length_of("--depth", text, needed) for text in options.depths]
    with open_result(options.out) as result:
        order = options.order(stress_path(result.path), "stresses", "the result itself")
        tractions, bodies = TractionHistory(result), options.body_numbers
        steps = _increments(result, options)
        request = stress_request(tractions, steps, bodies, depths, options.plane, options.window_choice)
        write_stress_with_messages(tractions, request, order)
        if options.cycle is not None and (limits := yield_stresses(result)):
            tell_shakedown_of(order.target, cycle_choice(options.cycle), limits, result.path, quiet=order.quiet)
    return 0


def write_stress_with_messages(tractions: TractionHistory, request: StressRequest, order: FileOrder) -> None:
    """Write the stresses that a request asks for, and print the largest ones. Raises CaseError, FileError."""
    peaks = compute_with_messages(tractions, request, order)
    result = tractions.result
    certain = yield_lines(result, dict.fromkeys(request.bodies, math.inf))  # what is about so is computed
    lines = {**certain, **computed_lines(result, request, peaks)}
    print_warnings(result.path, *(lines[body] for body in request.bodies if body in lines))
    if not order.quiet:
        for line in peak_lines(request, peaks):
            print(line)
        print(order.target, flush=True)


def compute_with_messages(
    tractions: TractionHistory, request: StressRequest, order: FileOrder
) -> dict[Key, list[Peak]]:
    """Write the stresses that a request asks for, with warnings and a bar, and return the largest ones."""
    path, target = tractions.result.path, order.target
    require_utf8(path.name, path)
    if (problem := memory_problem(request, order.threads, order.advice)) is not None:
        raise CaseError(problem, (), path)
    if (problem := disk_problem(request, free_bytes(target), order.advice)) is not None:
        raise FileError(problem, path)
    print_warnings(path, *warnings_of(request, tractions))
    if not order.quiet and request.file_bytes > 1e9:
        print(f"the file takes up to {rounded_bytes(request.file_bytes)}", flush=True)
    layers = len(request.bodies) * len(request.depths) * len(request.steps)
    with counting_bar("layers", layers, shown=not order.quiet and sys.stdout.isatty()) as show, writing(target):
        return write_stress(
            tractions, request, target, order.threads, show, folder=order.folder, exclusive=order.exclusive
        )


def peak_lines(request: StressRequest, peaks: Mapping[Key, Sequence[Peak]]) -> Iterator[str]:
    """Return lines with the largest stresses of all increments."""
    for body in request.bodies:
        yield f"body {body}, {counted(request.depths, 'depth')}, {counted(request.steps, 'increment')}:"
        notes = set()
        for name in INVARIANTS:
            found = peaks[body, name]
            index = max(range(len(found)), key=lambda one: found[one].value)
            peak = found[index]
            mark = _mark(peak)
            notes.add(mark)
            place = f"x = {peak.x:.4g}, y = {peak.y:.4g}, depth {peak.depth:.4g} mm, increment {request.steps[index]}"
            error = "" if peak.unbounded else error_text(peak.error)
            yield f"  {TITLES[name] + mark:<26} {peak.value:8.4g}{error} MPa at {place}"
        if "*" in notes:
            yield "  * at the edge of contact, where stress converges with the square root of the cell: extrapolated"
        if "+" in notes:
            yield "  + at the largest depth: it may grow below"
        if "#" in notes:
            yield f"  # {OUTERMOST}"
        if "!" in notes:
            yield f"  ! {UNBOUNDED}"


def _mark(peak: Peak) -> str:
    """Return the mark of a note below the largest values, empty for none."""
    marks = {"!": peak.unbounded, "*": peak.at_edge, "+": peak.deepest, "#": peak.outermost}
    return next((mark for mark, holds in marks.items() if holds), "")


def _increments(result: Result, options: StressOptions) -> list[int]:
    """Return the increments that the options choose, by default the ends of stages. Raises CaseError."""
    if not result.increments:
        raise CaseError(result.why_empty, (), result.path)
    ends = stage_ends(result.history["stage"]).tolist()
    if not (options.stages or options.steps or options.cycle):
        there = np.array([step for step in ends if step in result.steps] or result.steps[-1:])
        if len(there) > MOST_ENDS:
            first, last = FIRST_ENDS, MOST_ENDS - FIRST_ENDS
            some = f"of {len(there)} ends of stages the first {first} and the last {last} are computed"
            print_warnings(result.path, f"{some}; --cycle, --stage or --step choose others")
        return list(map(int, first_and_last(there, MOST_ENDS, FIRST_ENDS)))
    found = set[int]()
    if options.cycle is not None:
        with placed(lambda message: CaseError(f"{message}; --stage or --step chooses increments", (), result.path)):
            cycles = chosen(cycles_of(result), cycle_choice(options.cycle))
        print_warnings(result.path, *filter(None, [whole_path_note(cycles)]))
        found.update(states_of(cycles, result.steps))
    try:
        for stage in options.stages:
            if not 1 <= stage <= len(ends):
                raise ValueError(f"there is no stage {stage}; there are 1 to {len(ends)}")
            found.add(stored_step(result, ends[stage - 1]))
        for first, last in options.steps:
            inside = [step for step in result.steps if first <= step <= last]
            if first != last and not inside:
                raise ValueError(f"no increment from {first} to {last} has fields")
            found.update(inside if first != last else [stored_step(result, first)])
    except ValueError as error:
        raise CaseError(str(error), (), result.path) from error
    return sorted(found)
