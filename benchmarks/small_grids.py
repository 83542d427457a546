"""Compare the cost of an increment on small grids with that of an older clone.

    python benchmarks/small_grids.py --older ../older                 # a table, some minutes on one core
    python benchmarks/small_grids.py --older ../older --points 32 64
    python benchmarks/small_grids.py --into docs/performance.md       # without an older clone

Mode I.3 on 0.9 mm x 0.9 mm, tolerance 1e-6, one thread: the mean over the 60 increments of the path, with and without
numba. The clones run in processes of their own and take turns, so that other load on the machine disturbs their ratio
little; of each the least time of some runs counts, in milliseconds of processor time.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections import deque
from functools import partial
from pathlib import Path

from marked import parser_of, report

ROOT = Path(__file__).resolve().parent.parent
POINTS = (16, 32, 48, 64, 96, 128)
REPETITIONS = 5


class Clone:
    """A process that measures with the package of one clone; compiled: with numba."""

    def __init__(self, root: Path, compiled: bool):
        own = {"PYTHONPATH": str(root), "FRETSOLVE_NUMBA": str(int(compiled)), "OMP_NUM_THREADS": "1"}
        line = [sys.executable, __file__, "--measure"]
        self._process = subprocess.Popen(
            line, env=os.environ | own, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def measure(self, points: int) -> tuple[float, float]:
        """Return the milliseconds and the applications of an increment in one run."""
        assert self._process.stdin is not None and self._process.stdout is not None
        print(points, file=self._process.stdin, flush=True)
        milliseconds, applications = map(float, self._process.stdout.readline().split())
        return milliseconds, applications

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def measure() -> None:
    """Answer each number of points on the standard input by the cost of an increment there."""
    from bench_path import JOBS, compile_kernels, setup_of

    import fretsolve

    compile_kernels()
    known = set()
    for line in sys.stdin:
        setup = setup_of(JOBS[3], int(line))
        if line not in known:  # influence coefficients aside, plans are made once in a process
            deque(fretsolve.run(setup), maxlen=0)
            known.add(line)
        began = time.process_time()
        history = [state.summary for state in fretsolve.run(setup)]
        seconds = (time.process_time() - began) / len(history)
        applications = sum(summary.operator_applications for summary in history) / len(history)
        print(1e3 * seconds, applications, flush=True)


def print_table(older: Path | None, grids: tuple[int, ...]) -> None:
    """Print milliseconds and applications of an increment, and their ratio to those of the older clone."""
    roots = [ROOT] if older is None else [older.resolve(), ROOT]
    head = ["ms", "applications"]
    if older is not None:
        head = ["older, ms", "ms", "ratio", "older, applications", "applications"]
    print("| points | numba |", " | ".join(head), "|")
    print("| --- " * (2 + len(head)) + "|")
    for compiled in (True, False):
        clones = [Clone(root, compiled) for root in roots]
        for points in grids:
            rounds = [[clone.measure(points) for clone in clones] for _ in range(REPETITIONS)]
            costs = [min(runs) for runs in zip(*rounds, strict=True)]
            times, applications = ([f"{value:.1f}" for value in values] for values in zip(*costs, strict=True))
            ratio = [] if older is None else [f"{costs[1][0] / costs[0][0]:.2f}"]
            with_numba = "yes" if compiled else "no"
            print(f"| {points} | {with_numba} |", " | ".join([*times, *ratio, *applications]), "|", flush=True)
        for clone in clones:
            clone.close()


def main() -> None:
    """Read the arguments and print what they ask for."""
    parser = parser_of(__doc__)
    parser.add_argument("--older", type=Path, help="the root of an older clone")
    parser.add_argument("--points", type=int, nargs="+", default=POINTS, help="cells per side")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.measure:
        measure()
    else:
        report({"small grids": partial(print_table, asked.older, tuple(asked.points))}, asked.into)


if __name__ == "__main__":
    main()
