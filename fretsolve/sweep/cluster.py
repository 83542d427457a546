"""An existing Dask cluster as the engine of a sweep: each Dask task runs cases in a process of its own.

Results are on disk and reports alone are messages. A task begins with its share of the cases and goes on with what is
left of the others' shares, by their files, so that a process lasts as long as there is work: to start one takes a
second. Tasks that find nothing left end at once; what a worker that dies has not finished others take up. A case that
has failed has a note, so that it is not tried again by each.
"""

from __future__ import annotations

import hashlib
import math
import queue
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fretsolve.errors import CaseError, FileError, FretsolveError
from fretsolve.sweep.crew import in_rounds, work_through
from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.state import is_taken, missing
from fretsolve.sweep.worker import Report
from fretsolve.system.optional import how_to_install

if TYPE_CHECKING:
    from fretsolve.simulation.run_to_file import Stop
    from fretsolve.sweep.crew import Tell
    from fretsolve.sweep.manifest import Manifest, Row

SHARES_PER_THREAD = 3
SHARE_SECONDS = 20.0
MOST_SHARES = 100
"""Of a share by the estimate, unless it is one case; shares beyond the threads are for workers that come later."""

GLANCE = 0.5
"""Seconds between looks at whether to stop, and between messages."""

LONGEST_WAIT = 15
"""Seconds for a scheduler to answer."""

Told = dict[str, Any]
"""A report as it is sent."""


def work_on_dask(
    manifest: Manifest, todo: Sequence[Row], address: str, stop: Stop, tell: Tell
) -> Iterator[Report]:
    """Run the cases `todo` on the workers of the scheduler at `address`; a report as each is heard of.

    tell: told what it waits for. Raises CaseError where there is no such scheduler, or no worker, and FileError where
    the scheduler goes away.
    """
    try:
        from distributed import Client, Event
    except ImportError as error:
        raise CaseError(f"Dask cannot be imported ({error}): {how_to_install('scale')}") from error
    try:
        client = Client(address, timeout=LONGEST_WAIT)
    except (OSError, ValueError) as error:
        raise CaseError(f"no Dask scheduler answers: {error}", (), f"--on dask:{address}") from None
    with client:
        threads = sum(client.nthreads().values())
        if not threads:
            raise CaseError("the scheduler has no workers; start some", (), f"--on dask:{address}")
        topic = f"fretsolve-{manifest.folder}-{time.time_ns()}"
        halt = Event(topic, client=client)
        news: queue.SimpleQueue[list[Told]] = queue.SimpleQueue()
        client.subscribe_topic(topic, lambda event: news.put(event[1]["reports"]))

        def give_out(left: list[Row]) -> Iterator[Report]:
            common = {"folder": str(manifest.folder), "names": _digest(manifest), "topic": topic}
            shares = _shares(left, threads)
            futures = client.map(run_share, range(shares), of=shares, **common, pure=False)
            yield from _reports(futures, news, halt, stop)

        try:
            yield from in_rounds(manifest, todo, stop, tell, give_out)
        except (CancelledError, OSError) as error:
            if client.status == "running":
                raise
            gone = "the scheduler does not answer any more; what is done stays, and the same command goes on"
            raise FileError(gone, f"--on dask:{address}") from error
        finally:
            with suppress(Exception):  # without a scheduler there is nobody to tell
                halt.set()  # tasks that run on must not begin another case


def run_share(share: int, of: int, folder: str, names: str, topic: str) -> list[Told]:
    """What a Dask task does: a share of the cases and what is left of the others, unless the event `topic` is set.

    names: digest of the cases' ids. Its reports are messages under `topic` as well, every now and then. Raises
    CaseError where the sweep is another one by now.
    """
    stop = _Halt(topic)
    if stop.requested:
        return []
    manifest = read_manifest(Path(folder))
    if _digest(manifest) != names:
        raise CaseError("the sweep is another one than when the run began", (), manifest.folder)
    news, told = _News(topic), []
    rows = _in_turn(missing(manifest), share, of)
    for report in work_through(manifest, rows, 1, stop, lambda row: is_taken(manifest, row)):
        if not report.of_another:
            told.append(asdict(report))
            news.add(told[-1])
    news.send()
    return told


def _in_turn(rows: Sequence[Row], share: int, of: int) -> Iterator[Row]:
    """Every `of`-th row, since neighbours may be alike; then those of the other shares, from their ends."""
    yield from rows[share::of]
    for other in range(share + 1, share + of):
        yield from reversed(rows[other % of :: of])


def _digest(manifest: Manifest) -> str:
    return hashlib.sha256(" ".join(row.id for row in manifest.rows).encode()).hexdigest()


def _shares(rows: Sequence[Row], threads: int) -> int:
    """In how many parts to give out cases: some per thread, and more where they take long."""
    seconds = sum(row.seconds for row in rows)
    return min(len(rows), max(threads * SHARES_PER_THREAD, min(math.ceil(seconds / SHARE_SECONDS), MOST_SHARES)))


class _News:
    """Sends reports to whoever has subscribed to a topic, several at a time: a message takes milliseconds of all."""

    def __init__(self, topic: str):
        from distributed import get_worker

        self._worker, self._topic = get_worker(), topic
        self._waiting: list[Told] = []
        self._sent = -math.inf

    def add(self, told: Told) -> None:
        """Send a report, at once or with those that follow."""
        self._waiting.append(told)
        if time.monotonic() - self._sent > GLANCE:
            self.send()

    def send(self) -> None:
        """Send what waits."""
        if self._waiting:
            self._worker.log_event(self._topic, {"reports": self._waiting})
            self._waiting, self._sent = [], time.monotonic()


class _Halt:
    """Whether the event of a name is set or nobody wants the task any more, looked at now and then."""

    def __init__(self, name: str):
        from distributed import Event, get_worker

        self._event, self._worker = Event(name), get_worker()
        self._task = self._worker.get_current_task()
        self._looked, self._found = -math.inf, False

    @property
    def requested(self) -> bool:
        if not self._found and time.monotonic() - self._looked > GLANCE:
            self._looked = time.monotonic()
            task = self._worker.state.tasks.get(self._task)
            self._found = task is None or task.state == "cancelled"
            try:
                self._found = self._found or bool(self._event.is_set())
            except Exception:  # without a scheduler nobody hears of what would come
                self._found = True
        return self._found


def _reports(
    futures: Sequence[Any], news: queue.SimpleQueue[list[Told]], halt: Any, stop: Stop
) -> Iterator[Report]:
    """Reports as they come, each once; those that no message has brought come with the end of their task."""
    from distributed import wait

    left, halted = set(futures), False
    heard: set[int] = set()

    def fresh(told: Sequence[Told]) -> Iterator[Report]:
        for values in told:
            if values["index"] not in heard:
                heard.add(values["index"])
                yield Report(**values)

    while left:
        if stop.requested and not halted:
            halt.set()  # so that the shares under way stop, and those to come do not begin
            halted = True
        with suppress(TimeoutError):
            wait(left, timeout=GLANCE, return_when="FIRST_COMPLETED")
        yield from fresh(_drained(news))
        for future in [future for future in left if future.status != "pending"]:
            left.discard(future)
            if future.status == "finished":
                yield from fresh(future.result())
            elif future.status == "error" and isinstance(future.exception(), FretsolveError):
                raise future.exception()
    yield from fresh(_drained(news))


def _drained(news: queue.SimpleQueue[list[Told]]) -> list[Told]:
    """All that has come."""
    told: list[Told] = []
    with suppress(queue.Empty):
        while True:
            told += news.get_nowait()
    return told
