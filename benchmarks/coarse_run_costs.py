"""What the coarse runs of error bars take, over what the run itself takes.

    python benchmarks/coarse_run_costs.py                          # two minutes on one core
    python benchmarks/coarse_run_costs.py --into docs/error_bars.md

Modes I.3, II and III up to the first peak of their loads, with the same increments in each stage. Printed are the least
and the largest of the three, of operator applications and of seconds, the latter each the least of some runs.
"""

from __future__ import annotations

from marked import parser_of, report
from trade import CASES, MODES

import fretsolve
from fretsolve.setup.problem_setup import ProblemSetup, set_up

COUPLED = ("I.3", "II", "III")
POINTS, INCREMENTS = (32, 48, 64), (1, 2, 3, 5, 8, 12, 20)
REPETITIONS = 3


def setup_of(mode: str, points: int, increments: int) -> ProblemSetup:
    """Return a mode with so many points per side and increments per stage."""
    name, path = MODES[mode]
    options = ["expect=[]", path, f"grid.points={points}", f"load_path.*.increments={increments}"]
    return set_up(fretsolve.load_case(CASES / f"{name}.yaml", options))


def shares(setup: ProblemSetup) -> tuple[float, float]:
    """Return applications and seconds of the coarse runs over those of the run."""
    own, theirs = [], []
    for _ in range(REPETITIONS + 1):  # the first one also compiles kernels and plans transforms
        states = list(fretsolve.run_with_error_bars(setup))
        rows = [(state.summary, state.errors) for state in states if state.errors is not None]
        own.append(sum(summary.wall_time for summary, _ in rows))
        theirs.append(sum(errors.coarse_runs_wall_time for _, errors in rows))
    applications = sum(errors.coarse_runs_applications for _, errors in rows)
    return applications / sum(summary.operator_applications for summary, _ in rows), min(theirs[1:]) / min(own[1:])


def print_costs() -> None:
    """Print a row for each number of increments."""
    headings = [f"{what}, {points} points" for points in POINTS for what in ("applications", "time")]
    print("| increments per stage | " + " | ".join(headings) + " |")
    print("| --- " * (1 + len(headings)) + "|")
    for increments in INCREMENTS:
        cells = []
        for points in POINTS:
            of_modes = [shares(setup_of(mode, points, increments)) for mode in COUPLED]
            cells += [f"{min(kind):.2g} to {max(kind):.2g}" for kind in zip(*of_modes, strict=True)]
        print(f"| {increments} | " + " | ".join(cells) + " |", flush=True)


def main() -> None:
    """Read the arguments and print the table, or put it into a page."""
    options = parser_of(__doc__).parse_args()
    report({"coarse runs": print_costs}, options.into)


if __name__ == "__main__":
    main()
