"""Who runs which case: worker processes and what becomes of them, and rounds."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from command_line import PATIENCE
from small_cases import SWEPT
from sweeping import manifest_of, workers

from fretsolve.result.lock import RunLock
from fretsolve.result.parts import parts_folder
from fretsolve.sweep import worker_pool
from fretsolve.sweep.case_run import leave_note
from fretsolve.sweep.manifest import Manifest, ManifestRow, RunReport
from fretsolve.sweep.worker_pool import ROUNDS, free_cases, in_rounds, run_cases


class Stop:
    """A stop once `condition` has held."""

    def __init__(self, condition: Callable[[], bool] = lambda: False):
        self._condition, self._found = condition, False
        self._end = time.monotonic() + PATIENCE

    @property
    def requested(self) -> bool:
        assert time.monotonic() < self._end
        self._found = self._found or self._condition()
        return self._found


@pytest.fixture
def manifest(tmp_path: Path) -> Manifest:
    return manifest_of(tmp_path)


@pytest.fixture
def long(tmp_path: Path) -> Manifest:
    """Six cases that last until they are stopped, for all that tests can wait for."""
    return manifest_of(tmp_path, case=SWEPT.replace("increments: 2", "increments: 100000"))


# Worker processes


@pytest.mark.slow
def test_a_killed_process_costs_its_case_and_no_other(long: Manifest) -> None:
    """Each of two processes is killed while it solves, and the next case gets a new one."""
    killed: list[int] = []

    def kill() -> bool:
        for process in set(workers(long.folder)) - set(killed):
            os.kill(process, signal.SIGKILL)
            killed.append(process)
        return False

    reports = list(run_cases(long, long.rows[:3], 2, Stop(kill)))
    assert sorted(report.index for report in reports) == [0, 1, 2]
    assert len(killed) == 3
    for report in reports:
        assert (report.code, report.reason[:32]) == (75, "the process was ended by SIGKILL")
        assert long.has_ended(long.rows[report.index])


@pytest.mark.slow
def test_a_stop_saves_what_is_done(long: Manifest) -> None:
    reports = list(run_cases(long, long.rows, 2, Stop(lambda: len(workers(long.folder)) == 2)))
    assert [(report.code, report.reason) for report in reports] == [(75, "")] * 2
    assert not any(long.has_ended(row) for row in long.rows)


def test_a_signal_to_a_worker_stops_its_case_alone(long: Manifest) -> None:
    signalled: list[int] = []

    def signal_one() -> bool:
        running = workers(long.folder)
        if running and not signalled:
            os.kill(running[0], signal.SIGTERM)
            signalled.append(running[0])
        return False

    assert [(report.code, report.reason) for report in run_cases(long, long.rows[:1], 1, Stop(signal_one))] == [
        (75, "")
    ]


def test_a_case_that_was_killed_is_noted_one_that_was_stopped_is_not(manifest: Manifest) -> None:
    row = manifest.rows[0]
    leave_note(manifest, row, RunReport(row.index, 75))
    assert not manifest.has_ended(row)
    leave_note(manifest, row, RunReport(row.index, 75, "the process was ended by SIGKILL"))
    assert manifest.has_ended(row)
    leave_note(manifest, row, RunReport(row.index, 75))
    assert not manifest.has_ended(row)


def test_a_worker_whose_command_is_gone_begins_without_a_traceback(manifest: Manifest) -> None:
    context = multiprocessing.get_context("spawn")
    heard, stop = context.Pipe(duplex=False)
    reading, begun = context.Pipe(duplex=False)
    reading.close()
    process = context.Process(target=worker_pool._begin, args=(manifest, heard, begun))
    process.start()
    process.join(PATIENCE)
    stop.close()
    assert process.exitcode == 0


# Rounds


def test_cases_that_have_ended_or_are_running_are_taken(manifest: Manifest) -> None:
    done, failed, busy, free = manifest.rows[:4]
    manifest.result(done).touch()
    leave_note(manifest, failed, RunReport(failed.index, 4, "no room"))
    lock = RunLock.acquire(parts_folder(manifest.result(busy)))
    rows, said = (done, failed, busy, free), list[str]()

    def warn(line: str) -> None:
        said.append(line)
        lock.release()  # as the run ends that the command waits for

    assert [manifest.is_taken(row) for row in rows] == [True, True, True, False]
    assert free_cases(manifest, rows, Stop(), warn) == [free]
    assert free_cases(manifest, (done, failed), Stop(), warn) == []
    assert said == []
    assert free_cases(manifest, (done, busy), Stop(), warn) == [busy]
    assert said == ["cases that other processes are running: 1; waiting for them"]


def test_cases_without_news_are_given_out_again_but_none_that_has_failed(manifest: Manifest) -> None:
    rounds: list[list[int]] = []

    def run(left: list[ManifestRow]) -> Iterator[RunReport]:
        rounds.append([row.index for row in left])
        yield RunReport(0, 0)  # another process has done it; its result is on the way
        yield RunReport(1, 75, "the process was ended by SIGKILL")
        yield RunReport(2, 4, "no room, not even for a note")

    leave_note(manifest, manifest.rows[3], RunReport(3, 4, "of an earlier command"))
    reports = list(in_rounds(manifest, manifest.rows[:4], Stop(), print, run))
    assert [report.index for report in reports] == [1, 2] * ROUNDS
    assert rounds == [[0, 1, 2, 3], [0, 3], [0, 3]]
