"""Parts of the rows of a large grid, which threads share.

The size of a part is fixed, and what the parts return is joined in their order. So no bit of a result depends on the
number of threads. With kernels in NumPy no temporary array is larger than a part, which also saves memory.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

PART_CELLS = 2**16
"""Cells of a part, about. With half of it calls take 2 % of an increment of mode I.3 on 1024 x 1024 points."""

Found = TypeVar("Found")

Share = Callable[[Callable[[int, int], None], Sequence[int]], None]
"""Calls its first argument for a thread and each of some numbers, as `fretsolve.elastic.thread_team.ThreadTeam`."""


def parts_of(shape: tuple[int, int]) -> list[tuple[int, int]]:
    """Cut the rows of a grid into parts of about equal size near PART_CELLS: one, or an even number for two threads."""
    rows, columns = shape
    parts = rows * columns / PART_CELLS
    size = -(-rows // (1 if parts < 1.5 else 2 * round(0.5 * parts)))
    return [(first, min(first + size, rows)) for first in range(0, rows, size)]


def in_order(share: Share, parts: Sequence[tuple[int, int]], compute: Callable[[int, int], Found]) -> list[Found]:
    """Return what ``compute(first, stop)`` returns for each of the `parts`, which are shared, in their order."""
    results: list[Any] = [None] * len(parts)

    def keep(member: int, number: int) -> None:
        results[number] = compute(*parts[number])

    share(keep, range(len(parts)))
    return results
