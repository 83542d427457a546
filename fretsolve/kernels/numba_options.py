"""How numba compiles the pointwise kernels."""

from __future__ import annotations

from typing import Any

import numba
from numba.core import event


def _clock(name: str) -> Any:
    """What adds up the time of events of the compiler; as the compiler itself, it is the process's."""
    listener = event.TimingListener()  # type: ignore[no-untyped-call]
    event.register(name, listener)  # type: ignore[no-untyped-call]
    return listener


_COMPILING = _clock("numba:compile")
_READYING = _clock("numba:compiler_lock")


def compile_seconds() -> float:
    """Wall-clock time that the compiler has taken in this process; 0 where all was on disk."""
    return float(_COMPILING.duration) if _COMPILING.done else 0.0


def readying_seconds() -> float:
    """Wall-clock time that compiling kernels or reading them from disk has taken in this process."""
    return float(_READYING.duration) if _READYING.done else 0.0


def kernel(function: Any) -> Any:
    """Compiled at the first call, and kept on disk where there is a place for it.

    Sums may be reordered into vector instructions; NaN and inf are minded.
    """
    fast = {"reassoc", "contract", "nsz", "arcp"}
    options: dict[str, Any] = {"nogil": True, "fastmath": fast, "error_model": "numpy"}
    try:
        return numba.njit(cache=True, **options)(function)
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return numba.njit(**options)(function)


@kernel
def larger(value: Any, other: Any) -> Any:
    """The larger one of two numbers of one precision, or the one that is NaN."""
    return value if value > other or value != value else other


@kernel
def largest_of(values: Any) -> float:
    """The largest number of a row, or NaN where there is one.

    Kernels gather the largest of each column in a row first: vector instructions do that, and lose no NaN.
    """
    largest = values[0]
    for j in range(1, len(values)):
        largest = larger(values[j], largest)
    return float(largest)
