"""Carry out ``fretsolve run``: solve a case, save each increment soon, and write the side outputs that it asks for."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fretsolve.case.loading import read_case
from fretsolve.case.models import Case
from fretsolve.cli.commands.messages.run_messages import JsonMessages, QuietMessages, TextMessages
from fretsolve.elastic.kernels import load, when_compiling
from fretsolve.errors import FileError, NoSolutionError
from fretsolve.problem.setup.cost_estimate import disk_problem, free_bytes, require_memory
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter, Result, RunHeader, open_result
from fretsolve.result.header import is_same_run
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import height_maps, run_header, solve_missing
from fretsolve.system import atomic_files
from fretsolve.system.files import require_ending, require_free, require_other, require_utf8, writing
from fretsolve.system.signals import EXIT_STOPPED, StopRequest

PAUSE = 0.1
"""Seconds for which increments may stay unsaved. On 32 x 32 points saving one takes as long as solving it, so all that
end in this time are saved at once."""

RESULT_ENDINGS = (".h5", ".hdf5")

AT_END = "the result is whole: with more room --resume writes what output.{} asks for"
"""Advice where there is no room for side outputs."""


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
    setup = _checked_setup(loaded, case, out, resume=resume)
    kernels = load(setup.compiled)
    setup = replace(setup, compiled=kernels.compiled)
    header = run_header(setup, threads, overrides)
    require_own_side_outputs(setup, out, header, resume=resume, overwrite=overwrite)
    with HistoryWriter.open(out, header, resume=resume, overwrite=overwrite, pause=PAUSE) as writer:
        if quiet or log_json:
            messages = (QuietMessages if quiet else JsonMessages)(setup, out, threads, resume=resume)
        else:
            messages = TextMessages(setup, out, threads, resume=resume, verbose=verbose)
        if writer.complete:
            messages.already_complete(len(writer.summaries))
            write_side_outputs(loaded, out, threads, quiet=quiet or log_json, overwrite=False, missing=True)
            return 0
        messages.start(writer)
        if kernels.why_not:
            messages.warn(f"numba cannot be used, so the run is slower: {kernels.why_not}")
        when_compiling(messages.compiling)
        try:
            with messages.progress(len(writer.summaries)):
                complete = solve_missing(
                    setup, writer, stop, threads=threads, show=messages.increment, warn=messages.warn, beside=True
                )
        except NoSolutionError:
            messages.end()
            raise
    if complete:
        messages.end()
        write_side_outputs(loaded, out, threads, quiet=quiet or log_json, overwrite=overwrite)
        return 0
    messages.stopped(len(writer.summaries))
    return EXIT_STOPPED


def _checked_setup(loaded: Case, case: Path, out: Path, *, resume: bool) -> ProblemSetup:
    """Return the setup of the case in the file `case` if this machine can solve it and write it to `out`.

    Raises CaseError, FileError.
    """
    require_other(out, case, "the case itself")
    for height_map in height_maps(loaded):
        require_other(out, height_map, "a height map of the case")
    require_ending(out, "a result", *RESULT_ENDINGS)
    if not out.parent.is_dir():
        raise FileError(f"there is no folder {out.parent}; mkdir -p {shlex.quote(str(out.parent))} makes it", out)
    setup = set_up(loaded)
    require_memory(setup)
    if height_maps(loaded):
        setup.separation()  # reads the maps, before anything is written
    if not resume and (problem := disk_problem(setup, out, certain=True)) is not None:
        raise problem
    require_room(setup, out)
    return setup


def require_room(setup: ProblemSetup, out: Path) -> None:
    """Raise CaseError, before the run, if stresses or fatigue that the case asks for cannot be computed after it."""
    output = setup.case.output
    if (spec := output.stress) is not None:
        from fretsolve.post.stress.request import increments_before, request_before, room_problem

        stages = len(setup.load_path.last_steps)
        count = increments_before(spec, -(-setup.load_path.increments // output.every), stages)
        request = request_before(spec.bodies, spec.depths, count, setup.grid.shape, spec.window, spec.components)
        if (problem := room_problem(request, free_bytes(out))) is not None:
            raise setup.case.source.problem(problem, ("output", "stress"))
    if output.fatigue is not None:
        from fretsolve.post.fatigue.request import require_fatigue

        require_fatigue(setup, free_bytes(out))


def require_own_side_outputs(
    setup: ProblemSetup, out: Path, header: RunHeader, *, resume: bool, overwrite: bool
) -> None:
    """Raise CaseError, before the run, if what the case asks for would replace files that are not the run's own.

    Raises FileError if the side outputs cannot hold the name of the result.
    """
    output = setup.case.output
    if output.stress is None and output.fatigue is None:
        return
    require_utf8(out.name, out)
    from fretsolve.post.names import fatigue_path, stress_path

    for spec, kind, path in (
        (output.stress, "stress", stress_path(out)),
        (output.fatigue, "fatigue", fatigue_path(out)),
    ):
        if spec is None:
            continue
        if path.is_symlink() and not path.exists():
            raise FileError("is a link to a file that does not exist; remove it, or give another name", path)
        own = not overwrite and resume and _is_own(path, kind, header.attributes("running"))
        advice = "the run would replace it by what output asks for: move it away, or give --overwrite"
        require_free(path, overwrite=overwrite or own, advice=advice)


def _is_own(path: Path, kind: str, attributes: Mapping[str, Any]) -> bool:
    """Return whether a file was computed from a run that gives the same numbers. Raises FileError if it is damaged."""
    from fretsolve.post.stress.computed_file import opened_computed

    with opened_computed(path) as found:
        return found is not None and found.kind == kind and is_same_run(found.attributes, attributes)


def write_side_outputs(
    case: Case, out: Path, threads: int, *, quiet: bool, overwrite: bool, missing: bool = False
) -> None:
    """Write and print the stresses and fatigue parameters that the case asks for.

    overwrite: replace any file, otherwise only files of this run; missing: write only absent files.
    """
    stress, fatigue = case.output.stress, case.output.fatigue
    if stress is None and fatigue is None:
        return
    from fretsolve.cli.commands.fatigue import write_fatigue_with_messages
    from fretsolve.cli.commands.stress import FileOrder, write_with_messages
    from fretsolve.post.fatigue.request import case_request as fatigue_request
    from fretsolve.post.names import fatigue_path, stress_path
    from fretsolve.post.stress.computed_file import is_made_from
    from fretsolve.post.stress.request import case_request as stress_request
    from fretsolve.post.stress.tractions import TractionHistory

    def order(kind: str, target: Path, result: Result) -> FileOrder:
        if not overwrite and _is_own(target, kind, result.attributes):
            with writing(target):
                atomic_files.remove(target)  # a file of this run, so that no other file can be replaced
        return FileOrder(target, threads, quiet, not overwrite, AT_END.format(kind))

    with open_result(out) as result:
        tractions = TractionHistory(result)
        if stress is not None and not (missing and is_made_from(result, stress_path(out))):
            request = stress_request(tractions, stress)
            write_with_messages(tractions, request, order("stress", stress_path(out), result))
        if fatigue is not None and not (missing and is_made_from(result, fatigue_path(out))):
            asked = fatigue_request(case)
            write_fatigue_with_messages(tractions, asked, order("fatigue", fatigue_path(out), result))
