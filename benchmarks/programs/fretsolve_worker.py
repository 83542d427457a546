"""The base case solved by fretsolve."""

from __future__ import annotations

import math
import statistics
from pathlib import Path

from task import Answer, Task, read_task

import fretsolve
from fretsolve.result.state import Summary

CASE = Path(__file__).resolve().parents[2] / "cases" / "mode1_similar.yaml"


def increment(task: Task) -> Summary:
    """Solve the job: the history of its last increment."""
    path = f"{{P: {task.load}}}"
    if task.job == "mode1":
        path += f", {{delta_x: {task.delta_x!r}, increments: 1}}"
    overrides = (
        "expect=[]",
        "coupling=none",
        f"grid.points={task.points}",
        f"grid.size={task.size}",
        f"solver.tolerance={task.tolerance}",
        f"load_path=[{path}]",
    )
    *_, last = fretsolve.run(fretsolve.load_case(CASE, overrides))
    return last.summary


def main() -> None:
    """Solve and answer."""
    task = read_task()
    history = [increment(task) for _ in range(task.repeats)]
    last = history[-1]
    normal = task.job == "normal"
    cells = last.contact_cells if normal else last.stick_cells
    Answer(
        version=fretsolve.__version__,
        seconds=statistics.median(summary.wall_time for summary in history),
        rigid=last.delta_z if normal else last.Qx,
        peak=last.max_pressure if normal else last.max_shear,
        radius=(task.size / task.points) * math.sqrt(cells / math.pi),  # counted, as the others do
        residual=last.residual_gap if normal else last.residual_stick,
        iterations=last.iterations_normal if normal else last.iterations_tangential,
        applications=last.operator_applications,
    ).send()


if __name__ == "__main__":
    main()
