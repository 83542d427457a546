"""Threads that share the independent parts of a task."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

Part = TypeVar("Part")


class ThreadTeam:
    """`count` threads, the caller's among them. Results do not depend on which thread does which part."""

    def __init__(self, count: int = 1):
        self.count = count
        self._others = ThreadPoolExecutor(count - 1, "transforms") if count > 1 else None

    def members(self, parts: Sequence[Part]) -> range:
        """Return the numbers of the threads that `parts` keep busy."""
        return range(min(self.count, len(parts)))

    def share(self, work: Callable[[int, Part], None], parts: Sequence[Part]) -> None:
        """Call ``work(member, part)`` for all parts; each member works on one part at a time.

        Raises what `work` raises, once all members have ended. `work` must not call `share`: it would wait for ever.
        """
        left = iter(parts)

        def take(member: int) -> None:
            for part in left:
                work(member, part)

        others = [] if self._others is None else [self._others.submit(take, one) for one in self.members(parts)[1:]]
        try:
            take(0)
        finally:
            wait(others)
        for other in others:
            other.result()


ONE_THREAD = ThreadTeam()
