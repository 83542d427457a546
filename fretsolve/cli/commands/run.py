"""Carry out ``fretsolve run``: solve a case, save each increment soon, and write the side outputs that it asks for.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from fretsolve.case.loading import read_case
from fretsolve.case.models import Case
from fretsolve.cli.run_messages import JsonMessages, QuietMessages, TextMessages
from fretsolve.elastic.kernels import load, when_compiling
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.cost_estimate import disk_problem, require_memory
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import height_maps, run_header, solve_missing
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
    setup = _checked_setup(loaded, case, out, resume=resume)
    if (side := _side_outputs(loaded)) is not None:
        side.require_room(setup, out)
    kernels = load(setup.compiled)
    setup = replace(setup, compiled=kernels.compiled)
    header = run_header(setup, threads, overrides)
    if side is not None:
        side.require_own_side_outputs(setup, out, header, resume=resume, overwrite=overwrite)
    # On 32 x 32 points saving an increment takes as long as solving it, so all that end in 0.1 s are saved at once.
    with HistoryWriter.open(out, header, resume=resume, overwrite=overwrite, pause=0.1) as writer:
        if quiet or log_json:
            messages = (QuietMessages if quiet else JsonMessages)(setup, out, threads, resume=resume)
        else:
            messages = TextMessages(setup, out, threads, resume=resume, verbose=verbose)
        if writer.complete:
            messages.already_complete(writer.increments)
            return _beside(side, stop, loaded, writer, threads, quiet=quiet or log_json, overwrite=False, missing=True)
        messages.start(writer)
        if kernels.why_not:
            messages.warn(f"numba cannot be used, so the run is slower: {kernels.why_not}")
        when_compiling(messages.compiling)
        try:
            with messages.progress(writer.increments):
                complete = solve_missing(
                    setup, writer, stop, threads=threads, show=messages.increment, warn=messages.warn, beside=True
                )
        except NoSolutionError:
            messages.end()
            raise
        if complete:
            messages.end()
            return _beside(side, stop, loaded, writer, threads, quiet=quiet or log_json, overwrite=overwrite)
    messages.stopped(writer.increments)
    return EXIT_STOPPED


def _checked_setup(loaded: Case, case: Path, out: Path, *, resume: bool) -> ProblemSetup:
    """Return the setup of the case in the file `case` if this machine can solve it and write it to `out`."""
    require_other(out, case, "the case itself")
    for height_map in height_maps(loaded):
        require_other(out, height_map, "a height map of the case")
    require_ending(out, "a result", *RESULT_ENDINGS)
    require_folder(out)
    setup = set_up(loaded)
    require_memory(setup)
    if height_maps(loaded):
        setup.separation()  # reads the maps, before anything is written
    if not resume and (problem := disk_problem(setup, out, certain=True)) is not None:
        raise problem
    return setup


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
