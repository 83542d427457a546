"""How many threads there may be, and what the libraries must be told of it before they are loaded."""

from __future__ import annotations

import os
import sys


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def available(threads: int) -> int:
    """`threads`, but no more than processors that this process may use, which would wait for one another."""
    if threads > processors():
        text = f"warning: {threads} threads asked for, {processors()} processors are there: using those"
        print(text, file=sys.stderr)
    return min(threads, processors())


def set_up_numerics() -> None:
    """Keep OpenBLAS, which has nothing to do here, from starting a thread per core; before it is loaded."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
