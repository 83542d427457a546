"""Threads that share the independent parts of a task, with the kernels that they call and the memory for spectra."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from threading import Thread
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.fftw import pyfftw
from fretsolve.kernels import NUMPY, Kernels
from fretsolve.kernels.on_grid import in_order, parts_of

ALIGNMENT = 64
"""Bytes of a cache line and of the longest vector instructions."""

Item = TypeVar("Item")
Found = TypeVar("Found")


class _Ended:
    """The calls of a task that have ended."""

    def __init__(self) -> None:
        self._errors: list[BaseException | None] = []
        self._news: SimpleQueue[None] = SimpleQueue()

    def add(self, error: BaseException | None) -> None:
        """Add a call with what it has raised."""
        self._errors.append(error)
        self._news.put(None)

    def errors(self, count: int) -> list[BaseException]:
        """Wait until `count` calls have ended; return what they have raised.

        An interrupt is raised only then: until then the calls write to the caller's arrays. Calls are counted by the
        list, because an interrupt may take a piece of news with it.
        """
        interrupt: BaseException | None = None
        while len(self._errors) < count:
            try:
                self._news.get()
            except BaseException as raised:
                interrupt = raised
        if interrupt is not None:
            raise interrupt
        return [error for error in self._errors if error is not None]


Calls: TypeAlias = "SimpleQueue[tuple[Callable[[int], None], int, _Ended] | None]"
"""Hands calls with the number of a member to a thread; None ends the thread."""


class ThreadTeam:
    """`count` threads, the caller's among them. Results do not depend on which thread does which part.

    A team works on one convolution at a time, so the same memory for row spectra serves all of them. kernels: the form
    that all solvers of the team use.
    """

    def __init__(self, count: int = 1, kernels: Kernels = NUMPY):
        self.count, self.kernels = count, kernels
        self._calls: Calls | None = _threads(self, count - 1) if count > 1 else None
        self._memory: NDArray[np.uint8] = np.empty(0, np.uint8)

    def members(self, parts: Sequence[Item]) -> range:
        """Return the numbers of the threads that `parts` keep busy."""
        return range(min(self.count, len(parts)))

    def share(self, work: Callable[[int, Item], None], parts: Sequence[Item]) -> None:
        """Call ``work(member, part)`` for all parts; each member works on one part at a time.

        Raises what `work` raises, or an interrupt, once all members have ended. `work` must not call `share`: it would
        wait for ever.
        """
        if self._calls is None:
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

        # Queues of its own hand a call out in 12 to 20 us of processor time. An executor took twice to four times that.
        ended, others, handed_out = _Ended(), self.members(parts)[1:], 0
        try:
            for member in others:
                self._calls.put((take, member, ended))
                handed_out += 1
            take(0)
        finally:
            errors = ended.errors(handed_out)
        try:
            if errors:
                raise errors[0]
        finally:
            del errors, ended  # else the error would hold this call, and with it the fields of `work`

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


def _threads(team: ThreadTeam, count: int) -> Calls:
    """Start `count` threads, which end with the team, and return the queue from which they take calls."""
    calls: Calls = SimpleQueue()
    for _ in range(count):
        Thread(target=_work, args=(calls,), name="transforms", daemon=True).start()
        weakref.finalize(team, calls.put, None)
    return calls


def _work(calls: Calls) -> None:
    """Do one call after another."""
    while (call := calls.get()) is not None:
        work, member, ended = call
        try:
            work(member)
        except BaseException as error:  # it is raised in the thread that handed the call out
            ended.add(error)
        else:
            ended.add(None)
        del call, work, ended  # a waiting thread keeps no field alive
