"""Compare the cost of an increment on small grids with that of an older clone.

    python benchmarks/small_grids.py --older ../older                 # a table, some minutes on one core
    python benchmarks/small_grids.py --older ../older --points 32 64
    python benchmarks/small_grids.py --into docs/performance.md       # without an older clone

Mode I.3 on 0.9 mm x 0.9 mm, tolerance 1e-6, one thread: the mean over the 60 increments of the path, with and without
numba. The clones run in processes of their own and take turns, so that other load on the machine disturbs their ratio
little; of each the least time of some runs counts, in milliseconds of processor time.
"""

from __future__ import annotations

import time
from collections import deque
from functools import partial
from pathlib import Path

from marked import parser_of, report
from older_clone import add_options, answer, headings, rows

POINTS = (16, 32, 48, 64, 96, 128)


def measure() -> None:
    """Answer each number of points by the milliseconds and the applications of an increment there."""
    from bench_path import JOBS, compile_kernels, setup_of

    import fretsolve

    compile_kernels()
    known = set()

    def measured(points: str) -> tuple[float, float]:
        setup = setup_of(JOBS[3], int(points))
        if points not in known:  # influence coefficients aside, plans are made once in a process
            deque(fretsolve.run(setup), maxlen=0)
            known.add(points)
        began = time.process_time()
        history = [state.summary for state in fretsolve.run(setup)]
        seconds = (time.process_time() - began) / len(history)
        return 1e3 * seconds, sum(summary.operator_applications for summary in history) / len(history)

    answer(measured)


def print_table(older: Path | None, grids: tuple[int, ...]) -> None:
    """Print milliseconds and applications of an increment, and their ratio to those of the older clone."""
    head = ["points", "numba", *headings(older)]
    print("|", " | ".join(head), "|")
    print("| --- " * len(head) + "|")
    for with_numba in ("yes", "no"):
        costs = rows(__file__, older, with_numba == "yes", [str(points) for points in grids])
        for points, row in zip(grids, costs, strict=True):
            print("|", " | ".join([str(points), with_numba, *row]), "|", flush=True)


def main() -> None:
    """Read the arguments and print what they ask for."""
    parser = parser_of(__doc__)
    add_options(parser)
    parser.add_argument("--points", type=int, nargs="+", default=POINTS, help="cells per side")
    asked = parser.parse_args()
    if asked.measure:
        measure()
    else:
        report({"small grids": partial(print_table, asked.older, tuple(asked.points))}, asked.into)


if __name__ == "__main__":
    main()
