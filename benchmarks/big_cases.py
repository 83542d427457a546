"""Big cases: memory and time predicted and measured, the gain of threads, and what writing results costs.

    python benchmarks/big_cases.py memory 64 256 1024 2048     # each grid in a process of its own
    python benchmarks/big_cases.py memory 4096                 # mode I.2 on 24 GiB; leave the machine alone for it
    python benchmarks/big_cases.py threads 256 1024 --threads 1 2
    python benchmarks/big_cases.py writing 256 1024

Mode I.2 (``cases/mode1_similar.yaml``) on a square of 0.9 mm: pressed, then sheared to 0.9 mu P at once. Memory is the
largest resident set of ``fretsolve run``; times are those of the processor where one thread is used, without those of
the start, else wall-clock. `threads` is about six increments of mode I.3 (``cases/mode1_dissimilar.yaml``), each saved
beside the next one. The last five are given apart, since the first one makes what a run makes once, and once more as
solved from Python, where nothing is saved.
`writing` is what saving the increments, with the fields that a case stores by default, takes of the solver's thread.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import fretsolve
from fretsolve.problem.setup.cost_estimate import estimate
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header, solve_missing
from fretsolve.system.signals import StopRequest

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "cases" / "mode1_similar.yaml"
FEWEST = 16
"""Points per side of a run that takes but its start."""

PATH = "load_path=[{P: 400 N, increments: 1}, {Qx: 36 N, increments: 1}]"

COUPLED_CASE = ROOT / "cases" / "mode1_dissimilar.yaml"
COUPLED = ("load_path=[{P: 400 N, increments: 3}, {Qx: 36 N, increments: 3}]", "output.every=100")


def overrides(points: int, *others: str) -> list[str]:
    """Return what of the case is changed."""
    return ["expect=[]", f"grid.points={points}", "grid.size=0.9", *(others or (PATH,))]


def setup_of(points: int) -> ProblemSetup:
    """Return the case on `points` by `points` cells."""
    return set_up(fretsolve.load_case(CASE, overrides(points)))


@dataclass(frozen=True)
class Taken:
    """What ``fretsolve run`` takes. memory: largest resident set (bytes); processor, wall: seconds of the command;
    solving: of the wall clock in the increments, and again: in all but the first one."""

    memory: float
    processor: float
    wall: float
    solving: float
    again: float


def run(points: int, threads: int, case: Path = CASE, *others: str) -> Taken:
    """Run the command once. others: what of the case is changed besides its grid, in place of `PATH`."""
    words = [word for text in overrides(points, *others) for word in ("--set", text)]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.h5"
        line = [sys.executable, "-m", "fretsolve", "run", str(case), "-q", "--threads", str(threads), "-o", str(out)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
        began = time.perf_counter()
        child = subprocess.Popen([*line, *words], env=environment)
        _, status, used = os.wait4(child.pid, 0)
        wall = time.perf_counter() - began
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise SystemExit(f"{points} points: exit code {child.returncode}")
        with fretsolve.open_result(out) as result:
            times = result.history["wall_time"][:]
    kilobytes = 1 if sys.platform == "darwin" else 1024
    return Taken(used.ru_maxrss * kilobytes, used.ru_utime + used.ru_stime, wall, times.sum(), times[1:].sum())


def print_memory(sizes: list[int]) -> None:
    """Print predicted and measured memory and time, of the second run of each grid, which knows FFTW's plans."""
    print("| points | memory predicted, MB | measured | deviation | time predicted, s | measured | deviation |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    starting = min(run(FEWEST, 1).processor for _ in range(3))
    for points in sizes:
        expected = estimate(setup_of(points))
        run(points, 1)
        taken = run(points, 1)
        memory, seconds = taken.memory, taken.processor - starting
        print(
            f"| {points} | {expected.memory / 1e6:.0f} | {memory / 1e6:.0f} | {expected.memory / memory - 1:+.0%}"
            f" | {expected.seconds:.2g} | {seconds:.2g} | {expected.seconds / seconds - 1:+.0%} |",
            flush=True,
        )


def by_threads(points: int, threads: int) -> tuple[float, float, float]:
    """Return the wall-clock time of the increments, of all but the first one, and of these where nothing is saved."""
    setup = set_up(fretsolve.load_case(COUPLED_CASE, overrides(points, *COUPLED)))
    taken = run(points, threads, COUPLED_CASE, *COUPLED)
    times = [state.summary.wall_time for state in fretsolve.run(setup, threads=threads)]
    return taken.solving, taken.again, sum(times[1:])


def print_threads(sizes: list[int], counts: list[int]) -> None:
    """Print the wall-clock time of the increments by threads, the least of two runs in turns, after one of each."""
    print("| points | threads | solving, s | gain | last five increments, s | gain | not saved, s | gain |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for points in sizes:
        rounds = [[by_threads(points, threads) for threads in counts] for _ in range(3)]
        least = [[min(times) for times in zip(*runs, strict=True)] for runs in zip(*rounds[1:], strict=True)]
        for threads, found in zip(counts, least, strict=True):
            gains = " | ".join(f"{time:.2f} | {alone / time:.2f}" for time, alone in zip(found, least[0], strict=True))
            print(f"| {points} | {threads} | {gains} |", flush=True)


def print_writing(sizes: list[int]) -> None:
    """Print the processor time of the solver's thread: alone, and with saving before or beside the next increment."""
    print("| points | solving, s | and saving in turn | share of saving | and saving beside it | share of saving |")
    print("| --- | --- | --- | --- | --- | --- |")
    for points in sizes:
        setup = setup_of(points)
        solving = _seconds(lambda setup=setup: deque(fretsolve.run(setup), maxlen=0))
        in_turn, beside = (_seconds(lambda setup=setup, how=how: _recorded(setup, how)) for how in (False, True))
        shares = f"{1 - solving / in_turn:.0%} | {beside:.3f} | {1 - solving / beside:.0%}"
        print(f"| {points} | {solving:.3f} | {in_turn:.3f} | {shares} |", flush=True)


def _recorded(setup: ProblemSetup, beside: bool) -> None:
    with tempfile.TemporaryDirectory() as folder:
        header = run_header(setup, 1, ())
        with HistoryWriter.open(Path(folder) / "out.h5", header) as writer:
            solve_missing(setup, writer, StopRequest(), beside=beside)


def _seconds(job: Callable[[], object]) -> float:
    """Return the least of three times of this thread, after one that is not counted."""
    times = []
    for _ in range(4):
        began = time.thread_time()
        job()
        times.append(time.thread_time() - began)
    return min(times[1:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["memory", "threads", "writing"])
    parser.add_argument("points", nargs="+", type=int)
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    options = parser.parse_args()
    if options.what == "memory":
        print_memory(options.points)
    elif options.what == "threads":
        print_threads(options.points, options.threads)
    else:
        print_writing(options.points)


if __name__ == "__main__":
    main()
