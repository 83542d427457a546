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
