"""An existing Dask cluster as the engine of a sweep: each Dask task runs a share of the cases in a process of its own.

Results are on disk and reports alone are messages. What a worker that dies has not finished is given to another one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fretsolve.errors import CaseError, FretsolveError
from fretsolve.extras import how_to_install
from fretsolve.sweep.crew import work_through
from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.state import missing
from fretsolve.sweep.worker import Report

if TYPE_CHECKING:
    from fretsolve.recording import Stop
    from fretsolve.sweep.manifest import Manifest, Row

ROUNDS = 3
"""How often what is missing is given out: a worker that is killed may take others' shares with it."""

SHARES_PER_THREAD = 3
SHARE_SECONDS = 20.0
"""A share takes at most so long by the estimate, unless it is one case: its process takes a second to start."""

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
        halt = Event(f"fretsolve-{manifest.folder}-{time.time_ns()}", client=client)
        for _ in range(ROUNDS):
            left = missing(manifest, todo)
            if not left or stop.requested:
                return
            shares = [[(row.index, row.id) for row in share] for share in _shares(left, threads)]
            futures = client.map(run_share, shares, folder=str(manifest.folder), halt=halt.name, pure=False)
            yield from _reports(futures, halt, stop)


def run_share(share: Sequence[tuple[int, str]], folder: str, halt: str) -> list[dict[str, Any]]:
    """What a Dask task does: the cases of these indices and ids, one after another, unless the event `halt` is set."""
    stop = _Halt(halt)
    if stop.requested:
        return []
    manifest = read_manifest(Path(folder))
    rows = missing(manifest, [manifest.row(*names) for names in share])
    return [asdict(report) for report in work_through(manifest, rows, 1, stop)]


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


def _shares(rows: Sequence[Row], threads: int) -> list[Sequence[Row]]:
    """Rows in parts: some per thread, so that none waits long for the last, but not so short as to start in vain."""
    most = math.ceil(len(rows) / (threads * SHARES_PER_THREAD))
    mean = sum(row.seconds for row in rows) / len(rows)
    size = max(1, min(most, int(SHARE_SECONDS / max(mean, 1e-9))))
    return [rows[first : first + size] for first in range(0, len(rows), size)]


def _reports(futures: Sequence[Any], halt: Any, stop: Stop) -> Iterator[Report]:
    from distributed import wait

    left, halted = set(futures), False
    while left:
        if stop.requested and not halted:
            halt.set()  # so that the shares under way stop, and those to come do not begin
            halted = True
        with suppress(TimeoutError):
            wait(left, timeout=GLANCE, return_when="FIRST_COMPLETED")
        for future in [future for future in left if future.status != "pending"]:
            left.discard(future)
            if future.status == "finished":
                yield from (Report(**values) for values in future.result())
            elif future.status == "error" and isinstance(future.exception(), FretsolveError):
                raise future.exception()
