"""Run a case into its result file: the file's header, and the saving of increments beside the solver."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

from fretsolve import kernels
from fretsolve.case.models import Case
from fretsolve.case.surface_specs import HeightsSurface
from fretsolve.errors import NoSolutionError
from fretsolve.result import HistoryWriter, RunHeader
from fretsolve.result.state import State, Summary, SummaryErrors
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.error_bars import run_with_error_bars
from fretsolve.simulation.simulation import run
from fretsolve.system.files import reported

LIBRARIES = ("numpy", "scipy", "pyfftw", "h5py")

Show = Callable[[Summary, SummaryErrors | None], None]


class Stop(Protocol):
    """Tells whether the run is to stop after the increment."""

    @property
    def requested(self) -> bool: ...


def missing_states(
    setup: ProblemSetup, writer: HistoryWriter, threads: int = 1, warn: Callable[[str], object] | None = None
) -> Iterator[State]:
    """Return the generator of the increments that the result lacks, with error bars if the case asks for them.

    warn: called with a line if there are no error bars any more. The generator raises NoSolutionError.
    """
    so_far = writer.last_state, tuple(writer.summaries)  # the writer's own list grows meanwhile
    if setup.case.solver.error_bars:
        return run_with_error_bars(setup, *so_far, threads, warn)
    return run(setup, *so_far, threads)


class Saving(AbstractContextManager["Saving"]):
    """Saves the states of a run in their order, and finishes the result at the end of its `with` block.

    The result is complete if it has all `increments`, failed if the block ends by NoSolutionError; else what is done is
    saved for a resume. show: called after each saved increment, with its error bars. beside: save each increment in a
    thread of its own while the next one is solved. complete: whether the result is finished and complete.
    """

    def __init__(self, writer: HistoryWriter, increments: int, show: Show | None = None, *, beside: bool = False):
        self._writer, self._increments, self._show = writer, increments, show
        self._thread = ThreadPoolExecutor(1, "saving") if beside else None
        self._last: Future[None] | None = None
        self.complete = False

    def append(self, state: State) -> None:
        """Save an increment, or begin to once the one before is saved. Raises FileError, for either."""
        self._wait()
        if self._thread is None:
            self._save(state)
        else:
            self._last = self._thread.submit(self._save, state)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        with self._thread or nullcontext():
            if error is not None and not isinstance(error, NoSolutionError):
                return
            self._wait()
            if error is not None:
                self._writer.finish("failed", str(error), error.kind)
            elif len(self._writer.summaries) == self._increments:
                self._writer.finish("complete")
                self.complete = True
            elif self._writer.summaries:
                self._writer.save()

    def _wait(self) -> None:
        last, self._last = self._last, None
        if last is not None:
            last.result()

    def _save(self, state: State) -> None:
        self._writer.append(state)
        if self._show is not None:
            self._show(state.summary, state.errors)


def run_header(setup: ProblemSetup, threads: int, overrides: Sequence[str]) -> RunHeader:
    """Return what the result says about its run, which is the same in each run of a case."""
    case = setup.case
    provenance = {
        "threads": threads,
        "precision": case.solver.precision,
        "pointwise_kernels": "compiled" if kernels.COMPILED else "numpy",
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
    """Return the files of the measured maps of a case."""
    return [surface.file for surface in case.surface if isinstance(surface, HeightsSurface)]


def _digest(file: Path) -> str:
    with reported("cannot be read", file):
        return hashlib.sha256(file.read_bytes()).hexdigest()
