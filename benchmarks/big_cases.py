"""Big cases and long histories: memory and time predicted and measured, the gain of threads, what writing costs.

    python benchmarks/big_cases.py memory 64 256 1024 2048     # each grid in a process of its own
    python benchmarks/big_cases.py memory 4096                 # mode I.2 on 24 GiB; leave the machine alone for it
    python benchmarks/big_cases.py threads 256 1024 --threads 1 2
    python benchmarks/big_cases.py writing 256 1024
    python benchmarks/big_cases.py histories 1000 10000 100000     # stages

Mode I.2 (``cases/mode1_similar.yaml``) on a square of 0.9 mm: pressed, then sheared to 0.9 mu P at once. Memory is the
largest resident set of ``fretsolve run``; times are those of the processor where one thread is used, without those of
the start, else wall-clock. `threads` is about six increments of mode I.3 (``cases/mode1_dissimilar.yaml``), each saved
beside the next one. The last five are given apart, since the first one makes what a run makes once, and once more as
solved from Python, where nothing is saved.
`writing` is what saving the increments, with the fields that a case stores by default, takes of the solver's thread.
`histories` is what each command takes of a path of many stages, one increment each: a line contact on 32 points, every
increment stored, and a sphere on 16 x 16, stored a hundred times, in cycles of four stages up to 0.6 of mu P.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import fretsolve
from fretsolve.case.keys.unrolled_path import LARGEST_STAGE_COUNT
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

PICTURES = ("loop", "profiles", "map", "stick-history", "convergence")

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
        began = time.perf_counter()
        processor, memory = command("run", case, "-q", "--threads", str(threads), "-o", out, *words)
        wall = time.perf_counter() - began
        with fretsolve.open_result(out) as result:
            times = result.history["wall_time"][:]
    return Taken(memory, processor, wall, times.sum(), times[1:].sum())


def command(*words: str | Path, python: bool = False) -> tuple[float, float]:
    """Return the processor time (s) and the largest resident set (bytes) of a command; python: words of `python -c`."""
    line = [sys.executable, *(("-c",) if python else ("-m", "fretsolve")), *map(str, words)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    child = subprocess.Popen(line, env=environment, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"{shlex.join(line)}: exit code {child.returncode}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


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


HISTORY = """\
{plane}
bodies: [{{young_modulus: 200 GPa, poisson_ratio: 0.3}}, {{young_modulus: 200 GPa, poisson_ratio: 0.3}}]
surface: {surface}
grid: {{points: {points}}}
friction: 0.3
load_path:
  - {{P: 100 {unit}}}
  - cycle:
      stages:
        - {{Qx: 18 {unit}, increments: 1}}
        - {{Qx: 0 {unit}, increments: 1}}
        - {{Qx: -18 {unit}, increments: 1}}
        - {{Qx: 0 {unit}, increments: 1}}
      times: {cycles}
output: {{every: {every}}}
expect: [{{quantity: stick_cells, value: 1, abs: 1000, stage: 1}}]
"""


def history_case(stages: int, *, line: bool) -> str:
    """Return a case of about `stages` stages: a line contact, or a sphere."""
    kind: dict[str, object] = {"plane": "", "surface": "{sphere: {radius: 10 mm}}", "points": 16, "unit": "N"}
    if line:
        kind = {"plane": "plane: strain", "surface": "{cylinder: {radius: 10 mm}}", "points": 32, "unit": "N/mm"}
    return HISTORY.format(**kind, cycles=(stages - 1) // 4, every=1 if line else max(1, stages // 100))


def print_histories(counts: list[int]) -> None:
    """Print what each command takes by the number of stages."""
    found: dict[str, list[str]] = {}
    for stages in counts:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            for name in ("line", "sphere"):
                (place / f"{name}.yaml").write_text(history_case(stages, line=name == "line"))
            for name, words in _reading_and_running(place).items():
                seconds, memory = command(*words, python=words[0].startswith("import"))
                found.setdefault(name, []).append(f"{seconds:.1f} s, {memory / 1e6:.0f} MB")
    print("| | " + " | ".join(f"{stages} stages" for stages in counts) + " |")
    print("| --- " * (len(counts) + 1) + "|")
    for name, cells in found.items():
        print(f"| {name} | {' | '.join(cells)} |")


def _reading_and_running(place: Path) -> dict[str, tuple[str, ...]]:
    """Return the words of each command by what the command does, in an order in which they can be run."""
    line, sphere, of_line, out = (str(place / name) for name in ("line.yaml", "sphere.yaml", "line.h5", "sphere.h5"))
    limits = "tension_limit=300 MPa,torsion_limit=190 MPa"
    read = f"import fretsolve; r = fretsolve.open_result({out!r}); r.history['Qx'], r.cycles, r.field('pressure')"
    pictures = {f"`plot {kind}`": ("plot", out, kind, "-o", str(place / f"{kind}.png")) for kind in PICTURES}
    return {
        "`validate`, line": ("validate", line),
        "`validate`, sphere": ("validate", sphere),
        "`run`, line": ("run", line, "-q", "-o", of_line),
        "`run`, sphere": ("run", sphere, "-q", "-o", out),
        "`check`, line": ("check", line),
        "`show`": ("show", out),
        "`export --to csv`": ("export", out, "--to", "csv", "-o", str(place / "out.csv")),
        "`export --to npz`": ("export", out, "--to", "npz", "-o", str(place / "out.npz")),
        **pictures,
        "`stress`, 100 increments": ("stress", out, "-q", "--step", f"0:{LARGEST_STAGE_COUNT}"),
        "`fatigue`, last cycle of a line": ("fatigue", of_line, "-q", "--criterion", "crossland", "--material", limits),
        "open in Python": (read,),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["memory", "threads", "writing", "histories"])
    parser.add_argument("points", nargs="+", type=int, help="points per side, or stages")
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    options = parser.parse_args()
    if options.what == "memory":
        print_memory(options.points)
    elif options.what == "threads":
        print_threads(options.points, options.threads)
    elif options.what == "writing":
        print_writing(options.points)
    else:
        print_histories(options.points)


if __name__ == "__main__":
    main()
