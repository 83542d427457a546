"""What Dask tasks take in turn, without Dask."""

from __future__ import annotations

import queue
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from sweeping import write_sweep

from fretsolve.errors import CaseError
from fretsolve.history.lock import RunLock
from fretsolve.history.parts import parts_folder
from fretsolve.sweep import cluster
from fretsolve.sweep.manifest import Manifest, write_manifest
from fretsolve.sweep.plan import make_plan
from fretsolve.sweep.worker import Report, leave_note


class Stop:
    requested = False


@pytest.fixture
def manifest(tmp_path: Path) -> Manifest:
    found = make_plan(write_sweep(tmp_path), tmp_path / "sweep.sweep").manifest
    write_manifest(found)
    return found


@pytest.mark.parametrize("of", [1, 2, 4, 6])
def test_every_task_goes_through_all_cases_once_its_own_first(manifest: Manifest, of: int) -> None:
    firsts = []
    for share in range(of):
        turn = [row.index for row in cluster._in_turn(manifest.rows, share, of)]
        assert sorted(turn) == list(range(6))
        own = turn[: len(range(share, 6, of))]
        assert own == list(range(share, 6, of))
        firsts += own
    assert sorted(firsts) == list(range(6))


def test_shares_are_some_per_thread_more_of_long_cases_and_never_very_many(manifest: Manifest) -> None:
    def shares(count: int, seconds: float) -> int:
        return cluster._shares([replace(manifest.rows[0], seconds=seconds)] * count, threads=2)

    assert shares(4, 0.1) == 4
    assert shares(1000, 0.1) == 6
    assert shares(1000, 1.0) == 50
    assert shares(1000, 600.0) == cluster.MOST_SHARES


def test_cases_that_have_ended_or_are_worked_on_are_taken(manifest: Manifest) -> None:
    done, failed, busy, free = manifest.rows[:4]
    manifest.result(done).touch()
    leave_note(manifest, failed, Report(failed.index, 4, "no room"))
    lock = RunLock.acquire(parts_folder(manifest.result(busy)))
    assert [cluster._is_taken(manifest, row) for row in (done, failed, busy, free)] == [True, True, True, False]
    rows = (done, failed, busy, free)
    assert cluster._untouched(manifest, rows, Stop()) == [free]
    assert cluster._untouched(manifest, (done, failed), Stop()) == []
    threading.Timer(0.2, lock.release).start()
    assert cluster._untouched(manifest, (done, busy), Stop()) == [busy]  # once its run has let go of it


def test_a_case_that_was_killed_is_noted_where_others_would_try_it_again(manifest: Manifest) -> None:
    row = manifest.rows[0]
    killed = Report(row.index, 75, "the process was ended by SIGKILL")
    leave_note(manifest, row, killed)
    assert not cluster._has_ended(manifest, row)
    leave_note(manifest, row, killed, also_of_stopped=True)
    assert cluster._has_ended(manifest, row)


def test_a_task_notes_what_was_killed_and_tells_nothing_of_cases_that_others_have(
    manifest: Manifest, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[cluster.Told] = []

    class News:
        def __init__(self, topic: str):
            self.add = sent.append

        def send(self) -> None:
            pass

    killed = Report(0, 75, "the process was ended by SIGKILL")
    found = [killed, Report(1, 4, "busy", busy=True), Report(2, 0, increments=3)]
    monkeypatch.setattr(cluster, "_Halt", lambda topic: Stop())
    monkeypatch.setattr(cluster, "_News", News)
    monkeypatch.setattr(cluster, "work_through", lambda *rest: iter(found))
    told = cluster.run_share(0, 1, str(manifest.folder), cluster._digest(manifest), "topic")
    assert told == sent
    assert [values["index"] for values in told] == [0, 2]
    assert [cluster._has_ended(manifest, row) for row in manifest.rows[:3]] == [True, False, False]
    with pytest.raises(CaseError, match="another one than when the run began"):
        cluster.run_share(0, 1, str(manifest.folder), "another", "topic")


def test_the_digest_tells_sweeps_apart(manifest: Manifest) -> None:
    assert cluster._digest(manifest) == cluster._digest(replace(manifest, title="another"))
    assert cluster._digest(manifest) != cluster._digest(replace(manifest, rows=manifest.rows[:-1]))


def test_all_news_are_drained() -> None:
    news: queue.SimpleQueue[list[cluster.Told]] = queue.SimpleQueue()
    assert cluster._drained(news) == []
    news.put([{"index": 0}, {"index": 1}])
    news.put([{"index": 2}])
    assert [told["index"] for told in cluster._drained(news)] == [0, 1, 2]
    assert cluster._drained(news) == []
