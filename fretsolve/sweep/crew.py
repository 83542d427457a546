"""Worker processes that share out cases among them, and outlive the failure of any of them."""

from __future__ import annotations

import json
import selectors
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

from fretsolve.sweep.process import ServingProcess, start
from fretsolve.sweep.state import has_ended, is_taken
from fretsolve.sweep.worker import EXIT_BUG, Report, leave_note
from fretsolve.system.signals import EXIT_STOPPED

if TYPE_CHECKING:
    from fretsolve.simulation.run_to_file import Stop
    from fretsolve.sweep.manifest import Manifest, Row

GLANCE = 0.1
"""Seconds between looks at whether to stop."""

ROUNDS = 3
"""How often what is missing is given out: a process that is killed may take others' cases with it."""

FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGXCPU)
"""Signals that end a process through no fault of its own."""


Tell = Callable[[str], None]
"""Takes a line for people."""


class Worker:
    """A process that serves, and the case that it works on."""

    def __init__(self, manifest: Manifest, others: Sequence[Worker]):
        self.process: ServingProcess = start(manifest.folder, [other.process for other in others])
        self.index: int | None = None

    def order(self, row: Row) -> None:
        """Have it work on a case."""
        self.index = row.index
        with suppress(BrokenPipeError):  # it has died: so its reports will say
            self.process.orders.write(f"{row.index} {row.id}\n")
            self.process.orders.flush()

    def dismiss(self) -> None:
        """Have it stop after the increment."""
        with suppress(BrokenPipeError):
            self.process.orders.close()

    def report(self) -> Report | None:
        """The report that can be read now; None where the process has ended instead."""
        line = self.process.reports.readline()
        return Report(**json.loads(line)) if line.endswith("\n") else None

    def end(self) -> Report | None:
        """Wait for its end; a report where that came in the middle of a case."""
        self.dismiss()
        self.process.reports.close()
        code = self.process.wait()
        if self.index is None:
            return None
        if code == EXIT_STOPPED:
            return Report(self.index, code)
        if code >= 0:
            return Report(self.index, code or EXIT_BUG, f"the process ended with exit code {code}")
        number = signal.Signals(-code)
        outside = number in FROM_OUTSIDE
        hint = ", perhaps since the memory did not suffice" if number == signal.SIGKILL else ""
        return Report(
            self.index, EXIT_STOPPED if outside else EXIT_BUG, f"the process was ended by {number.name}{hint}"
        )


def in_rounds(
    manifest: Manifest,
    todo: Sequence[Row],
    stop: Stop,
    tell: Tell,
    give_out: Callable[[list[Row]], Iterator[Report]],
) -> Iterator[Report]:
    """The reports of `give_out` on the cases `todo`, given out again as long as nothing has been heard of some.

    For those that other processes work on it waits at the end, which `tell` is told, and has done what they leave.
    """
    heard: set[int] = set()
    for row in todo:
        manifest.note(row).unlink(missing_ok=True)  # so that those of now tell which cases have failed
    for _ in range(ROUNDS):
        left = _free(manifest, [row for row in todo if row.index not in heard], stop, tell)
        if not left or stop.requested:
            return
        for report in give_out(left):
            if not report.of_another:
                heard.add(report.index)
                yield report


def _free(manifest: Manifest, rows: Sequence[Row], stop: Stop, tell: Tell) -> list[Row]:
    """The cases that nobody has finished, failed at or is working on; waits while there are but the last."""
    told = False
    while True:
        left = [row for row in rows if not has_ended(manifest, row)]
        free = [row for row in left if not is_taken(manifest, row)]
        if free or not left or stop.requested:
            return free
        if not told:
            tell(f"cases that other processes are running: {len(left)}; waiting for them")
            told = True
        time.sleep(GLANCE)


class _Crew:
    """The workers of a share of the cases, and what of it is not given out yet."""

    def __init__(
        self,
        manifest: Manifest,
        rows: Iterator[Row],
        stop: Stop,
        taken: Callable[[Row], bool],
        selector: selectors.BaseSelector,
    ):
        self.workers: list[Worker] = []
        self._manifest, self._rows, self._stop, self._taken, self._selector = manifest, rows, stop, taken, selector

    def hire(self) -> None:
        """Have one more process work, if there is work for it."""
        row = self._next_row()
        if row is not None:
            worker = Worker(self._manifest, self.workers)
            self._selector.register(worker.process.reports, selectors.EVENT_READ, worker)
            self.workers.append(worker)
            worker.order(row)

    def hear(self, worker: Worker) -> Report | None:
        """What a worker has to say, or its end; it or another one goes on before anybody takes time over that."""
        report = worker.report()
        if report is None:
            report = self.retire(worker)
            if report is not None:
                leave_note(self._manifest, self._manifest.rows[report.index], report)
            self.hire()
            return report
        worker.index = None
        row = self._next_row() if report.code != EXIT_STOPPED else None  # such a one ends
        if row is not None:
            worker.order(row)
        else:
            worker.dismiss()
        return report

    def retire(self, worker: Worker) -> Report | None:
        """Wait for a worker's end; a report where that came in the middle of a case."""
        self.workers.remove(worker)
        self._selector.unregister(worker.process.reports)
        return worker.end()

    def retire_all(self) -> None:
        """Wait for the end of each, also where one raises an error."""
        with ExitStack() as ending:
            for worker in self.workers:
                ending.callback(self.retire, worker)

    def _next_row(self) -> Row | None:
        return None if self._stop.requested else next((row for row in self._rows if not self._taken(row)), None)


def work_through(
    manifest: Manifest,
    rows: Iterable[Row],
    jobs: int,
    stop: Stop,
    taken: Callable[[Row], bool] = lambda row: False,
) -> Iterator[Report]:
    """Run the cases `rows` with `jobs` at a time; a report as each ends, none of those that `stop` keeps from it.

    A worker that dies costs the case that it was working on; another takes its place. taken: whether somebody else has
    a case by the time that its turn comes. Raises OSError where no process can be started.
    """
    with selectors.DefaultSelector() as selector:
        crew = _Crew(manifest, iter(rows), stop, taken, selector)
        try:
            for _ in range(jobs):
                crew.hire()
            while crew.workers:
                if stop.requested:
                    for worker in crew.workers:
                        worker.dismiss()
                for key, _ in selector.select(GLANCE):
                    report = crew.hear(key.data)
                    if report is not None:
                        yield report
        finally:
            crew.retire_all()
