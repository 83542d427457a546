"""Threads that share out the parts of a task which do not touch each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

Part = TypeVar("Part")


class Team:
    """`count` threads, the caller's among them. What is computed does not depend on who does which part."""

    def __init__(self, count: int = 1):
        self.count = count
        self._others = ThreadPoolExecutor(count - 1, "transforms") if count > 1 else None

    def share(self, work: Callable[[int, Part], None], parts: Sequence[Part]) -> None:
        """``work(member, part)`` for all parts, those of one member (0 to `count` - 1) one after another.

        Raises what `work` raises, once all members have ended. Not to be called within `work`: it would wait for ever.
        """
        left = iter(parts)

        def take(member: int) -> None:
            for part in left:
                work(member, part)

        members = min(self.count, len(parts))
        others = [] if self._others is None else [self._others.submit(take, member) for member in range(1, members)]
        try:
            take(0)
        finally:
            wait(others)
        for other in others:
            other.result()


ALONE = Team()
