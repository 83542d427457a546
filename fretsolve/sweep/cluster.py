"""An existing Dask cluster as the engine of a sweep: each Dask task runs cases in a process of its own.

Results are on disk and reports alone are messages. A task begins with its share of the cases and goes on with what is
left of the others' shares, by their files, so that a process lasts as long as there is work: to start one takes a
second. Tasks that find nothing left end at once; what a worker that dies has not finished others take up.
"""

from __future__ import annotations

import hashlib
import math
import queue
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fretsolve.errors import CaseError, FretsolveError
from fretsolve.extras import how_to_install
from fretsolve.history.lock import is_locked
from fretsolve.history.parts import parts_folder
from fretsolve.sweep.crew import work_through
from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.state import missing
from fretsolve.sweep.worker import Report

if TYPE_CHECKING:
    from fretsolve.recording import Stop
    from fretsolve.sweep.manifest import Manifest, Row

ROUNDS = 3
"""How often what is missing is given out: a worker that is killed may take others' cases with it."""

SHARES_PER_THREAD = 3
SHARE_SECONDS = 20.0
"""Of a share by the estimate, unless it is one case: shares beyond the threads are for workers that come later."""

GLANCE = 0.5
"""Seconds between looks at whether to stop."""

LONGEST_WAIT = 15
"""Seconds for a scheduler to answer."""


def work_on_dask(manifest: Manifest, todo: Sequence[Row], address: str, stop: Stop) -> Iterator[Report]:
    """Run the cases `todo` on the workers of the scheduler at `address`; a report as each is heard of.

    Raises CaseError where there is no such scheduler, or no worker.
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
        name = f"fretsolve-{manifest.folder}-{time.time_ns()}"
        halt = Event(name, client=client)
        news: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        client.subscribe_topic(name, lambda event: news.put(event[1]["report"]))
        for row in todo:
            manifest.note(row).unlink(missing_ok=True)  # so that those of now tell which cases are not to be retried
        for _ in range(ROUNDS):
            left = _waiting(manifest, todo)
            if not left or stop.requested:
                return
            common = {"folder": str(manifest.folder), "names": _digest(left), "cases": [row.index for row in left]}
            shares = _shares(left, threads)
            futures = client.map(run_share, range(shares), of=shares, **common, topic=name, pure=False)
            yield from _reports(futures, news, halt, stop)


def run_share(
    share: int, of: int, folder: str, names: str, cases: Sequence[int], topic: str
) -> list[dict[str, Any]]:
    """What a Dask task does: a share of `cases` and what is left of the others, unless the event `topic` is set.

    names: digest of the cases' ids. Its reports are messages under `topic` as well, as they come. Raises CaseError
    where the sweep is another one by now.
    """
    from distributed import get_worker

    stop = _Halt(topic)
    if stop.requested:
        return []
    manifest = read_manifest(Path(folder))
    rows = [manifest.rows[index] for index in cases if index < len(manifest.rows)]
    if _digest(rows) != names:
        raise CaseError("the sweep is another one than when the run began", (), manifest.folder)
    here, told = get_worker(), []
    for report in work_through(manifest, _in_turn(rows, share, of), 1, stop, lambda row: _is_taken(manifest, row)):
        if not report.busy:  # who has the case will tell
            told.append(asdict(report))
            here.log_event(topic, {"report": told[-1]})
    return told


def _waiting(manifest: Manifest, rows: Sequence[Row]) -> list[Row]:
    return [row for row in missing(manifest, rows) if not manifest.note(row).exists()]


def _is_taken(manifest: Manifest, row: Row) -> bool:
    """Whether a case is done or has failed, or somebody is working on it."""
    return not _waiting(manifest, [row]) or is_locked(parts_folder(manifest.result(row)))


def _in_turn(rows: Sequence[Row], share: int, of: int) -> Iterator[Row]:
    """Every `of`-th row, since neighbours may be alike; then those of the other shares, from their ends."""
    yield from rows[share::of]
    for other in range(share + 1, share + of):
        yield from reversed(rows[other % of :: of])


def _digest(rows: Sequence[Row]) -> str:
    return hashlib.sha256(" ".join(row.id for row in rows).encode()).hexdigest()


class _Halt:
    """Whether the event of a name is set, looked at now and then."""

    def __init__(self, name: str):
        from distributed import Event

        self._event = Event(name)
        self._looked, self._found = -math.inf, False

    @property
    def requested(self) -> bool:
        if not self._found and time.monotonic() - self._looked > GLANCE:
            self._looked = time.monotonic()
            with suppress(Exception):  # without a scheduler the share ends as it is
                self._found = bool(self._event.is_set())
        return self._found


def _shares(rows: Sequence[Row], threads: int) -> int:
    """In how many parts to give out cases: some per thread, and more where they take long."""
    seconds = sum(row.seconds for row in rows)
    return min(len(rows), max(threads * SHARES_PER_THREAD, math.ceil(seconds / SHARE_SECONDS)))


def _reports(
    futures: Sequence[Any], news: queue.SimpleQueue[dict[str, Any]], halt: Any, stop: Stop
) -> Iterator[Report]:
    """Reports as they come, each once; those that no message has brought come with the end of their task."""
    from distributed import wait

    left, halted = set(futures), False
    heard: set[int] = set()

    def fresh(told: Sequence[dict[str, Any]]) -> Iterator[Report]:
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
        with suppress(queue.Empty):
            while True:
                yield from fresh([news.get_nowait()])
        for future in [future for future in left if future.status != "pending"]:
            left.discard(future)
            if future.status == "finished":
                yield from fresh(future.result())
            elif future.status == "error" and isinstance(future.exception(), FretsolveError):
                raise future.exception()
