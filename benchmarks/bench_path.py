"""Increments of the modes in WU and seconds; ``python benchmarks/bench_path.py 256 512`` prints a table.

The base case on a square potential contact area of 0.9 mm, one thread, tolerance 1e-6, certificates met. `first` is an
increment with all that it makes ready for later ones (influence coefficients, window, arrays; FFTW's plans from its
wisdom, which a machine measures once for each size of grid); `again` is the same increment from the same start, the
median of five. Of a whole path the mean over its increments is told, windows and influence coefficients included.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections import deque
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path

import numpy as np
from work_unit import work_unit

import fretsolve
from fretsolve.increment.increment import Solved
from fretsolve.increment.working_state import InitialState
from fretsolve.model.load_path import Increment
from fretsolve.setup.problem_setup import ProblemSetup, set_up

CASES = Path(__file__).resolve().parent.parent / "cases"

REPETITIONS = 5

LEAST_IN_PARTS = 256
"""Points per side of a grid that is large enough to be cut into parts (`fretsolve.kernels.on_grid`)."""

LARGEST_OF_PATHS = 1024
"""Points per side up to which a whole path is measured; a larger one takes a quarter of an hour."""


@dataclass(frozen=True)
class Job:
    """A case, what is changed in it, and the increment that is asked for (the whole path where it is None)."""

    name: str
    case: str
    overrides: tuple[str, ...]
    increment: int | None


@dataclass(frozen=True)
class Cost:
    """Seconds of the first solve (NaN of a path) and the median of later ones; iterations and applications of one."""

    first: float
    again: float
    iterations: float
    applications: float


JOBS = (
    Job("normal (Hertz)", "mode1_similar", (), 0),
    Job("mode I.2", "mode1_similar", (), 1),
    Job("mode I.1", "mode1_similar_uncoupled", ("load_path.1.increments=1",), 1),
    Job("mode I.3, mean of path", "mode1_dissimilar", (), None),
)


def setup_of(job: Job, points: int) -> ProblemSetup:
    """Return the case of `job` on `points` by `points` cells."""
    overrides = ["expect=[]", f"grid.points={points}", "grid.size=0.9", *job.overrides]
    return set_up(fretsolve.load_case(CASES / f"{job.case}.yaml", overrides))


def cost(job: Job, points: int) -> Cost:
    """Return what `job` takes."""
    return cost_of_path(job, points) if job.increment is None else cost_of_increment(job, points, job.increment)


def cost_of_path(job: Job, points: int) -> Cost:
    """Return means over the increments of a run; the first stage is solved before, so that FFTW's plans are known."""
    deque(islice(fretsolve.run(setup_of(job, points)), 11), maxlen=0)
    began = time.process_time()
    history = [state.summary for state in fretsolve.run(setup_of(job, points))]
    seconds = (time.process_time() - began) / len(history)
    return Cost(
        np.nan,
        seconds,
        float(np.mean([summary.iterations_normal + summary.iterations_tangential for summary in history])),
        float(np.mean([summary.operator_applications for summary in history])),
    )


def cost_of_increment(job: Job, points: int, index: int) -> Cost:
    """Return the cost of one increment; those before it are solved once."""
    from fretsolve.simulation.simulation import increment_solver  # on demand, since older clones lack it

    setup = setup_of(job, points)
    solver = increment_solver(setup, setup.separation(), threads=1)
    history = [state.summary for state in islice(fretsolve.run(setup), index + 1)]  # FFTW's plans are known then
    nothing = np.zeros((2, *setup.grid.shape))
    start = InitialState(nothing[0], nothing, nothing, np.zeros(6))
    for step in range(index):
        increment = setup.load_path.increment(step, history)
        start = end_of(solver.solve(increment, start), increment)
    increment = setup.load_path.increment(index, history)
    seconds = []
    for _ in range(1 + REPETITIONS):
        began = time.process_time()
        solved = solver.solve(increment, start)
        seconds.append(time.process_time() - began)
    iterations = solved.iterations_normal + solved.iterations_tangential
    return Cost(seconds[0], float(np.median(seconds[1:])), iterations, solved.operator_applications)


def end_of(solved: Solved, increment: Increment) -> InitialState:
    """Return what the next increment starts from."""
    solution = solved.solution
    return InitialState(solution.pressure, solution.shear, solution.displacement, solution.rigid, increment.normal)


@lru_cache
def compile_kernels() -> None:
    """Load the compiled kernels, of small grids and of large ones, so that no increment is charged with it."""
    for job in JOBS:
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
    deque(islice(fretsolve.run(setup_of(JOBS[3], points)), 3), maxlen=0)
    print((peak_bytes() - before) / points**2)


def _rounded(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.0f}"


def print_table(grids: list[int]) -> None:
    """Print the cost of all jobs on some grids, and the memory."""
    compile_kernels()
    print("| job | points | WU, ms | applications | first, WU | again, WU | again, s |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for job in JOBS:
        for points in grids:
            if job.increment is None and points > LARGEST_OF_PATHS:
                continue
            found, unit = cost(job, points), work_unit(points)
            print(
                f"| {job.name} | {points} | {1e3 * unit:.2f} | {found.applications:.0f}"
                f" | {_rounded(found.first / unit)} | {found.again / unit:.0f} | {found.again:.3g} |",
                flush=True,
            )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--memory"]:
        print_bytes_per_cell(int(sys.argv[2]))
    else:
        print_table([int(argument) for argument in sys.argv[1:]] or [256, 512, 1024])
