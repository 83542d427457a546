"""Seconds of an increment of each mode, by points, with numba and with NumPy.

    python benchmarks/bench_path.py                        # small grids, two minutes on one core
    python benchmarks/bench_path.py --points 64 128 256
    python benchmarks/bench_path.py --large 256 512        # single increments, with numba where it is installed

Processor time of one thread, which other programs disturb less than the clock, certified to a tolerance of 1e-6;
operator applications in brackets. Small grids have the mean over the increments of the shipped case, the least of some
runs, influence coefficients included. On large ones a single increment is solved again and again from the same start,
and the median counts; of mode I.3 it is the mean over the path. FFTW's plans come from its wisdom, which a machine
measures once for each size of grid. Spheres are on an area of 0.9 mm x 0.9 mm.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path

import numpy as np

import fretsolve
from fretsolve.contact.increment.increment import Solved
from fretsolve.contact.increment.states import InitialState
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import increment_solver

os.environ.setdefault("FRETSOLVE_NUMBA", "1")  # also for runs too short to pay for loading numba

CASES = Path(__file__).resolve().parent.parent / "cases"
SPHERE = ("grid.size=0.9",)

REPETITIONS = 5
"""Of an increment on a large grid."""

RUNS = 3
"""Of a path on a small grid."""

SMALL, LARGE = (32, 64, 128), (256, 512, 1024, 2048)

LEAST_IN_PARTS = 256
"""Points per side of a grid that is large enough to be cut into parts (`fretsolve.elastic.thread_team`)."""

LARGEST_OF_PATHS = 1024
"""Points per side up to which a whole path is measured; a larger one takes a quarter of an hour."""


@dataclass(frozen=True)
class Job:
    """A case, what is changed in it, and the increment that is asked for (the whole path where it is None)."""

    name: str
    case: str
    overrides: tuple[str, ...] = SPHERE
    increment: int | None = None


@dataclass(frozen=True)
class Cost:
    """Seconds and operator applications of an increment."""

    seconds: float
    applications: float


COUPLED = Job("mode I.3, mean of path", "mode1_dissimilar")
LARGE_JOBS = (Job("normal (Hertz)", "mode1_similar", SPHERE, 0), Job("mode I.2", "mode1_similar", SPHERE, 1), COUPLED)
SMALL_JOBS = (
    Job("I.2", "mode1_similar"),
    Job("I.3", "mode1_dissimilar"),
    Job("II", "mode2_dissimilar"),
    Job("III", "mode3_dissimilar"),
    Job("line", "line_fatigue", ()),
)


def setup_of(job: Job, points: int) -> ProblemSetup:
    """Return the case of `job` on `points` by `points` cells."""
    overrides = ["expect=[]", f"grid.points={points}", *job.overrides]
    return set_up(fretsolve.load_case(CASES / f"{job.case}.yaml", overrides))


def cost(job: Job, points: int) -> Cost:
    """Return what `job` takes."""
    return cost_of_path(job, points) if job.increment is None else cost_of_increment(job, points, job.increment)


def cost_of_path(job: Job, points: int, runs: int = 1) -> Cost:
    """Return means over the increments of a run, the least of some; one before makes FFTW's plans."""
    deque(islice(fretsolve.run(setup_of(job, points)), 11), maxlen=0)
    seconds = []
    for _ in range(runs):
        setup, began = setup_of(job, points), time.process_time()
        applications = [state.summary.operator_applications for state in fretsolve.run(setup)]
        seconds.append((time.process_time() - began) / len(applications))
    return Cost(min(seconds), float(np.mean(applications)))


def cost_of_increment(job: Job, points: int, index: int) -> Cost:
    """Return the cost of one increment; those before it are solved once."""
    setup = setup_of(job, points)
    solver = increment_solver(setup, setup.separation(), threads=1)
    history = [state.summary for state in islice(fretsolve.run(setup), index + 1)]  # FFTW's plans are known then
    nothing = np.zeros((2, *setup.grid.shape))
    start = InitialState(nothing[0], nothing, nothing, np.zeros(6), setup.friction_on_grid().limit())
    for step in range(index):
        increment = setup.load_path.increment(step, history)
        start = end_of(solver.solve(increment, start), increment)
    increment = setup.load_path.increment(index, history)
    seconds = []
    for _ in range(1 + REPETITIONS):
        began = time.process_time()
        solved = solver.solve(increment, start)
        seconds.append(time.process_time() - began)
    return Cost(float(np.median(seconds[1:])), solved.operator_applications)


