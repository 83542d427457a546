"""Threads that share parts: every part is done once, and errors come back."""

from __future__ import annotations

import threading

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
def test_errors_come_back(failing: int) -> None:
    both = threading.Barrier(2, timeout=30.0)

    def work(member: int, part: int) -> None:
        both.wait()
        if member == failing:
            raise OverflowError(f"of member {member}")

    with pytest.raises(OverflowError, match=f"of member {failing}"):
        ThreadTeam(2).share(work, range(2))
