"""Efficiency of sweeps: what a sweep of small cases takes against the sum of its pure solves.

    python benchmarks/sweeps.py [--cases 1000] [--points 64] [--jobs 2] [--fields] [--on local dask slurm] [--repeat 3]

The case is mode I of equal bodies (six increments) over friction and load. `pure` is the time of
``list(fretsolve.run(setup))``, from every tenth of the cases, one after another in one process that has solved one
before; it includes influence coefficients, but no files. It is the mean of two measurements, before and after a sweep,
since the speed of a shared machine drifts. If it drifts by more than a tenth within a minute, use the median of several
(`--repeat`). `efficiency` is pure over jobs times the wall-clock time of ``fretsolve sweep run``, which includes start,
check and files. `in its own run` replaces pure by the sum of `wall_time` over all increments of its own results,
times what pure is of that sum in its own cases: drift cancels, but so does what the processes take from each other.
The same ratio of processor times tells what a sweep costs on a machine that is shared with others. Dask is a
LocalCluster with one worker of one thread per job; Slurm is one node on this machine (root and Debian's packages).
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import fretsolve
from fretsolve.simulation.problem_setup import set_up

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "cases" / "mode1_similar.yaml"
LOADS = 10
SAMPLE = 10
"""One case of so many is solved for the pure time."""

SWEEP = """\
title: benchmark
case: {case}
set: {{expect: [], grid.points: {points}{fields}}}
axes:
  - friction: {{from: 0.1, to: 0.5, count: {frictions}}}
  - load_path.0.P: {{from: 400 N, to: 800 N, count: {loads}}}
slurm: {{cases_per_task: {per_task}}}
"""
CLUSTER = """\
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers={jobs}, threads_per_worker=1, dashboard_address=None, memory_limit=0) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


def pure(cases: int, points: int) -> tuple[float, float, float]:
    """Return wall-clock and processor seconds of all solves, from a sample, and the former over their `wall_time`."""
    frictions = cases // LOADS
    chosen = [
        (0.1 + 0.4 * number / max(frictions - 1, 1), 400.0 + 400.0 * load / (LOADS - 1))
        for index, (number, load) in enumerate((number, load) for number in range(frictions) for load in range(LOADS))
        if index % SAMPLE == index // SAMPLE % LOADS
    ]
    setups = [
        set_up(
            fretsolve.load_case(
                CASE, ["expect=[]", f"grid.points={points}", f"friction={friction}", f"load_path.0.P={load}"]
            )
        )
        for friction, load in chosen
    ]
    deque(fretsolve.run(setups[0]), maxlen=0)
    began, began_processor = time.perf_counter(), time.process_time()
    told = sum(state.summary.wall_time for setup in setups for state in fretsolve.run(setup))
    wall, processor = time.perf_counter() - began, time.process_time() - began_processor
    return cases / len(setups) * wall, cases / len(setups) * processor, wall / told


def timed(line: list[str], environment: dict[str, str], finish: Callable[[], None]) -> tuple[float, float]:
    """Return wall-clock and processor seconds of a command with all that it starts, and of `finish`."""
    before, began = _children(), time.perf_counter()
    subprocess.run(line, env=environment, check=True, stdout=subprocess.DEVNULL)
    finish()
    return time.perf_counter() - began, _children() - before


def solving_seconds(path: Path) -> float:
    """Return the wall-clock time of a result's increments."""
    with fretsolve.open_result(path) as result:
        return float(result.history["wall_time"].sum())


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@contextmanager
def engine(name: str, jobs: int, folder: Path) -> Iterator[tuple[list[str], dict[str, str]]]:
    """Yield options and environment of `sweep run` on an engine that runs within the block."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    if name == "local":
        yield ["-j", str(jobs)], environment
    elif name == "slurm":
        sys.path.insert(0, str(ROOT / "tests" / "engines"))
        from one_node_slurm import running_slurm

        folder.chmod(0o755)
        own = folder / "engine"
        own.mkdir()
        with running_slurm(own) as slurm:
            yield ["--on", "slurm"], {**environment, **slurm}
    else:
        script = folder / "cluster.py"
        script.write_text(CLUSTER.format(jobs=jobs))
        pipe = subprocess.PIPE
        line = [sys.executable, str(script)]
        with subprocess.Popen(line, stdin=pipe, stdout=pipe, text=True, env=environment, cwd=folder) as process:
            assert process.stdout is not None
            yield ["--on", f"dask:{process.stdout.readline().strip()}"], environment
            process.communicate()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--points", type=int, default=64)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--fields", action="store_true", help="store all fields, not only the history")
    parser.add_argument("--on", nargs="+", choices=["local", "dask", "slurm"], default=["local"])
    parser.add_argument("--repeat", type=int, default=1, help="sweeps on each engine, in turn")
    options = parser.parse_args()
    cases = options.cases // LOADS * LOADS
    before = pure(cases, options.points)
    print(f"{cases} cases of {options.points} x {options.points} cells, {options.jobs} at a time\n")
    by_processor = "pure, processor s | processor, s | efficiency"
    print(f"| engine | pure, s | wall clock, s | efficiency | in its own run | {by_processor} |\n|{' --- |' * 8}")
    for name in options.on * options.repeat:
        with tempfile.TemporaryDirectory(prefix="fretsolve-") as text:
            folder = Path(text)
            sweep = folder / "sweep.yaml"
            per_task = -(-cases // options.jobs)
            sweep.write_text(
                SWEEP.format(
                    case=CASE,
                    points=options.points,
                    fields="" if options.fields else ", output.fields: []",
                    frictions=cases // LOADS,
                    loads=LOADS,
                    per_task=per_task,
                )
            )
            results = folder / "sweep.sweep" / "results"

            def all_there(results: Path = results) -> None:
                while len(list(results.glob("*.h5"))) < cases:
                    time.sleep(0.1)

            with engine(name, options.jobs, folder) as (words, environment):
                line = [sys.executable, "-m", "fretsolve", "sweep", "run", str(sweep), *words]
                seconds, used = timed(line, environment, all_there)
            own = sum(solving_seconds(path) for path in results.glob("*.h5")) / seconds / options.jobs
            after = pure(cases, options.points)
            wall, processor, whole = (0.5 * (one + other) for one, other in zip(before, after, strict=True))
            before = after
            told = f"{processor:.1f} | {used:.1f} | {processor / used:.0%}" if name == "local" else "- | - | -"
            shares = f"{wall / seconds / options.jobs:.0%} | {whole * own:.0%}"
            print(f"| {name} | {wall:.1f} | {seconds:.1f} | {shares} | {told} |", flush=True)


if __name__ == "__main__":
    main()
