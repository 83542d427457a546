"""How far a run is: a bar on a terminal, a line of ``key=value`` per increment elsewhere, or nothing."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from fretsolve.state import Summary

REFRESHES_PER_SECOND = 4.0


class Silence(AbstractContextManager["Silence"]):
    """Shows nothing. increments, stages: of the whole path; done: increments there already."""

    def __init__(self, increments: int, stages: int, done: int):
        self.increments, self.stages, self.done = increments, stages, done

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    def show(self, summary: Summary) -> None:
        """Tell of an increment that is saved."""


class Lines(Silence):
    """A line per increment, written out at once."""

    def show(self, summary: Summary) -> None:
        """Print a line of ``key=value`` pairs."""
        values: dict[str, Any] = {
            "step": summary.step,
            "increments": self.increments,
            "stage": summary.stage,
            "stages": self.stages,
            "iterations_normal": summary.iterations_normal,
            "iterations_tangential": summary.iterations_tangential,
            "residual": f"{summary.worst_residual:.1e}",
            "work_total": f"{summary.work_total:.6g}",
            "wall_time": f"{summary.wall_time:.3g}",
        }
        print(" ".join(f"{name}={value}" for name, value in values.items()), flush=True)


class Bar(Silence):
    """A bar with stage, increment, iterations, residual and remaining time, which vanishes at the end."""

    def __init__(self, increments: int, stages: int, done: int):
        super().__init__(increments, stages, done)
        self._progress, self._task = _bar(increments, stages, done)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def show(self, summary: Summary) -> None:
        iterations = summary.iterations_normal + summary.iterations_tangential
        self._progress.update(
            self._task,
            completed=summary.step + 1,
            stage=summary.stage,
            detail=f"{iterations} iterations, residual {summary.worst_residual:.1e}",
        )


def progress(increments: int, stages: int, done: int, *, quiet: bool) -> Silence:
    """What suits where standard output goes."""
    if quiet:
        return Silence(increments, stages, done)
    return (Bar if sys.stdout.isatty() else Lines)(increments, stages, done)


def _bar(increments: int, stages: int, done: int) -> tuple[Progress, TaskID]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn(f"stage {{task.fields[stage]}}/{stages}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[detail]}"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, transient=True, refresh_per_second=REFRESHES_PER_SECOND)
    return bar, bar.add_task("", total=increments, completed=done, stage=1, detail="")
