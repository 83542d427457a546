"""What it saves to solve increments that are mirror images of themselves on one half of the grid.

    python benchmarks/mirror_images.py                      # a table, some minutes on one core
    python benchmarks/mirror_images.py --points 64 256
    python benchmarks/mirror_images.py --into docs/scenes.md

Modes I.3 (a cycle of Q between unlike bodies) and II (pressing), tolerance 1e-6, one thread, with numba: means over the
increments of a run. Runs on one half and on the whole grid take turns; of each the least time of some counts.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from functools import partial

from bench_path import CASES, compile_kernels
from marked import parser_of, report

import fretsolve
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation import simulation

MODES = {"I.3": "mode1_dissimilar", "II": "mode2_dissimilar"}
POINTS = (32, 64, 128, 256, 512)
REPETITIONS = 3


def cost(setup: ProblemSetup) -> tuple[float, float]:
    """Return the milliseconds of processor time and the applications of an increment, means over a run."""
    began = time.process_time()
    history = [state.summary for state in fretsolve.run(setup)]
    seconds = time.process_time() - began
    return 1e3 * seconds / len(history), sum(row.operator_applications for row in history) / len(history)


def on_the_whole_grid(run: Callable[[], tuple[float, float]]) -> tuple[float, float]:
    """Return what `run` does where no case counts as a mirror image."""
    decide, simulation.may_be_mirrored = simulation.may_be_mirrored, lambda *_: False
    try:
        return run()
    finally:
        simulation.may_be_mirrored = decide


def print_table(grids: tuple[int, ...]) -> None:
    """Print the cost of an increment on one half and on the whole grid."""
    compile_kernels()
    print("| mode | points | whole grid, ms | one half, ms | ratio | applications, whole grid | one half |")
    print("| --- " * 7 + "|")
    for mode, case in MODES.items():
        for points in grids:
            setup = set_up(fretsolve.load_case(CASES / f"{case}.yaml", ["expect=[]", f"grid.points={points}"]))
            halves, wholes = [], []
            for run in (partial(cost, setup), partial(on_the_whole_grid, partial(cost, setup))):
                deque([run()], maxlen=0)  # plans are made once in a process
            for _ in range(REPETITIONS if points < 512 else 1):
                wholes.append(on_the_whole_grid(partial(cost, setup)))
                halves.append(cost(setup))
            (whole, all_of_it), (half, half_of_it) = min(wholes), min(halves)
            print(
                f"| {mode} | {points} | {whole:.3g} | {half:.3g} | {half / whole:.2f} | {all_of_it:.0f} |"
                f" {half_of_it:.0f} |",
                flush=True,
            )


def main() -> None:
    """Read the arguments and print what they ask for."""
    parser = parser_of(__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=POINTS, help="cells per side")
    asked = parser.parse_args()
    report({"mirror images": partial(print_table, tuple(asked.points))}, asked.into)


if __name__ == "__main__":
    main()
