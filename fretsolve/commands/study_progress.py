"""How far a study is: a bar on a terminal, a line of ``key=value`` per run elsewhere, or nothing."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from fretsolve.commands.progress import key_value_line, progress_bar
from fretsolve.study.run_trials import is_done

if TYPE_CHECKING:
    from fretsolve.result.state import Summary
    from fretsolve.study.run_trials import Outcome
    from fretsolve.study.trial import Trial


class Silence(AbstractContextManager["Silence"]):
    """Shows nothing of `trials`, which are run in that order."""

    def __init__(self, trials: Sequence[Trial]):
        self.runs = len(trials)
        self.done = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def increment(self, trial: Trial, summary: Summary) -> None:
        """Tell of an increment that is saved."""

    def outcome(self, outcome: Outcome) -> None:
        """Tell of a run that is done."""


class Lines(Silence):
    """A line per run, written out at once."""

    def outcome(self, outcome: Outcome) -> None:
        """Print a line of ``key=value`` pairs; a value with blanks is in quotes."""
        self.done += 1
        values: dict[str, Any] = {"run": self.done, "runs": self.runs}
        values |= {setting.key: setting.value for setting in outcome.trial.combination.settings}
        values |= {
            "status": "failed" if outcome.failure else "complete",
            "reused": "yes" if outcome.reused else "no",
            "increments": outcome.increments,
            "operator_applications": outcome.applications,
            "wall_time": f"{outcome.seconds:.3g}",
        }
        key_value_line(**values)


class Bar(Silence):
    """A bar over the estimated time of all runs, with the run, its increment and the remaining time."""

    def __init__(self, trials: Sequence[Trial]):
        super().__init__(trials)
        self.bar = progress_bar(f"run {{task.fields[run]}}/{self.runs}", "{task.fields[detail]}")
        self._before = 0.0
        self._shares = {trial.out: 0.0 if is_done(trial) else trial.seconds for trial in trials}
        self._task = self.bar.add_task("", total=sum(self._shares.values()), run=1, detail="")

    def __enter__(self) -> Self:
        self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.bar.stop()

    def increment(self, trial: Trial, summary: Summary) -> None:
        increments = trial.setup.load_path.increments
        self.bar.update(
            self._task,
            completed=self._before + self._shares[trial.out] * (summary.step + 1) / increments,
            detail=f"{trial.combination.words}: increment {summary.step + 1}/{increments}",
        )

    def outcome(self, outcome: Outcome) -> None:
        self.done += 1
        self._before += self._shares[outcome.trial.out]
        self.bar.update(self._task, completed=self._before, run=min(self.done + 1, self.runs))


def study_progress(trials: Sequence[Trial], *, quiet: bool) -> Silence:
    """What suits where standard output goes."""
    if quiet:
        return Silence(trials)
    return (Bar if sys.stdout.isatty() else Lines)(trials)

