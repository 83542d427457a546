"""Measure what line contacts cost without compiled kernels, also beside an older clone.

    python benchmarks/line_cost.py --older ../older                       # a table, two minutes on one core
    python benchmarks/line_cost.py --into docs/performance.md             # without an older clone

A cylinder under P, then a cycle of Q and bulk stress in phase, between like and unlike bodies: the mean over the
increments, in milliseconds of processor time without the set-up, the least of some runs. Two clones take turns.
"""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

from marked import parser_of, report
from older_clone import add_options, answer, headings, rows

STEEL, SOFTER = {"young_modulus": 200e3, "poisson_ratio": 0.3}, {"young_modulus": 70e3, "poisson_ratio": 0.45}
BODIES = {"like": ([STEEL, STEEL], 0.28), "unlike": ([STEEL, SOFTER], 0.38)}
"""The bodies, and the length of the grid (mm), which the contact fills to four fifths."""

POINTS, INCREMENTS = (32, 64, 128, 256, 512, 4096), 40


def measure() -> None:
    """Answer bodies and a number of cells by the milliseconds and the applications of an increment."""
    from fretsolve import run
    from fretsolve.case.line_case import LineCase
    from fretsolve.setup.problem_setup import set_up

    def measured(request: str) -> tuple[float, float]:
        kind, points = request.split()
        bodies, size = BODIES[kind]
        peak = {"Qx": 18.0, "bulk_2": {"xx": 140.0}, "increments": INCREMENTS // 2}
        valley = {"Qx": -18.0, "bulk_2": {"xx": -140.0}, "increments": INCREMENTS // 2 - 4}
        case = {
            "plane": "strain",
            "bodies": bodies,
            "surface": {"cylinder": {"radius": 10.0}},
            "grid": {"points": int(points), "size": size},
            "friction": 0.3,
            "load_path": [{"P": 100.0, "increments": 4}, peak, valley],
        }
        setup = set_up(LineCase.model_validate(case))
        began = time.process_time()
        history = [state.summary for state in run(setup)]
        seconds = (time.process_time() - began) / len(history)
        return 1e3 * seconds, sum(summary.operator_applications for summary in history) / len(history)

    answer(measured)


def print_table(older: Path | None) -> None:
    """Print milliseconds and applications of an increment, and their ratio to those of the older clone."""
    head = ["cells", "bodies", *headings(older)]
    print("|", " | ".join(head), "|")
    print("| --- " * len(head) + "|")
    asked = [(kind, points) for points in POINTS for kind in BODIES]
    costs = rows(__file__, older, False, [f"{kind} {points}" for kind, points in asked])
    for (kind, points), row in zip(asked, costs, strict=True):
        print("|", " | ".join([str(points), kind, *row]), "|", flush=True)


def main() -> None:
    """Read the arguments and print what they ask for."""
    parser = parser_of(__doc__)
    add_options(parser)
    asked = parser.parse_args()
    if asked.measure:
        measure()
    else:
        report({"line contacts": partial(print_table, asked.older)}, asked.into)


if __name__ == "__main__":
    main()
