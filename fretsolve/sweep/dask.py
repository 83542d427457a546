"""An existing Dask cluster as the engine of a sweep.

A Dask task runs a case, or some small ones, and returns the reports; results go to the folder, which all workers share.
Each thread of a Dask worker solves in a process of its own, so that a case that is killed costs neither the Dask worker
nor other cases. That process stays from task to task, since it takes a second or more to start. If a Dask worker dies,
its cluster runs the task again, which skips what is done and resumes the rest.
"""

from __future__ import annotations

import math
import multiprocessing
import queue
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from fretsolve.errors import CaseError, FileError, FretsolveError
from fretsolve.simulation.run_to_file import Stop
from fretsolve.sweep.manifest import Manifest, ManifestRow, RunReport
from fretsolve.sweep.worker_pool import Warn, WorkerPool, in_rounds
from fretsolve.system.environment import how_to_install

TASKS_PER_THREAD = 10
"""At least, so that all threads end at about the same time."""

DASK_GLANCE = 0.5
"""Seconds between looks at whether to stop."""


def run_on_dask(
    manifest: Manifest, todo: Sequence[ManifestRow], address: str, stop: Stop, warn: Warn
) -> Iterator[RunReport]:
    """Run the cases `todo` on the workers of the scheduler at `address`; yield the reports as tasks end.

    warn: is told what the command waits for. Raises CaseError if no scheduler answers or it has no workers, FileError
    if the scheduler goes away.
    """
    try:
        from distributed import Client, Event
    except ImportError as error:
        raise CaseError(f"Dask cannot be imported ({error}): {how_to_install('scale')}") from error
    place = f"--on dask:{address}"
    try:
        client = Client(address, timeout=15)
    except (OSError, ValueError) as error:
        raise CaseError(f"no Dask scheduler answers: {error}", (), place) from None
    with client:
        threads = sum(client.nthreads().values())
        if not threads:
            raise CaseError("the scheduler has no workers; start some", (), place)
        halt = Event(f"fretsolve-{manifest.folder}-{time.time_ns()}", client=client)

        def run(left: list[ManifestRow]) -> Iterator[RunReport]:
            futures = client.map(run_task, in_tasks(manifest, left, threads), name=halt.name, pure=False)
            yield from _reports(futures, halt, stop)
            if client.status != "running":
                gone = "the scheduler has stopped answering; finished cases stay, and the same command goes on"
                raise FileError(gone, place)

        try:
            yield from in_rounds(manifest, todo, stop, warn, run)
        finally:
            with suppress(Exception):  # the scheduler may be gone
                halt.set()  # tasks that still run start no other case


def in_tasks(manifest: Manifest, rows: Sequence[ManifestRow], threads: int) -> list[Manifest]:
    """Return the cases `rows` as tasks, each a manifest of its own; neighbours, which may be alike, are spread.

    A task takes a second or more if there are many: the scheduler takes milliseconds for each.
    """
    seconds = sum(row.seconds for row in rows)
    count = min(len(rows), max(threads * TASKS_PER_THREAD, math.ceil(seconds)))
    return [replace(manifest, rows=tuple(rows[first::count])) for first in range(count)]


def run_task(manifest: Manifest, name: str) -> list[RunReport]:
    """Run the cases of `manifest` in a Dask worker, until the event `name` is set; return their reports."""
    runner: _TaskRunner | None = getattr(_of_thread, "runner", None)
    if runner is None or runner.name != name:
        if runner is not None:
            runner.pool.close()
        runner = _of_thread.runner = _TaskRunner(manifest, name)
    free = (row for row in manifest.rows if not manifest.is_taken(row))
    return [report for report in runner.pool.run(free, runner) if not report.of_another]


class _TaskRunner:
    """Runs the tasks of one command in a thread of a Dask worker, and asks them to stop.

    They stop if the event `name` is set, or nobody wants the current task's result any more.
    """

    def __init__(self, manifest: Manifest, name: str):
        from distributed import Event, get_worker

        multiprocessing.current_process().daemon = False  # a nanny's worker is daemonic: it may start no process
        self.name, self.pool = name, WorkerPool(manifest, 1)
        self._event, self._worker = Event(name), get_worker()
        self._looked, self._found = -math.inf, False

    @property
    def requested(self) -> bool:
        if not self._found and time.monotonic() - self._looked > DASK_GLANCE:
            self._looked = time.monotonic()
            task = self._worker.state.tasks.get(self._worker.get_current_task())
            self._found = task is None or task.state == "cancelled"
            try:
                self._found = self._found or bool(self._event.is_set())
            except Exception:  # without a scheduler nobody reads what would be returned
                self._found = True
        return self._found


_of_thread = threading.local()
"""The `runner` of each thread of a Dask worker, from task to task."""


def _reports(futures: Sequence[Any], halt: Any, stop: Stop) -> Iterator[RunReport]:
    """Yield the reports of tasks as these end; a task that was lost has none."""
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    for future in futures:
        future.add_done_callback(ended.put)
    left, halted = len(futures), False
    while left:
        if stop.requested and not halted:
            halt.set()  # running tasks stop, and waiting ones end at once
            halted = True
        with suppress(queue.Empty):
            future = ended.get(timeout=DASK_GLANCE)
            left -= 1
            if future.status == "finished":
                yield from future.result()
            elif future.status == "error" and isinstance(future.exception(), FretsolveError):
                raise future.exception()
