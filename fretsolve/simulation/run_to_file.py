"""A scene solved into its result file: what the file says about the run, and the loop that fills it."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import platform
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from fretsolve import kernels as pointwise
from fretsolve.case import HeightsSurface
from fretsolve.errors import FileError, NoSolutionError
from fretsolve.result import HistoryWriter, RunHeader
from fretsolve.simulation.error_bars import run_with_error_bars
from fretsolve.simulation.simulation import run

if TYPE_CHECKING:
    from fretsolve.case import Case
    from fretsolve.result.state import State, Summary, SummaryErrors
    from fretsolve.setup.problem_setup import ProblemSetup

LIBRARIES = ("numpy", "scipy", "pyfftw", "h5py")


Show = Callable[["Summary", "SummaryErrors | None"], None]


class Stop(Protocol):
    """Whether somebody has asked to stop after the increment."""

    @property
    def requested(self) -> bool: ...


def record(
    setup: ProblemSetup,
    writer: HistoryWriter,
    stop: Stop,
    show: Show,
    threads: int = 1,
    warn: Callable[[str], None] = lambda text: None,
    *,
    beside: bool = False,
) -> bool:
    """Solve and save what is missing and finish the result (True), or stop with what is done saved (False).

    show: called after each saved increment, with its error bars; warn: with what a person should hear of these.
    beside: save each increment in a thread of its own while the next one is solved. Raises NoSolutionError, the result
    finished as failed, and FileError.
    """
    increments = setup.load_path.increments
    if stop.requested and len(writer.summaries) < increments:
        return False
    with ThreadPoolExecutor(1, "saving") as thread:
        saver = _Saver(writer, show, thread if beside else None)
        try:
            for state, errors in _states(setup, writer, threads, warn):
                saver.save(state, errors)
                if stop.requested and state.summary.step + 1 < increments:
                    saver.wait()
                    writer.save()
                    return False
        except NoSolutionError as error:
            saver.wait()
            writer.finish("failed", str(error), error.kind)
            raise
        saver.wait()
    writer.finish("complete")
    return True


class _Saver:
    """Saves increments one after another, in `thread` if there is one, and shows each once it is saved."""

    def __init__(self, writer: HistoryWriter, show: Show, thread: Executor | None):
        self._writer = writer
        self._show = show
        self._thread = thread
        self._last: Future[None] | None = None

    def save(self, state: State, errors: SummaryErrors | None) -> None:
        """Begin to save an increment once the one before is saved. Raises FileError, of either."""
        self.wait()
        if self._thread is None:
            self._commit(state, errors)
        else:
            self._last = self._thread.submit(self._commit, state, errors)

    def wait(self) -> None:
        """Until all is saved. Raises FileError."""
        last, self._last = self._last, None
        if last is not None:
            last.result()

    def _commit(self, state: State, errors: SummaryErrors | None) -> None:
        self._writer.append(state, errors)
        self._show(state.summary, errors)


def _states(
    setup: ProblemSetup, writer: HistoryWriter, threads: int, warn: Callable[[str], None]
) -> Iterator[tuple[State, SummaryErrors | None]]:
    """What is missing, with error bars where the case asks for them."""
    so_far = writer.last_state, tuple(writer.summaries)  # the writer adds to its own while this goes on
    if not setup.case.solver.error_bars:
        yield from ((state, None) for state in run(setup, *so_far, threads))
        return
    yield from run_with_error_bars(setup, *so_far, threads, warn)


def run_header(setup: ProblemSetup, threads: int, overrides: Sequence[str]) -> RunHeader:
    """What the result says about its run. Nothing in it changes from one run of the same case to the next."""
    case = setup.case
    provenance = {
        "threads": threads,
        "precision": case.solver.precision,
        "pointwise_kernels": "compiled" if pointwise.COMPILED else "numpy",
        "overrides": overrides,
        **({} if case.solver.accuracy is None else {"picked_by_accuracy": setup.picked}),
        **_environment(),
    }
    return RunHeader(
        case_yaml=case.source.text,
        effective_case=json.dumps(case.effective()),
        coupling=setup.model.coupling,
        model=json.dumps([vars(decision) for decision in setup.model.decisions]),
        inputs=json.dumps({f"height map {n}": _digest(file) for n, file in enumerate(height_maps(case), start=1)}),
        provenance=json.dumps(provenance),
        x=setup.grid.x,
        y=setup.grid.y,
        fields=case.output.fields,
        every=case.output.every,
        errors=case.solver.error_bars,
    )


@functools.cache
def _environment() -> dict[str, str]:
    versions = {library: version(library) for library in LIBRARIES}
    return {"platform": platform.platform(), "python": platform.python_version(), **versions}


def height_maps(case: Case) -> list[Path]:
    """The files of the measured maps of a case."""
    return [surface.file for surface in case.surface if isinstance(surface, HeightsSurface)]


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise FileError(f"cannot be read: {os.strerror(error.errno) if error.errno else error}", file) from error
