"""Set thread limits. Must run before NumPy is imported."""

from __future__ import annotations

import os
import sys


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def available(threads: int) -> int:
    """Return `threads`, or the number of processors with a warning if there are fewer: more threads would wait."""
    if threads > processors():
        text = f"warning: {threads} threads asked for, {processors()} processors are there: using those"
        print(text, file=sys.stderr)
    return min(threads, processors())


def set_up_numerics() -> None:
    """Keep OpenBLAS, which is not used here, from starting a thread per core."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
