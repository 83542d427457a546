"""A process that solves cases of a sweep, one after another, each into its result file.

It speaks with the process that started it by two pipes: index and id of a case on a line of the one are an order, a
line of JSON on the other the report on it. The end of the orders asks it to stop after the increment, so that it does
so as well when whoever started it is gone. A case that fails does not touch the next one; a crash ends this process
alone.
"""

from __future__ import annotations

import json
import os
import select
import signal
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.errors import BusyError, CaseError, FretsolveError, NoSolutionError
from fretsolve.system.signals import EXIT_STOPPED, SIGNALS

if TYPE_CHECKING:
    from types import FrameType

    from fretsolve.simulation.run_to_file import Stop
    from fretsolve.sweep.base import Base
    from fretsolve.sweep.manifest import Manifest, Row

EXIT_BUG = 70

UNSAVED = 2.0
"""Seconds of work that a kill may cost: a small case is written once, which takes less than saving each increment."""


@dataclass(frozen=True)
class Report:
    """How the run of a case has ended.

    code: that of `fretsolve run`, 0 or 3 where there is a result now; busy: another run is writing it. reason: one
    line, empty where there is nothing to say. increments: in the result; seconds: that this run took.
    """

    index: int
    code: int
    reason: str = ""
    busy: bool = False
    increments: int = 0
    seconds: float = 0.0

    @property
    def has_result(self) -> bool:
        """Whether the case has its result, be it that there is no solution."""
        return self.code in (0, NoSolutionError.exit_code)

    @property
    def wrote_result(self) -> bool:
        """Whether this run has written the result: one that was there already has had no increments to tell of."""
        return self.code == NoSolutionError.exit_code or (self.code == 0 and self.increments > 0)

    @property
    def of_another(self) -> bool:
        """Whether another process has the case or has done it, and tells of it."""
        return self.busy or (self.has_result and not self.wrote_result)


class Orders:
    """A pipe as the source of orders, whose end or a signal requests a stop. signalled: whether a signal has."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self.signalled = False
        for number in SIGNALS:
            signal.signal(number, self._note)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)

    @property
    def requested(self) -> bool:
        """Whether to stop: no order comes while one is worked on, so that what can be read is the end."""
        return self.signalled or bool(select.select([self._descriptor], [], [], 0.0)[0])

    def next(self) -> tuple[int, str] | None:
        """Index and id of the next case, None at the end."""
        line = b""
        while not line.endswith(b"\n"):
            if self.signalled:
                return None
            if not select.select([self._descriptor], [], [], 0.5)[0]:
                continue
            byte = os.read(self._descriptor, 1)
            if not byte:
                return None
            line += byte
        index, identity = line.decode().split()
        return int(index), identity

    def _note(self, number: int, frame: FrameType | None) -> None:
        # That of the terminal is meant for the parent, which closes the pipe once it wants to stop.
        if number != signal.SIGINT:
            self.signalled = True


def serve(folder: Path, orders_from: int, reports_to: int) -> int:
    """Work on orders until they end. orders_from, reports_to: file descriptors.

    Returns the exit code; raises CaseError and FileError where manifest or case cannot be read.
    """
    orders = Orders(orders_from)  # before heavy imports, in which a signal would end the process
    reports = os.fdopen(reports_to, "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever prints is no result of the command
    from fretsolve.sweep.base import Base
    from fretsolve.sweep.manifest import read_manifest

    manifest = read_manifest(folder)
    base = Base.read(manifest.case, manifest.overrides, manifest.threads)
    while (order := orders.next()) is not None:
        try:
            report = run_case(manifest, base, manifest.row(*order), orders)
        except CaseError as error:
            report = Report(order[0], error.exit_code, str(error))
        try:
            reports.write(json.dumps(asdict(report)) + "\n")
            reports.flush()
        except BrokenPipeError:  # nobody waits for it any more
            return EXIT_STOPPED
        if report.code == EXIT_STOPPED:
            return EXIT_STOPPED
    return EXIT_STOPPED if orders.signalled else 0


def run_case(manifest: Manifest, base: Base, row: Row, stop: Stop) -> Report:
    """Solve what is missing of a case. Errors are in the report, and in the case's note where there is no result."""
    began = time.perf_counter()
    out, increments = manifest.result(row), 0
    if out.exists():
        return Report(row.index, 0)

    from fretsolve.result import SAME_COMMAND, HistoryWriter
    from fretsolve.simulation.run_to_file import Saving, missing_states
    from fretsolve.sweep.base import identity

    reason, code, busy = "", 0, False
    try:
        setup = base.setup(row.settings)
        header = base.header(setup, row.settings)
        if identity(header) != row.id:
            message = "is not as it was when the sweep was begun; give the command sweep run again"
            raise CaseError(message, (), manifest.case)
        with HistoryWriter.open(
            out, header, resume=True, retry=False, pause=UNSAVED, advice=SAME_COMMAND
        ) as writer:
            if writer.complete:  # another process has been faster
                return Report(row.index, 0)
            try:
                with Saving(writer, setup.load_path.increments) as saving:
                    states = missing_states(setup, writer, manifest.threads)
                    while not stop.requested and (state := next(states, None)) is not None:
                        saving.append(state)
                code = 0 if saving.complete else EXIT_STOPPED
            finally:
                increments = len(writer.summaries)
    except BusyError as error:
        reason, code, busy = str(error), error.exit_code, True
    except FretsolveError as error:
        reason, code = " ".join(str(error).splitlines()), error.exit_code
    except MemoryError:
        reason, code = "the memory does not suffice; fewer grid.points are needed", CaseError.exit_code
    except Exception as error:
        if os.environ.get("FRETSOLVE_DEBUG"):
            raise
        reason, code = f"internal error: {type(error).__name__}: {' '.join(str(error).split())}", EXIT_BUG
    report = Report(row.index, code, reason, busy, increments, time.perf_counter() - began)
    leave_note(manifest, row, report)
    return report


def leave_note(manifest: Manifest, row: Row, report: Report) -> None:
    """Say beside the results why a case has none, unless it was stopped for no reason of its own.

    A full disk keeps nobody from going on.
    """
    note = manifest.note(row)
    with suppress(OSError):
        if report.has_result or (report.code == EXIT_STOPPED and not report.reason):
            note.unlink(missing_ok=True)
        elif not report.busy:
            note.write_text(json.dumps({"exit_code": report.code, "reason": report.reason}), encoding="utf-8")
