"""Processor time that a sweep takes beyond solving: planning, writing and checking a case, without the start.

    python benchmarks/sweep_overhead.py [--cases 200] [--solved 5] [--points 48]

Mode I.3, 10 increments a stage, over friction. All cases are planned. In one process, some are solved alone and run as
a worker of a sweep runs them, in turns, several times; of each the least counts. What other processes of a busy machine
take from the cache hits both alike.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

import fretsolve
from fretsolve.sweep.case_run import CaseRunner
from fretsolve.sweep.manifest import write_manifest
from fretsolve.sweep.plan import make_sweep_plan

CASE = Path(__file__).resolve().parent.parent / "cases" / "mode1_dissimilar.yaml"
REPETITIONS = 8

SWEEP = """\
title: benchmark
case: {case}
set: {{expect: [], grid.points: {points}{fields}}}
axes:
  - friction: {{from: 0.1, to: 0.2, count: {cases}}}
"""


class Never:
    """A request to stop that never comes."""

    requested = False


def seconds(work: Callable[[], object]) -> float:
    """Return the processor time of a call."""
    began = time.process_time()
    work()
    return time.process_time() - began


def row(cases: int, solved: int, points: int, fields: bool, folder: Path) -> str:
    """Return a row of the table: milliseconds of a case, and their sum beyond solving over that."""
    sweep = folder / "sweep.yaml"
    without = "" if fields else ", output.fields: []"
    sweep.write_text(SWEEP.format(case=CASE, points=points, fields=without, cases=cases))
    plan = make_sweep_plan(sweep, folder / "sweep.sweep")  # loads what planning needs

    def write_plan() -> None:
        write_manifest(make_sweep_plan(sweep, folder / "sweep.sweep").manifest)

    planning = min(seconds(write_plan) for _ in range(REPETITIONS)) / cases
    runner, solving, running = CaseRunner(plan.manifest), 0.0, 0.0
    for index, case in enumerate(plan.manifest.rows[:: max(cases // solved, 1)][:solved]):
        prepared = runner.base.prepare(case.settings, plan.manifest.results)
        alone, whole = [], []
        for repetition in range(REPETITIONS + (index == 0)):  # once more where kernels and plans are made
            alone.append(seconds(lambda setup=prepared.setup: deque(fretsolve.run(setup), maxlen=0)))
            prepared.out.unlink(missing_ok=True)
            whole.append(seconds(lambda case=case: runner.run(case, Never())))
            assert prepared.out.exists(), repetition
        solving, running = solving + min(alone) / solved, running + min(whole) / solved
    overhead = (planning + running) / solving - 1.0
    times = " | ".join(f"{1e3 * value:.1f}" for value in (solving, running - solving, planning))
    return f"| {'all' if fields else 'none'} | {times} | {overhead:.1%} |"


def main() -> None:
    """Print a table for docs/scaling.md."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--solved", type=int, default=5)
    parser.add_argument("--points", type=int, default=48)
    options = parser.parse_args()
    print("| fields stored | solving, ms | writing and checking, ms | planning, ms | beyond solving |")
    print("| --- " * 5 + "|")
    for fields in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            print(row(options.cases, options.solved, options.points, fields, Path(folder)), flush=True)


if __name__ == "__main__":
    main()
