"""How many threads there may be, and what the libraries must be told of it before they are loaded."""

from __future__ import annotations

import os
import sys


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def available(threads: int) -> int:
    """`threads`, but no more than processors that this process may use: waiting for one another costs a hundredfold."""
    if threads > processors():
        text = f"warning: {threads} threads asked for, {processors()} processors are there: using those"
        print(text, file=sys.stderr)
    return min(threads, processors())


def set_up_numerics(threads: int = 1) -> None:
    """Tell the libraries how many threads to use, before they are loaded.

    OpenBLAS has nothing to do here, but would start a thread per core; threads of OpenMP that wait busily lose
    a thousandfold where others use the machine; OMP_NUM_THREADS=1 would silently keep the FFTs from using more.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    os.environ["OMP_NUM_THREADS"] = str(threads)
