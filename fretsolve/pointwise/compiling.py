"""How numba compiles the pointwise kernels."""

from __future__ import annotations

from typing import Any

import numba
from numba.core import event

_CLOCK: Any = event.TimingListener()  # type: ignore[no-untyped-call]  # as the compiler itself, this is the process's
event.register("numba:compile", _CLOCK)  # type: ignore[no-untyped-call]


def compile_seconds() -> float:
    """Wall-clock time that the compiler has taken in this process; 0 where all was on disk."""
    return float(_CLOCK.duration) if _CLOCK.done else 0.0


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
