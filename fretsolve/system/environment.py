"""The environment: processors and threads, and optional packages. Loads neither NumPy nor any optional package."""

from __future__ import annotations

import os
import sys
from importlib.util import find_spec


def set_up_numerics() -> None:
    """Keep OpenBLAS, which is not used here, from starting a thread per core. Must run before NumPy is imported."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def available(threads: int) -> int:
    """Return `threads`, or the number of processors with a warning if there are fewer: more threads would wait."""
    if threads > processors():
        text = f"warning: {threads} threads asked for, {processors()} processors are there: using those"
        print(text, file=sys.stderr)
    return min(threads, processors())


def compiler_wanted() -> bool:
    """Return whether numba is installed and not switched off by `FRETSOLVE_NUMBA=0` in the environment."""
    return os.environ.get("FRETSOLVE_NUMBA") != "0" and find_spec("numba") is not None


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra; fretsolve is installed from its sources."""
    return f"pip install '.[{extra}]' in a clone of fretsolve"
