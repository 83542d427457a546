"""The environment: processors and threads, and optional packages. Loads neither NumPy nor any optional package."""

from __future__ import annotations

import gc
import math
import os
import platform
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec

from fretsolve.errors import CaseError

LEAST_ADDRESS_SPACE = 600 * 2**20
"""Bytes in which every command works, with a small case. With less OpenBLAS may try without end while it is loaded."""


def set_up_numerics() -> None:
    """Keep libraries from what takes time and is not needed here.

    OpenBLAS would start a thread per core, pydantic look for plugins in every installed package, and h5py start a
    program that tells the name of the processor. Must run before NumPy is imported.

    Raises CaseError if the process may not use the memory that the libraries take.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")
    vars(platform.uname())["processor"] = platform.machine()
    if address_space() < LEAST_ADDRESS_SPACE:
        limit, needed = round(address_space() / 1024), LEAST_ADDRESS_SPACE // 1024
        raise CaseError(f"not enough memory: the limit (ulimit -v or -d) is {limit} kB; {needed} kB are needed")


@contextmanager
def quick_imports() -> Iterator[None]:
    """Import modules within the block without collecting garbage: they leave none, and looking for it takes 40 ms."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def address_space() -> float:
    """Return how many bytes this process may allocate by its limits, infinity if there is none."""
    limits = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA))
    return min((float(limit) for limit in limits if limit != resource.RLIM_INFINITY), default=math.inf)


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def available(threads: int) -> int:
    """Return `threads`, or the number of processors with a warning if there are fewer: more threads would wait."""
    if threads > processors():
        text = f"warning: {threads} threads asked for, {processors()} processors are there: using those"
        print(text, file=sys.stderr)
    return min(threads, processors())


@cache
def compiler_installed() -> bool:
    """Return whether numba is installed."""
    return find_spec("numba") is not None


def compiler_asked() -> bool | None:
    """Return whether to use numba by the environment's `FRETSOLVE_NUMBA`, None if it is not set or empty.

    Raises CaseError if it is neither 0 nor 1.
    """
    asked = os.environ.get("FRETSOLVE_NUMBA", "")
    if asked not in ("", "0", "1"):
        raise CaseError(f"the environment's FRETSOLVE_NUMBA is {asked!r}; 0 never uses numba, 1 always does")
    return None if not asked else asked == "1"


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra; fretsolve is installed from its sources."""
    return f"pip install '.[{extra}]' in a clone of fretsolve"
