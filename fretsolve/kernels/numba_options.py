"""Options with which numba compiles the kernels, and the time that this takes."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numba
from numba.core import event

from fretsolve.kernels.numba_cache import KernelCache

if getattr(numba.config, "DISABLE_JIT", False):  # Python itself would run the loops over cells
    raise ImportError("NUMBA_DISABLE_JIT is set")


def _clock(name: str) -> Callable[[], float]:
    """Return a function that returns the wall-clock time (s) of one kind of the compiler's events in this process."""
    listener = event.TimingListener()  # type: ignore[no-untyped-call]
    event.register(name, listener)  # type: ignore[no-untyped-call]
    return lambda: float(listener.duration) if listener.done else 0.0


class _FirstCompilation(event.Listener):
    """Calls `tell` when a kernel is compiled, once."""

    tell: Callable[[], None] | None = None

    def on_start(self, event: Any) -> None:
        tell, self.tell = self.tell, None
        if tell is not None:
            tell()

    def on_end(self, event: Any) -> None:
        pass


_first_compilation = _FirstCompilation()
event.register("numba:compile", _first_compilation)  # type: ignore[no-untyped-call]


def when_compiling(tell: Callable[[], None]) -> None:
    """Call `tell` when the next kernel is compiled, which none is that is on disk."""
    _first_compilation.tell = tell


compile_seconds = _clock("numba:compile")
readying_seconds = _clock("numba:compiler_lock")


def kernel(function: Any) -> Any:
    """Compile `function` at its first call, and keep it on disk if there is a place for it.

    Sums may be reordered into vector instructions. NaN and inf keep their meaning.
    """
    return _compiled(function)


def exact(function: Any) -> Any:
    """Compile a `function` like a kernel, but round each product and each sum, as NumPy does.

    Then x and y can change places without a change of bits, since no product is taken up in a sum unrounded. Others may
    call it without having its code put into them (`inlined`), which takes the compiler less time.
    """
    return _compiled(function, fastmath=False)


def inlined(function: Any) -> Any:
    """Compile a `function` that kernels call, like a kernel, and put its code into each of them.

    Otherwise a process takes the code of the one that it loads first for all of them. They differ in the order of sums,
    so that a resumed run, which calls other kernels first, would give other bits.
    """
    return _compiled(function, forceinline=True)


def _compiled(function: Any, **options: Any) -> Any:
    options = {"fastmath": {"reassoc", "contract", "nsz", "arcp"}} | options
    # C calls none, and Python none whose name begins with an underscore; each way in takes the compiler time.
    options |= {"no_cfunc_wrapper": True, "no_cpython_wrapper": function.__name__.startswith("_")}
    compiled: Any = numba.njit(nogil=True, error_model="numpy", **options)(function)
    with suppress(RuntimeError):  # neither the package's folder nor the user's cache can be written
        try:
            compiled._cache = KernelCache(function)
        except (AttributeError, TypeError):  # another numba, whose cache has other parts: without checksums
            compiled.enable_caching()
    return compiled


@inlined
def larger(value: Any, other: Any) -> Any:
    """Return the larger of two numbers of one precision, or the one that is NaN."""
    return value if value > other or value != value else other


@inlined
def largest_of(values: Any) -> float:
    """Return the largest number of a row, or NaN if it holds one.

    Kernels first gather the largest of each column in a row: vector instructions do that, and keep NaN.
    """
    largest = values[0]
    for j in range(1, len(values)):
        largest = larger(values[j], largest)
    return float(largest)
