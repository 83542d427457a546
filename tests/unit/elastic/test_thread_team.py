"""Threads that share parts: every part is done once, and errors come back."""

from __future__ import annotations

import contextlib
import gc
import signal
import threading
import time
import weakref

import numpy as np
import pytest

from fretsolve.elastic.thread_team import ThreadTeam


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("parts", [0, 1, 3, 50])
def test_every_part_is_done_once(count: int, parts: int) -> None:
    done: list[tuple[int, int]] = []
    ThreadTeam(count).share(lambda member, part: done.append((member, part)), range(parts))
    assert sorted(part for _, part in done) == list(range(parts))
    assert {member for member, _ in done} <= set(range(min(count, parts)))


def test_members_work_at_the_same_time() -> None:
    both = threading.Barrier(2, timeout=30.0)
    ThreadTeam(2).share(lambda member, part: both.wait() and None, range(2))  # a single thread would wait for ever


@pytest.mark.parametrize("failing", [0, 1])
def test_errors_come_back_and_the_team_works_on(failing: int) -> None:
    both, team, done = threading.Barrier(2, timeout=30.0), ThreadTeam(2), []

    def fail(member: int, part: int) -> None:
        both.wait()
        if member == failing:
            raise OverflowError(f"of member {member}")

    for _ in range(3):
        with pytest.raises(OverflowError, match=f"of member {failing}"):
            team.share(fail, range(2))
    team.share(lambda member, part: done.append(part), range(4))
    assert sorted(done) == [0, 1, 2, 3]


@pytest.mark.parametrize("at_work", [True, False])
def test_an_interrupt_waits_for_the_other_members(at_work: bool) -> None:
    """Whether it meets the caller at its own part or while it waits, nobody writes to the arrays afterwards."""
    both, team, written = threading.Barrier(2, timeout=30.0), ThreadTeam(2), list[int]()

    def work(member: int, part: int) -> None:
        both.wait()
        if member == 0:
            time.sleep(30.0 if at_work else 0.0)
            return
        time.sleep(0.1)  # the caller is at its own part, or waits
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        time.sleep(0.2)
        written.append(member)

    with pytest.raises(KeyboardInterrupt):
        team.share(work, range(2))
    assert written == [1]
    team.share(lambda member, part: written.append(part), range(4))
    assert sorted(written[1:]) == [0, 1, 2, 3]


def test_an_interrupt_goes_before_errors() -> None:
    both = threading.Barrier(2, timeout=30.0)

    def work(member: int, part: int) -> None:
        both.wait()
        if member == 1:
            time.sleep(0.1)
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
            time.sleep(0.1)
        raise OverflowError

    with pytest.raises(KeyboardInterrupt):
        ThreadTeam(2).share(work, range(2))


def test_threads_end_with_their_team() -> None:
    before = set(threading.enumerate())
    team, all_at_once = ThreadTeam(3), threading.Barrier(3, timeout=30.0)
    team.share(lambda member, part: all_at_once.wait() and None, range(3))
    own = set(threading.enumerate()) - before
    assert len(own) == 2
    del team
    for thread in own:
        thread.join(30.0)
    assert not any(thread.is_alive() for thread in own)


@pytest.mark.parametrize("fails", [False, True])
def test_calls_that_have_ended_keep_nothing_alive(fails: bool) -> None:
    team, both, field = ThreadTeam(2), threading.Barrier(2, timeout=30.0), np.zeros(3)
    kept = weakref.ref(field)

    def work(member: int, part: int, field: np.ndarray = field) -> None:
        both.wait()
        if fails and member == 1:
            raise OverflowError

    gc.disable()  # a circle of references would wait for it
    try:
        with contextlib.suppress(OverflowError):
            team.share(work, range(2))
        del work, field
        limit = time.monotonic() + 10.0
        while kept() is not None and time.monotonic() < limit:  # the other thread may still be ending the call
            time.sleep(0.001)
        assert kept() is None
    finally:
        gc.enable()
