"""Run a case into its result file: the file's header, and the saving of increments beside the solver."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.models import Case
from fretsolve.elastic.fftw import pyfftw
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter, RunHeader
from fretsolve.result.state import State, Summary, SummaryErrors
from fretsolve.simulation.simulation import run
from fretsolve.system.files import reported, require_regular

NOTHING_MORE: Mapping[str, Any] = {}


class Stop(Protocol):
    """A request to stop after the increment."""

    @property
    def requested(self) -> bool: ...


def solve_missing(
    setup: ProblemSetup,
    writer: HistoryWriter,
    stop: Stop,
    *,
    threads: int = 1,
    show: Callable[[Summary, SummaryErrors | None], None] = lambda summary, errors: None,
    warn: Callable[[str], object] | None = None,
    beside: bool = False,
) -> bool:
    """Solve and save the increments that the result lacks, finish it, and return whether it is complete.

    show: called after each saved increment with its summary, and with its error bars if the case asks for them. warn:
    called with one line if the error bars end. beside: save an increment in a thread while the next one is solved.
    Raises FileError, and NoSolutionError once the failed result is written. After a stop, and after any other
    exception, the saved increments stay for a resume.
    """

    unshown: list[tuple[Summary, SummaryErrors | None]] = []

    def save(state: State) -> None:
        unshown.append((state.summary, state.errors))
        writer.append(state)
        show_saved()

    def show_saved() -> None:
        while unshown and writer.is_saved(unshown[0][0].step):
            show(*unshown.pop(0))

    if setup.case.solver.error_bars:
        from fretsolve.simulation.error_bars.error_bars import run_with_error_bars  # other runs do not need it

        states = run_with_error_bars(setup, writer.last_state, writer.summaries, threads, warn)
    else:
        states = run(setup, writer.last_state, writer.summaries, threads)
    failure = _save_each(states, save, stop, beside=beside)
    complete = writer.increments == setup.load_path.followed(writer.summaries).increments
    if failure is not None:
        writer.finish("failed", str(failure), failure.kind)
    elif complete:
        writer.finish("complete")
    elif writer.increments:
        writer.save()
    show_saved()
    if failure is not None:
        raise failure
    return complete


def _save_each(
    states: Iterator[State], save: Callable[[State], None], stop: Stop, *, beside: bool
) -> NoSolutionError | None:
    """Save states until a stop or their end; return the failure that ends them, if one does."""
    failure: NoSolutionError | None = None
    with ThreadPoolExecutor(1, "saving") if beside else nullcontext() as thread:
        pending: Future[None] | None = None
        try:
            while not stop.requested and (state := next(states, None)) is not None:
                if pending is not None:
                    pending.result()
                if thread is None:
                    save(state)
                else:
                    pending = thread.submit(save, state)
        except NoSolutionError as error:
            failure = error
        if pending is not None:
            pending.result()
    return failure


def run_header(
    setup: ProblemSetup, threads: int, overrides: Sequence[str], more: Mapping[str, Any] = NOTHING_MORE
) -> RunHeader:
    """Return the header of the result, which is the same in each run of a case; more: for its provenance."""
    case, digests = setup.case, {}
    maps = {f"height map {number}": file for number, file in enumerate(height_maps(case), start=1)}
    if case.friction.map is not None:
        maps["friction map"] = case.friction.map
    if case.rig is not None and case.rig.compliance is not None:
        maps["compliance of the rig"] = case.rig.compliance
    for name, file in maps.items():
        with reported("cannot be read", file):
            require_regular(file)
            with file.open("rb") as content:
                digests[name] = hashlib.file_digest(content, "sha256").hexdigest()
    provenance = {
        "threads": threads,
        "precision": case.solver.precision,
        "pointwise_kernels": "compiled" if setup.compiled else "numpy",
        "overrides": overrides,
        **({} if case.solver.accuracy is None else {"picked_by_accuracy": setup.picked}),
        **more,
        **_environment(),
    }
    return RunHeader(
        case_yaml=case.source.text,
        effective_case=json.dumps(case.effective()),
        coupling=setup.model.coupling,
        model=json.dumps([vars(decision) for decision in setup.model.decisions]),
        inputs=json.dumps(digests),
        provenance=json.dumps(provenance),
        x=setup.grid.x,
        y=setup.grid.y,
        fields=case.output.fields,
        every=case.output.every,
        errors=case.solver.error_bars,
    )


@functools.cache
def _environment() -> dict[str, str]:
    # Metadata takes milliseconds to search, so only for SciPy, which few runs load.
    loaded = {"numpy": np, "pyfftw": pyfftw, "h5py": h5py}
    versions = {"scipy": version("scipy"), **{name: library.__version__ for name, library in loaded.items()}}
    return {"platform": platform.platform(), "python": platform.python_version(), **versions}


def height_maps(case: Case) -> list[Path]:
    """Return the files of the measured maps of a case."""
    return [surface.file for surface in case.surface if isinstance(surface, HeightsSurface)]
