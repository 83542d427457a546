"""``fretsolve run``: a case solved into a result file that survives whatever ends the run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.case import load_case
from fretsolve.commands.messages import Quiet, teller
from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.result import HistoryWriter
from fretsolve.setup.cost_estimate import require_disk, require_memory
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.run_to_file import height_maps, record, run_header
from fretsolve.system.files import require_ending
from fretsolve.system.signals import EXIT_STOPPED

if TYPE_CHECKING:
    from fretsolve.case import Case
    from fretsolve.system.signals import StopRequest


RESULT_ENDINGS = (".h5", ".hdf5")


@dataclass(frozen=True)
class Order:
    """What the command line asks for. out: None for the case's name with .h5."""

    case: Path
    out: Path | None
    overrides: tuple[str, ...]
    resume: bool
    overwrite: bool
    threads: int
    quiet: bool
    verbose: bool = False
    log_json: bool = False

    @property
    def output(self) -> Path:
        """Where the result goes."""
        return self.out or self.case.with_suffix(".h5")


def run_case(order: Order, stop: StopRequest) -> int:
    """Solve, save and report. Returns the exit code 0 or 75; raises the errors that stand for the others."""
    case = load_case(order.case, order.overrides)
    _keep_inputs(order.output, case)
    require_ending(order.output, "a result", *RESULT_ENDINGS)
    setup = set_up(case)
    require_memory(setup)
    if not order.resume:
        require_disk(setup, order.output)
    header = run_header(setup, order.threads, order.overrides)
    with HistoryWriter.open(
        order.output, header, resume=order.resume, overwrite=order.overwrite
    ) as writer:
        tell = teller(setup, order)
        if writer.complete:
            tell.already(len(writer.summaries))
            return 0
        tell.begin(writer)
        try:
            complete = _solve(setup, order, writer, stop, tell)
        except NoSolutionError:
            tell.end()
            raise
    if complete:
        tell.end()
        return 0
    tell.stopped(len(writer.summaries))
    return EXIT_STOPPED


def _keep_inputs(out: Path, case: Case) -> None:
    """Raise CaseError where the result would replace what the run is made from."""
    for source in (case.source.path, *height_maps(case)):
        if out.exists() and source.exists() and out.samefile(source):
            what = "the case itself" if source == case.source.path else "a height map of the case"
            raise CaseError(f"the result would replace {what}; give another name with -o", (), out)


def _solve(setup: ProblemSetup, order: Order, writer: HistoryWriter, stop: StopRequest, tell: Quiet) -> bool:
    with tell.progress(len(writer.summaries)) as display:
        return record(setup, writer, stop, display.show, order.threads, tell.warn, beside=True)
