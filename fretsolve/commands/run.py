"""Carry out ``fretsolve run``: solve a case and save each increment soon, whatever ends the run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fretsolve.case.loading import load_case
from fretsolve.case.stress_spec import StressSpec
from fretsolve.commands.messages import JsonMessages, QuietMessages, TextMessages
from fretsolve.errors import NoSolutionError
from fretsolve.kernels import load
from fretsolve.result import HistoryWriter, open_result
from fretsolve.setup.cost_estimate import disk_problem, free_bytes, require_memory
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.run_to_file import height_maps, run_header, solve_missing
from fretsolve.system.files import require_ending, require_free, require_other
from fretsolve.system.signals import EXIT_STOPPED, StopRequest

PAUSE = 0.1
"""Seconds for which increments may stay unsaved. On 32 x 32 points saving one takes as long as solving it, so all that
end in this time are saved at once."""

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
    loaded = load_case(case, overrides)
    out = out or case.with_suffix(".h5")
    require_other(out, case, "the case itself")
    for height_map in height_maps(loaded):
        require_other(out, height_map, "a height map of the case")
    require_ending(out, "a result", *RESULT_ENDINGS)
    setup = set_up(loaded)
    require_memory(setup)
    if height_maps(loaded):
        setup.separation()  # reads the maps, before anything is written
    if not resume and (problem := disk_problem(setup, out, certain=True)) is not None:
        raise problem
    if loaded.output.stress is not None:
        _require_room(loaded.output.stress, setup, out)
        _require_own_stress(out, resume=resume, overwrite=overwrite)
    kernels = load(setup.compiled)
    setup = replace(setup, compiled=kernels.compiled)
    header = run_header(setup, threads, overrides)
    with HistoryWriter.open(out, header, resume=resume, overwrite=overwrite, pause=PAUSE) as writer:
        if quiet or log_json:
            messages = (QuietMessages if quiet else JsonMessages)(setup, out, threads, resume=resume)
        else:
            messages = TextMessages(setup, out, threads, resume=resume, verbose=verbose)
        if writer.complete:
            messages.already_complete(len(writer.summaries))
            if loaded.output.stress is not None:
                _write_stress(loaded.output.stress, out, threads, quiet=quiet or log_json, missing=True)
            return 0
        messages.start(writer)
        if kernels.why_not:
            messages.warn(f"numba cannot be used, so the run is slower: {kernels.why_not}")
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
        if loaded.output.stress is not None:
            _write_stress(
                loaded.output.stress, out, threads, quiet=quiet or log_json, exclusive=not (resume or overwrite)
            )
        return 0
    messages.stopped(len(writer.summaries))
    return EXIT_STOPPED


def _require_room(spec: StressSpec, setup: ProblemSetup, out: Path) -> None:
    """Raise CaseError, before the run, if the stresses that the case asks for are too large for this machine."""
    from fretsolve.stress.of_case import room_problem

    stages = len(setup.load_path.last_steps)
    increments = -(-setup.load_path.increments // setup.case.output.every)
    if (problem := room_problem(spec, setup.grid.shape, increments, stages, free_bytes(out))) is not None:
        raise setup.case.source.problem(problem, ("output", "stress"))


def _require_own_stress(out: Path, *, resume: bool, overwrite: bool) -> None:
    """Raise CaseError, before the run, if its stresses would replace a file that is not the run's own."""
    from fretsolve.stress.names import is_stress_file, stress_path

    path = stress_path(out)
    advice = "the run would replace it by its stresses: move it away, or give --overwrite"
    require_free(path, overwrite=overwrite or (resume and is_stress_file(path)), advice=advice)


def _write_stress(
    spec: StressSpec, out: Path, threads: int, *, quiet: bool, exclusive: bool = True, missing: bool = False
) -> None:
    """Write and print the stresses that the case asks for.

    exclusive: replace no file; missing: do nothing if there is one.
    """
    from fretsolve.commands.stress import write_with_messages
    from fretsolve.stress.names import stress_path
    from fretsolve.stress.of_case import case_request
    from fretsolve.stress.tractions import TractionHistory

    if missing and stress_path(out).exists():
        return
    with open_result(out) as result:
        tractions = TractionHistory(result)
        request = case_request(tractions, spec)
        write_with_messages(tractions, request, stress_path(out), threads, quiet=quiet, exclusive=exclusive)
