"""How far a run is: a bar on a terminal, a line per increment elsewhere, as ``key=value`` or as JSON, or nothing."""

from __future__ import annotations

import json
import math
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from fretsolve.result.state import Summary, SummaryErrors

REFRESHES_PER_SECOND = 4.0


class Display(AbstractContextManager["Display"]):
    """Shows progress inside a `with` block; a bar, where there is one, vanishes at its end."""

    bar: Progress | None = None

    def __enter__(self) -> Self:
        if self.bar is not None:
            self.bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.bar is not None:
            self.bar.stop()


class Silence(Display):
    """Shows nothing. increments, stages: of the whole path; done: increments there already."""

    def __init__(self, increments: int, stages: int, done: int):
        self.increments, self.stages, self.done = increments, stages, done

    def show(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        """Tell of an increment that is saved, and of its error bars if there are any."""


class Lines(Silence):
    """A line per increment, written out at once."""

    def show(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        """Print a line of ``key=value`` pairs."""
        print(" ".join(f"{name}={value}" for name, value in self._values(summary, errors).items()), flush=True)

    def _values(self, summary: Summary, errors: SummaryErrors | None) -> dict[str, Any]:
        return {
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


class Details(Lines):
    """A line per increment with all of the history."""

    def _values(self, summary: Summary, errors: SummaryErrors | None) -> dict[str, Any]:
        values = super()._values(summary, errors)
        every = vars(summary) | (vars(errors) if errors is not None else {})
        return values | {name: f"{value:.6g}" for name, value in every.items() if name not in values}


class JsonLines(Silence):
    """A JSON object per increment with all of the history."""

    def show(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        every = vars(summary) | (vars(errors) if errors is not None else {})
        event("increment", increments=self.increments, stages=self.stages, **every)


def event(kind: str, **values: Any) -> None:
    """Print a JSON object on one line, at once; what is not a finite number is null, as JSON has no NaN."""
    finite = {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()}
    print(json.dumps({"event": kind, **finite}, ensure_ascii=False, allow_nan=False), flush=True)


class Bar(Silence):
    """A bar with stage, increment, iterations, residual and remaining time."""

    bar: Progress

    def __init__(self, increments: int, stages: int, done: int):
        super().__init__(increments, stages, done)
        self.bar, self._task = _bar(increments, stages, done)

    def show(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        iterations = summary.iterations_normal + summary.iterations_tangential
        self.bar.update(
            self._task,
            completed=summary.step + 1,
            stage=summary.stage,
            detail=f"{iterations} iterations, residual {summary.worst_residual:.1e}",
        )


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
