"""Who runs which case: what Dask tasks take in turn, without Dask, and what is given out again."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sweeping import write_sweep

from fretsolve.errors import CaseError
from fretsolve.result.lock import RunLock
from fretsolve.result.parts import parts_folder
from fretsolve.sweep import cluster, crew
from fretsolve.sweep.manifest import Manifest, Row, write_manifest
from fretsolve.sweep.plan import make_plan
from fretsolve.sweep.state import has_ended, is_taken
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
    rows, said = (done, failed, busy, free), list[str]()
    assert [is_taken(manifest, row) for row in rows] == [True, True, True, False]
    assert crew._free(manifest, rows, Stop(), said.append) == [free]
    assert crew._free(manifest, (done, failed), Stop(), said.append) == []
    threading.Timer(0.2, lock.release).start()
    assert said == []
    assert crew._free(manifest, (done, busy), Stop(), said.append) == [busy]  # once its run has let go of it
    assert said == ["cases that other processes are running: 1; waiting for them"]


def test_what_is_not_heard_of_is_given_out_again_but_nothing_that_has_failed(manifest: Manifest) -> None:
    rounds: list[list[int]] = []

    def give_out(left: list[Row]) -> Iterator[Report]:
        rounds.append([row.index for row in left])
        yield Report(0, 0)  # another process has done it; its result is on the way
        yield Report(1, 75, "the process was ended by SIGKILL")
        yield Report(2, 4, "no room, not even for a note")

    leave_note(manifest, manifest.rows[3], Report(3, 4, "of an earlier command"))
    reports = list(crew.in_rounds(manifest, manifest.rows[:4], Stop(), print, give_out))
    assert [report.index for report in reports] == [1, 2] * crew.ROUNDS
    assert rounds == [[0, 1, 2, 3], [0, 3], [0, 3]]


def test_a_case_that_was_killed_is_noted_one_that_was_stopped_is_not(manifest: Manifest) -> None:
    row = manifest.rows[0]
    leave_note(manifest, row, Report(row.index, 75))
    assert not has_ended(manifest, row)
    leave_note(manifest, row, Report(row.index, 75, "the process was ended by SIGKILL"))
    assert has_ended(manifest, row)
    leave_note(manifest, row, Report(row.index, 75))
    assert not has_ended(manifest, row)


def test_a_task_tells_nothing_of_cases_that_others_have(
    manifest: Manifest, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[cluster.Told] = []

    class News:
        def __init__(self, topic: str):
            self.add = sent.append

        def send(self) -> None:
            pass

    killed = Report(0, 75, "the process was ended by SIGKILL")
    found = [killed, Report(1, 4, "busy", busy=True), Report(2, 0, increments=3), Report(3, 0)]
    monkeypatch.setattr(cluster, "_Halt", lambda topic: Stop())
    monkeypatch.setattr(cluster, "_News", News)
    monkeypatch.setattr(cluster, "work_through", lambda *rest: iter(found))
    told = cluster.run_share(0, 1, str(manifest.folder), cluster._digest(manifest), "topic")
    assert told == sent
    assert [values["index"] for values in told] == [0, 2]
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
