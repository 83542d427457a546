"""``fretsolve run``: a case solved into a result file that survives whatever ends the run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.case import load_case
from fretsolve.commands.messages import RunOptions, run_messages
from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.result import HistoryWriter
from fretsolve.setup.cost_estimate import require_disk, require_memory
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.run_to_file import height_maps, record, run_header
from fretsolve.system.files import require_ending
from fretsolve.system.signals import EXIT_STOPPED

if TYPE_CHECKING:
    from fretsolve.case import Case
    from fretsolve.system.signals import StopRequest


RESULT_ENDINGS = (".h5", ".hdf5")


def run_case(options: RunOptions, stop: StopRequest) -> int:
    """Solve, save and report. Returns the exit code 0 or 75; raises the errors that stand for the others."""
    case = load_case(options.case, options.overrides)
    _keep_inputs(options.output, case)
    require_ending(options.output, "a result", *RESULT_ENDINGS)
    setup = set_up(case)
    require_memory(setup)
    if not options.resume:
        require_disk(setup, options.output)
    header = run_header(setup, options.threads, options.overrides)
    with HistoryWriter.open(
        options.output, header, resume=options.resume, overwrite=options.overwrite
    ) as writer:
        messages = run_messages(setup, options)
        if writer.complete:
            messages.already_complete(len(writer.summaries))
            return 0
        messages.start(writer)
        try:
            with messages.progress(len(writer.summaries)):
                complete = record(setup, writer, stop, messages.increment, options.threads, messages.warn, beside=True)
        except NoSolutionError:
            messages.end()
            raise
    if complete:
        messages.end()
        return 0
    messages.stopped(len(writer.summaries))
    return EXIT_STOPPED


def _keep_inputs(out: Path, case: Case) -> None:
    """Raise CaseError where the result would replace what the run is made from."""
    for source in (case.source.path, *height_maps(case)):
        if out.exists() and source.exists() and out.samefile(source):
            what = "the case itself" if source == case.source.path else "a height map of the case"
            raise CaseError(f"the result would replace {what}; give another name with -o", (), out)