def end_of(solved: Solved, increment: Increment) -> InitialState:
    """Return what the next increment starts from."""
    return InitialState(
        solved.pressure, solved.shear, solved.displacement, solved.rigid, solved.friction, increment.normal
    )


@lru_cache
def compile_kernels() -> None:
    """Load the compiled kernels, of small grids and of large ones, so that no increment is charged with it."""
    for job in (*LARGE_JOBS, *SMALL_JOBS):
        for points in (32, LEAST_IN_PARTS):
            deque(islice(fretsolve.run(setup_of(job, points)), 3), maxlen=0)


def bytes_per_cell(points: int) -> float:
    """Return the peak memory of the first three increments of mode I.3, in a process of its own.

    It is per cell, beyond what the interpreter and the libraries take.
    """
    output = subprocess.run([sys.executable, __file__, "--memory", str(points)], capture_output=True, check=True)
    return float(output.stdout)


def peak_bytes() -> int:
    """Return the most memory that this process ever had."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def print_bytes_per_cell(points: int) -> None:
    """Print what `bytes_per_cell` asks its process for."""
    compile_kernels()
    before = peak_bytes()
    deque(islice(fretsolve.run(setup_of(COUPLED, points)), 3), maxlen=0)
    print((peak_bytes() - before) / points**2)


def print_small(grids: Sequence[int] = SMALL) -> None:
    """Print milliseconds of an increment of each mode, with numba and with NumPy, each in a process of its own."""
    print("| mode | kernels |", " | ".join(f"{points}" for points in grids), "|")
    print("| --- " * (2 + len(grids)) + "|", flush=True)
    command = [sys.executable, __file__, "--rows", "--points", *map(str, grids)]
    for compiled in ("1", "0"):
        env = os.environ | {"FRETSOLVE_NUMBA": compiled}
        print(subprocess.run(command, env=env, capture_output=True, text=True, check=True).stdout, end="", flush=True)


def print_rows(grids: Sequence[int]) -> None:
    """Print the rows of `print_small` with the kernels that the environment names."""
    compile_kernels()
    kernels = "numba" if os.environ["FRETSOLVE_NUMBA"] == "1" else "NumPy"
    for job in SMALL_JOBS:
        costs = [cost_of_path(job, points, RUNS) for points in grids]
        cells = " | ".join(f"{1e3 * cost.seconds:.3g} ({cost.applications:.0f})" for cost in costs)
        print(f"| {job.name} | {kernels} | {cells} |", flush=True)


def print_large(grids: Sequence[int] = LARGE) -> None:
    """Print seconds of an increment of each job."""
    compile_kernels()
    print("| increment |", " | ".join(f"{points}" for points in grids), "|")
    print("| --- " * (1 + len(grids)) + "|")
    for job in LARGE_JOBS:
        cells = []
        for points in grids:
            if job.increment is None and points > LARGEST_OF_PATHS:
                cells.append("-")
                continue
            found = cost(job, points)
            cells.append(f"{found.seconds:.3g} ({found.applications:.0f})")
        print(f"| {job.name} |", " | ".join(cells), "|", flush=True)


def main() -> None:
    """Read the arguments and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, nargs="+", default=SMALL, help="points per side of the small grids")
    parser.add_argument("--large", type=int, nargs="+", metavar="POINTS", help="points per side of large grids instead")
    parser.add_argument("--rows", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--memory", type=int, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.memory:
        print_bytes_per_cell(asked.memory)
    elif asked.rows:
        print_rows(asked.points)
    elif asked.large:
        print_large(asked.large)
    else:
        print_small(asked.points)


if __name__ == "__main__":
    main()
