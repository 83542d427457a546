"""Threads that share the independent parts of a task, with the kernels that they call and the memory for spectra.

The size of a part of the rows of a grid is fixed, and what the parts return is joined in their order. So no bit of a
result depends on the number of threads. With kernels in NumPy no temporary array is larger than a part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.fftw import pyfftw
from fretsolve.elastic.kernels import NUMPY, Kernels

PART_CELLS = 2**16
"""Cells of a part, about. With half as many cells, calls take 2 % of an increment of mode I.3 on 1024 x 1024 points."""

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


ALIGNMENT = 64
"""Bytes of a cache line and of the longest vector instructions."""

Item = TypeVar("Item")


class ThreadTeam:
    """`count` threads, the caller's among them. Results do not depend on which thread does which part.

    A team works on one convolution at a time, so the same memory for row spectra serves all of them. kernels: the form
    that all solvers of the team use.
    """

    def __init__(self, count: int = 1, kernels: Kernels = NUMPY):
        self.count, self.kernels = count, kernels
        self._others = ThreadPoolExecutor(count - 1, "transforms") if count > 1 else None
        self._memory: NDArray[np.uint8] = np.empty(0, np.uint8)

    def members(self, parts: Sequence[Item]) -> range:
        """Return the numbers of the threads that `parts` keep busy."""
        return range(min(self.count, len(parts)))

    def share(self, work: Callable[[int, Item], None], parts: Sequence[Item]) -> None:
        """Call ``work(member, part)`` for all parts; each member works on one part at a time.

        Raises what `work` raises, or an interrupt, once all members have ended. `work` must not call `share`: it would
        wait for ever.
        """
        if self._others is None:
            for part in parts:
                work(0, part)
            return
        # Neighbouring parts share cache lines: two threads that work on them at once take a fifth longer for the
        # transforms of 1024 x 1024 points.
        apart = -(-len(parts) // self.count)
        left = iter([part for first in range(apart) for part in parts[first::apart]])

        def take(member: int) -> None:
            for part in left:
                work(member, part)

        calls: list[Future[None]] = []
        try:
            for member in self.members(parts)[1:]:
                calls.append(self._others.submit(take, member))
            take(0)
        finally:
            _wait_for(calls)
        try:
            while calls:  # an error must hold no call, and with it the fields of `work`
                calls.pop(0).result()
        finally:
            calls.clear()

    def of_rows(self, shape: tuple[int, int], compute: Callable[[slice], Found]) -> list[Found]:
        """Return what `compute` returns for parts of the rows of a grid, in their order.

        The parts are the same for each number of threads.
        """
        return in_order(self.share, parts_of(shape), lambda first, stop: compute(slice(first, stop)))

    def arrays(self, count: int, shape: tuple[int, int], dtype: np.dtype[Any]) -> list[NDArray[Any]]:
        """Return `count` arrays that are valid until the next call. They are not cleared."""
        size = shape[0] * shape[1] * dtype.itemsize
        stride = size + -size % ALIGNMENT
        if self._memory.size < count * stride:
            self._memory = pyfftw.empty_aligned(count * stride, np.uint8, n=ALIGNMENT)
        parts = (self._memory[index * stride : index * stride + size] for index in range(count))
        return [part.view(dtype).reshape(shape) for part in parts]

    def release(self) -> None:
        """Free the memory until it is needed again."""
        self._memory = np.empty(0, np.uint8)


def _wait_for(calls: Sequence[Future[None]]) -> None:
    """Wait until all calls have ended. An interrupt is raised only then: the calls write to the caller's arrays."""
    interrupt: BaseException | None = None
    while not all(call.done() for call in calls):
        try:
            wait(calls)
        except BaseException as raised:
            interrupt = raised
    if interrupt is not None:
        raise interrupt
