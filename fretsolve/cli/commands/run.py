"""Carry out ``fretsolve run``: solve a case, save each increment soon, and write the side outputs that it asks for.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from fretsolve.case.loading import read_case
from fretsolve.case.models import Case
from fretsolve.cli.run_messages import JsonMessages, QuietMessages, TextMessages
from fretsolve.elastic.kernels import load, when_compiling
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.cost_estimate import disk_problem, require_memory
from fretsolve.result import HistoryWriter
from fretsolve.simulation.accuracy.rounds import Round, first_round
from fretsolve.simulation.accuracy.saved_rounds import HeaderOf, begun_round, header_of_round, solve_rounds
from fretsolve.simulation.run_to_file import height_maps, solve_missing
from fretsolve.system.files import require_ending, require_folder, require_other
from fretsolve.system.signals import EXIT_STOPPED, Stopped, StopRequest

RESULT_ENDINGS = (".h5", ".hdf5")


def run_case(
    case: Path,
    out: Path | None,
    overrides: Sequence[str],
    stop: StopRequest,
    *,
    resume: bool = False,
    overwrite: bool = False,
    threads: int = 1,
    quiet: bool = False,
    verbose: bool = False,
    log_json: bool = False,
) -> int:
    """Solve a case, save it and report. Return exit code 0 or 75; raised errors carry the others.

    out: None for the case's name with .h5. At most one of the last three is true.
    """
    loaded = read_case(case, pipe=True).case(overrides)
    out = out or case.with_suffix(".h5")
    header_of = partial(header_of_round, threads, overrides)
    begun = _checked_round(loaded, case, out, header_of, resume=resume)
    if (side := _side_outputs(loaded)) is not None:
        side.require_room(begun.setup, out)
    doubts: list[str] = []
    begun = _with_kernels(doubts, begun)
    header = header_of(begun)
    if side is not None:
        side.require_own_side_outputs(begun.setup, out, header, resume=resume, overwrite=overwrite)
    kind = QuietMessages if quiet else JsonMessages if log_json else partial(TextMessages, verbose=verbose)
    messages = kind(begun, out, threads, resume=resume)
    # On 32 x 32 points saving an increment takes as long as solving it, so all that end in 0.1 s are saved at once.
    options: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "pause": 0.1}
    with HistoryWriter.open(out, header, **options, in_rounds=loaded.solver.accuracy is not None) as writer:

        def solve(current: Round) -> bool:
            nonlocal messages
            if len(current.before) > len(begun.before):
                messages = kind(current, out, threads, resume=resume, goes_on=True)
            while doubts:
                messages.warn(doubts.pop())
            return _is_solved(current, writer, messages, stop, threads)

        was_complete = writer.complete
        solved = solve_rounds(writer, begun, header_of, solve, partial(_with_kernels, doubts))
        if solved is None:
            messages.stopped(writer.increments)
            return EXIT_STOPPED
        if writer.complete:
            messages.already_complete(writer.increments)
        else:
            messages.end(solved[1])
        # after further rounds on a complete result the files beside it are of the round before
        replaced = (overwrite or was_complete) and not writer.complete
        told = {"quiet": quiet or log_json, "overwrite": replaced, "missing": writer.complete}
        return _beside(side, stop, loaded, writer, threads, **told)


def _with_kernels(doubts: list[str], current: Round) -> Round:
    """Return a round with the kernels that can be used; doubts: takes a warning if they are slow ones."""
    kernels = load(current.setup.compiled)
    if kernels.why_not:
        doubts.append(f"numba cannot be used, so the run is slower: {kernels.why_not}")
    return replace(current, setup=replace(current.setup, compiled=kernels.compiled))


def _is_solved(current: Round, writer: HistoryWriter, messages: QuietMessages, stop: StopRequest, threads: int) -> bool:
    """Solve what is missing of a round, and return whether it is complete."""
    messages.start(writer)
    when_compiling(messages.compiling)
    try:
        with messages.progress(writer.increments):
            return solve_missing(
                current.setup, writer, stop, threads=threads, show=messages.increment, warn=messages.warn, beside=True
            )
    except NoSolutionError:
        if not current.before:
            messages.end()
        raise


def _checked_round(loaded: Case, case: Path, out: Path, header_of: HeaderOf, *, resume: bool) -> Round:
    """Return the round of the case in the file `case` that is to be solved, if this machine can solve and write it."""
    require_other(out, case, "the case itself")
    for height_map in height_maps(loaded):
        require_other(out, height_map, "a height map of the case")
    require_ending(out, "a result", *RESULT_ENDINGS)
    require_folder(out)
    first = first_round(loaded)
    current = begun_round(first, out, header_of) if resume else first
    require_memory(current.setup)
    if height_maps(loaded):
        current.setup.separation()  # reads the maps, before anything is written
    if not resume and (problem := disk_problem(current.setup, out, certain=True)) is not None:
        raise problem
    return current


def _beside(side: ModuleType | None, stop: StopRequest, *order: Any, **options: bool) -> int:
    """Write the side outputs, if there are any, unless a signal has come or comes meanwhile; return the exit code."""
    if side is not None:
        try:
            with stop.until_signal():
                side.write_side_outputs(*order, **options)
        except Stopped:
            return EXIT_STOPPED
    return 0


def _side_outputs(case: Case) -> ModuleType | None:
    """Return the module for the side outputs of a case, which takes time to load; None if it asks for none."""
    if case.output.stress is None and case.output.fatigue is None and case.output.crack is None:
        return None
    from fretsolve.cli.commands import side_outputs

    return side_outputs
