"""Worker processes on this machine, by Pebble. One that is killed costs the case it was solving, and no other.

A process serves many cases, since it takes one to two seconds to start an interpreter and to read the compiled kernels,
many times a small case. Processes are spawned: a fork would copy locks that other threads hold. Added to Pebble is how
processes stop: after the current increment, as soon as the command closes its end of a pipe, or is gone, or a signal
reaches the process.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from types import FrameType

from pebble import ProcessExpired, ProcessPool

from fretsolve.errors import EXIT_BUG, FretsolveError
from fretsolve.simulation.run_to_file import Stop
from fretsolve.sweep.case_run import CaseRunner, leave_note
from fretsolve.sweep.manifest import Manifest, ManifestRow, RunReport
from fretsolve.system.signals import EXIT_STOPPED, SIGNALS

POOL_GLANCE = 0.1
"""Seconds between looks at whether to stop."""

ROUNDS = 3
"""Most times that missing cases are given out: other commands may leave some, a dying Dask worker may lose some."""

Warn = Callable[[str], None]
"""Takes a line for people."""

Run = Callable[[list[ManifestRow]], Iterator[RunReport]]


def in_rounds(manifest: Manifest, todo: Sequence[ManifestRow], stop: Stop, warn: Warn, run: Run) -> Iterator[RunReport]:
    """Yield the reports of `run` on the cases `todo`, which gets cases again as long as nothing was heard of them.

    At the end it waits for cases that other processes are running, says so by `warn`, and runs what they leave.
    """
    heard: set[int] = set()
    for row in todo:
        manifest.note(row).unlink(missing_ok=True)  # from now on a note means that the case failed in this run
    for _ in range(ROUNDS):
        left = free_cases(manifest, [row for row in todo if row.index not in heard], stop, warn)
        if not left or stop.requested:
            return
        for report in run(left):
            if not report.of_another:
                heard.add(report.index)
                yield report


def free_cases(manifest: Manifest, rows: Sequence[ManifestRow], stop: Stop, warn: Warn) -> list[ManifestRow]:
    """Return the cases that have not ended and that nobody is running; wait if others are running all that is left."""
    warned = False
    while True:
        left = [row for row in rows if not manifest.has_ended(row)]
        free = [row for row in left if not manifest.is_taken(row)]
        if free or not left or stop.requested:
            return free
        if not warned:
            warn(f"cases that other processes are running: {len(left)}; waiting for them")
            warned = True
        time.sleep(POOL_GLANCE)


def run_cases(manifest: Manifest, rows: Iterable[ManifestRow], jobs: int, stop: Stop) -> Iterator[RunReport]:
    """Run the cases `rows` with `jobs` at a time, see `WorkerPool.run`, and end the processes."""
    with closing(WorkerPool(manifest, jobs)) as pool:
        yield from pool.run(rows, stop)


class WorkerPool:
    """`jobs` processes that solve cases of a sweep. They start with the first case, and stay until `close`."""

    def __init__(self, manifest: Manifest, jobs: int):
        # If the command is killed, multiprocessing is not to warn of the semaphores of Pebble that it clears up.
        os.environ.setdefault("PYTHONWARNINGS", "ignore:resource_tracker")
        context = multiprocessing.get_context("spawn")
        resource_tracker.ensure_running()  # its start unblocks signals, which `run` blocks while processes start
        self._manifest, self._jobs, self._starts = replace(manifest, rows=()), jobs, 0
        heard, self._stop = context.Pipe(duplex=False)
        self._begun, begun = context.Pipe(duplex=False)
        self._pool = ProcessPool(jobs, initializer=_begin, initargs=(self._manifest, heard, begun), context=context)

    def run(self, rows: Iterable[ManifestRow], stop: Stop) -> Iterator[RunReport]:
        """Yield a report as each of the cases `rows` ends; a case that `stop` keeps from starting has none.

        rows: may be lazy, the next case is taken when a process is free. After a stop the pool runs no more cases.
        """
        waiting, running, reports = iter(rows), dict[Future[RunReport], ManifestRow](), list[RunReport]()
        try:
            while True:
                # Give out the next cases before anybody spends time on reports.
                while len(running) < self._jobs and not stop.requested and (row := next(waiting, None)) is not None:
                    with _blocked_signals():  # until the processes have their own handlers
                        running[self._pool.schedule(_solve, (row,))] = row
                        self._starts = self._starts or self._jobs
                yield from reports
                if not running:
                    return
                if stop.requested:
                    self._stop.close()
                done, _ = wait(running, POOL_GLANCE, FIRST_COMPLETED)
                reports = [self._report(future, running.pop(future)) for future in done]
        finally:
            if running:  # nobody wants the reports any more
                self._stop.close()
                wait(running)

    def _report(self, future: Future[RunReport], row: ManifestRow) -> RunReport:
        try:
            return future.result()
        except BrokenProcessPool as error:
            raise FretsolveError("the processes that solve cases end while they start") from error
        except ProcessExpired as error:
            self._starts += 1  # another process takes its place
            report = _report_of_end(row, error.exitcode)
            leave_note(self._manifest, row, report)
            return report

    def close(self) -> None:
        """End the processes, which must have no case."""
        self._stop.close()
        # A process that ends while it starts would print a traceback, so wait until all have begun.
        for _ in range(self._starts):
            if not self._begun.poll(10.0):
                break
            self._begun.recv_bytes()
        self._pool.close()  # type: ignore[no-untyped-call]
        self._pool.join()


def _report_of_end(row: ManifestRow, code: int) -> RunReport:
    """Return the report on a case whose process ended; code: its exit code, or minus the number of a signal."""
    if code == EXIT_STOPPED:
        return RunReport(row.index, code)
    if code >= 0:
        return RunReport(row.index, EXIT_BUG, f"the process ended with exit code {code}")
    name = signal.Signals(-code).name
    hint = "; perhaps there was not enough memory" if name == "SIGKILL" else ""
    from_outside = name in ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP", "SIGXCPU")
    return RunReport(row.index, EXIT_STOPPED if from_outside else EXIT_BUG, f"the process was ended by {name}{hint}")


@contextmanager
def _blocked_signals() -> Iterator[None]:
    """Hold back signals, also from processes that are started in the block: they inherit that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@dataclass
class _Process:
    """A worker process, seen from inside. It is a `Stop` for the case that it is solving."""

    runner: CaseRunner
    pipe: Connection
    signalled: bool = False

    @property
    def requested(self) -> bool:
        """True if the case is to stop. The command sends nothing through the pipe; it only closes it."""
        return self.signalled or self.pipe.poll()

    def note(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal. Those of the terminal are meant for the command, which then closes the pipe."""
        self.signalled = self.signalled or number not in (signal.SIGINT, signal.SIGHUP)


_processes: list[_Process] = []
"""In a worker process: itself. Pebble gives its initializer no other way to hand something to the tasks."""


def _begin(manifest: Manifest, pipe: Connection, begun: Connection) -> None:
    """Prepare a worker process; Pebble's initializer."""
    os.dup2(2, 1)  # standard output belongs to the command
    _processes.append(_Process(CaseRunner(manifest), pipe))
    for number in SIGNALS:
        signal.signal(number, _processes[0].note)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    with suppress(BrokenPipeError):  # the command is gone
        begun.send_bytes(b"begun")


def _solve(row: ManifestRow) -> RunReport:
    """Solve a case in a worker process, which ends if a signal has stopped that."""
    process = _processes[0]
    report = process.runner.run(row, process)
    if process.signalled and report.code == EXIT_STOPPED:
        os._exit(EXIT_STOPPED)  # another process takes its place
    return report
