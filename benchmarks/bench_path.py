"""Increments of the modes in WU and seconds, in asv's shape; ``python benchmarks/bench_path.py`` prints the table.

The base case on a square potential contact area of 0.9 mm, one thread, tolerance 1e-6, certificates met. Seconds are
of the solve alone, plans and influence coefficients made before where the path allows (the second of two runs).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from work_unit import work_unit

import fretsolve
from fretsolve.state import State, Summary

CASES = Path(__file__).resolve().parent.parent / "cases"


@dataclass(frozen=True)
class Job:
    """A case, what is changed in it, and the steps whose mean cost is asked for (all where `steps` is None)."""

    name: str
    case: str
    overrides: tuple[str, ...]
    steps: slice


JOBS = (
    Job("normal (Hertz, from nothing)", "mode1_similar", (), slice(0, 1)),
    Job("mode I.2, one increment 0 to 0.9 mu P", "mode1_similar", (), slice(1, 2)),
    Job("mode I.1, one increment", "mode1_similar_uncoupled", ("load_path.1.increments=1",), slice(1, 2)),
    Job("mode I.3, mean per increment of the path", "mode1_dissimilar", (), slice(None)),
)


def summaries(job: Job, points: int) -> list[Summary]:
    """The history of `job`, as far as its steps go."""
    overrides = ["expect=[]", f"grid.points={points}", "grid.size=0.9", *job.overrides]
    case = fretsolve.load_case(CASES / f"{job.case}.yaml", overrides)
    return list(_first(fretsolve.run(case), job.steps.stop))


def _first(states: Iterator[State], count: int | None) -> Iterator[Summary]:
    for step, state in enumerate(states):
        yield state.summary
        if count is not None and step + 1 == count:
            return


class PathCost:
    """Cost of an increment by grid and job."""

    params = ((256, 512), tuple(job.name for job in JOBS))
    param_names = ("points", "job")
    timeout = 600

    def setup(self, points: int, name: str) -> None:
        """Make FFTW's plans, which are kept."""
        self.job = next(job for job in JOBS if job.name == name)
        self.history = summaries(self.job, points)

    def track_applications(self, points: int, name: str) -> float:
        """Mean operator applications per increment."""
        chosen = self.history[self.job.steps]
        return sum(summary.operator_applications for summary in chosen) / len(chosen)

    def track_iterations(self, points: int, name: str) -> float:
        """Mean iterations per increment, normal and tangential."""
        chosen = self.history[self.job.steps]
        return sum(s.iterations_normal + s.iterations_tangential for s in chosen) / len(chosen)

    def track_work_units(self, points: int, name: str) -> float:
        """Mean seconds per increment over the WU measured here."""
        chosen = summaries(self.job, points)[self.job.steps]
        return sum(summary.wall_time for summary in chosen) / len(chosen) / work_unit(points)


if __name__ == "__main__":
    grids = [int(argument) for argument in sys.argv[1:]] or list(PathCost.params[0])
    print("| job | points | applications | iterations | WU of time |")
    print("| --- | --- | --- | --- | --- |")
    for job in JOBS:
        for points in grids:
            bench = PathCost()
            bench.setup(points, job.name)
            figures = (
                f"{bench.track_applications(points, job.name):.1f}",
                f"{bench.track_iterations(points, job.name):.1f}",
                f"{bench.track_work_units(points, job.name):.0f}",
            )
            print(f"| {job.name} | {points} |", " | ".join(figures), "|", flush=True)
