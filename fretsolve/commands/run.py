"""``fretsolve run``: a case solved into a result file that survives whatever ends the run."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve import pointwise
from fretsolve.case import HeightsSurface, load_case
from fretsolve.commands.telling import Quiet, teller
from fretsolve.error_bars import run_with_error_bars
from fretsolve.errors import CaseError, FileError, NoSolutionError
from fretsolve.estimate import require_memory
from fretsolve.history import HistoryWriter, RunHeader
from fretsolve.interrupt import EXIT_STOPPED
from fretsolve.scene import Scene, prepare
from fretsolve.simulation import run

if TYPE_CHECKING:
    from fretsolve.case import Case
    from fretsolve.interrupt import StopRequest
    from fretsolve.state import State, SummaryErrors

LIBRARIES = ("numpy", "scipy", "pyfftw", "h5py")


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
    scene = prepare(case)
    require_memory(scene)
    header = run_header(scene, order.threads, order.overrides)
    with HistoryWriter.open(
        order.output, header, resume=order.resume, overwrite=order.overwrite
    ) as writer:
        tell = teller(scene, order)
        if writer.complete:
            tell.already(len(writer.summaries))
            return 0
        tell.begin(writer)
        try:
            complete = _solve(scene, order, writer, stop, tell)
        except NoSolutionError as error:
            writer.finish("failed", str(error))
            tell.end()
            raise
        if complete:
            writer.finish("complete")
    if complete:
        tell.end()
        return 0
    tell.stopped(len(writer.summaries))
    return EXIT_STOPPED


def run_header(scene: Scene, threads: int, overrides: Sequence[str]) -> RunHeader:
    """What the result says about its run. Nothing in it changes from one run of the same case to the next."""
    case = scene.case
    provenance = {
        "threads": threads,
        "precision": case.solver.precision,
        "pointwise_kernels": "compiled" if pointwise.COMPILED else "numpy",
        "overrides": overrides,
        "platform": platform.platform(),
        "python": platform.python_version(),
        **{library: version(library) for library in LIBRARIES},
    }
    return RunHeader(
        case_yaml=case.source.text,
        effective_case=json.dumps(case.effective()),
        coupling=scene.model.coupling,
        model=json.dumps([asdict(decision) for decision in scene.model.decisions]),
        inputs=json.dumps({f"height map {n}": _digest(file) for n, file in enumerate(_height_maps(case), start=1)}),
        provenance=json.dumps(provenance),
        x=scene.grid.x,
        y=scene.grid.y,
        fields=case.output.fields,
        every=case.output.every,
        errors=case.solver.error_estimate,
    )


def _height_maps(case: Case) -> list[Path]:
    return [surface.file for surface in case.surface if isinstance(surface, HeightsSurface)]


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise FileError(f"cannot be read: {os.strerror(error.errno) if error.errno else error}", file) from error


def _keep_inputs(out: Path, case: Case) -> None:
    """Raise CaseError where the result would replace what the run is made from."""
    for source in (case.source.path, *_height_maps(case)):
        if out.exists() and source.exists() and out.samefile(source):
            what = "the case itself" if source == case.source.path else "a height map of the case"
            raise CaseError(f"the result would replace {what}; give another name with -o", (), out)


def _solve(scene: Scene, order: Order, writer: HistoryWriter, stop: StopRequest, tell: Quiet) -> bool:
    """Solve and save what is missing, until the path's end (True) or a signal."""
    path, done = scene.load_path, len(writer.summaries)
    if stop.requested and done < path.increments:
        return False
    with tell.progress(done) as display:
        for state, errors in _states(scene, writer, order.threads, tell):
            writer.append(state, errors)
            display.show(state.summary, errors)
            if stop.requested and len(writer.summaries) < path.increments:
                return False
    return True


def _states(
    scene: Scene, writer: HistoryWriter, threads: int, tell: Quiet
) -> Iterator[tuple[State, SummaryErrors | None]]:
    """What is missing, with error bars where the case asks for them."""
    so_far = writer.last_state, writer.summaries
    if not scene.case.solver.error_estimate:
        yield from ((state, None) for state in run(scene, *so_far, threads))
        return
    yield from run_with_error_bars(scene, *so_far, threads, tell.warn)
