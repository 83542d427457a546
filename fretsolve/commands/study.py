"""``fretsolve study``: run a case over crossed settings, and weigh the error of each run against its cost."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fretsolve.commands.progress import key_value_line, progress_bar
from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.export.text_report import report_console
from fretsolve.result.state import Summary
from fretsolve.study.assessment import Assessment, assess
from fretsolve.study.plan import StudyPlan, make_plan
from fretsolve.study.reference import ReferenceKind
from fretsolve.study.result_files import CSV_NAME, HDF5_NAME, write_csv, write_hdf5
from fretsolve.study.runs import Outcome, is_done, make_runs
from fretsolve.study.table import tables
from fretsolve.study.variation import words
from fretsolve.study.wording import advice, notes
from fretsolve.sweep.base_case import PreparedCase
from fretsolve.system import atomic_files
from fretsolve.system.environment import how_to_install
from fretsolve.system.files import make_folder, writing
from fretsolve.system.signals import EXIT_STOPPED, StopRequest

PICTURE_NAME = "study.png"


@dataclass(frozen=True)
class StudyOrder:
    """What the command line asks for. out: a folder, None for the case's name with .study."""

    case: Path
    out: Path | None
    overrides: tuple[str, ...]
    varied: tuple[str, ...]
    quantities: tuple[str, ...]
    reference: ReferenceKind
    quiet: bool

    @property
    def folder(self) -> Path:
        """The folder of results, tables and the picture."""
        return self.out or self.case.with_suffix(".study")


def study_case(order: StudyOrder, stop: StopRequest) -> int:
    """Make the runs, compare them and report. Returns the exit code 0 or 75; errors have the other codes."""
    plan = make_plan(order.case, order.overrides, order.varied, order.quantities, order.reference, order.folder)
    make_folder(order.folder)
    _introduce(order, plan)
    outcomes: list[Outcome] = []
    progress = RunProgress(plan.trials, quiet=order.quiet)
    with progress.shown():
        for outcome in make_runs(plan.trials, plan.quantities, stop, progress.increment):
            outcomes.append(outcome)
            progress.outcome(outcome)
    complete = len(outcomes) == len(plan.trials)
    if outcomes:
        study = assess(plan, outcomes)
        drawn = complete and not plan.problem_keys and any(row.compared for row in study.rows)
        _write(order, study, picture=drawn)
    if complete:
        return _conclude(order, study)
    if not order.quiet:
        done = f"stopped with {len(outcomes)} of {len(plan.trials)} runs done"
        print(f"{done}; the same command goes on", file=sys.stderr)
    return EXIT_STOPPED


class RunProgress:
    """Shows how far the runs `trials` are: a bar on a terminal, a line per run elsewhere, or nothing if quiet."""

    def __init__(self, trials: Sequence[PreparedCase], *, quiet: bool):
        self._runs, self._done, self._quiet = len(trials), 0, quiet
        self._seconds = {trial.out: 0.0 if is_done(trial) else trial.expected.seconds for trial in trials}
        self._before = 0.0
        self.bar = None
        if not quiet and sys.stdout.isatty():
            self.bar = progress_bar(f"run {{task.fields[run]}}/{self._runs}", "{task.fields[detail]}")
            self._task = self.bar.add_task("", total=sum(self._seconds.values()), run=1, detail="")

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Show the bar, if there is one, within the block."""
        if self.bar is None:
            yield
        else:
            with self.bar:
                yield

    def increment(self, trial: PreparedCase, summary: Summary) -> None:
        """Show an increment that is saved."""
        if self.bar is not None:
            done, increments = summary.step + 1, trial.setup.load_path.increments
            self.bar.update(
                self._task,
                completed=self._before + self._seconds[trial.out] * done / increments,
                detail=f"{words(trial.settings)}: increment {done}/{increments}",
            )

    def outcome(self, outcome: Outcome) -> None:
        """Show a run that has ended."""
        self._done += 1
        self._before += self._seconds[outcome.trial.out]
        if self.bar is not None:
            self.bar.update(self._task, completed=self._before, run=min(self._done + 1, self._runs))
        elif not self._quiet:
            key_value_line(
                run=self._done,
                runs=self._runs,
                **{setting.key: setting.value for setting in outcome.trial.settings},
                status="failed" if outcome.failure else "complete",
                reused="yes" if outcome.reused else "no",
                increments=outcome.increments,
                operator_applications=outcome.applications,
                wall_time=f"{outcome.seconds:.3g}",
            )


def _introduce(order: StudyOrder, plan: StudyPlan) -> None:
    """Print what is about to be run, and all warnings."""
    warnings = [
        f"{key} changes the problem itself. Differences are not errors; use `fretsolve sweep`."
        for key in plan.problem_keys
    ]
    warnings += dict.fromkeys(text for trial in plan.trials for text in trial.setup.model.warnings)
    for text in warnings:
        print(f"{order.case}: warning: {text}", file=sys.stderr)
    if order.quiet:
        return
    count, done = len(plan.trials), sum(map(is_done, plan.trials))
    there = f", {done} of them there already" if done else ""
    print(_title(order, plan.finest))
    print(f"results: {order.folder}")
    print(f"{count} run{'s' if count > 1 else ''}{there}")
    print(f"{'reference' if plan.problem_keys else 'truth'}: {plan.reference_words}")
    if plan.unknown:
        print(f"left out, without a closed form: {', '.join(map(str, plan.unknown))}")
        if plan.why_unknown:
            print(f"({plan.why_unknown})")
    sys.stdout.flush()


def _title(order: StudyOrder, trial: PreparedCase) -> str:
    return trial.setup.case.title or order.case.name


def _write(order: StudyOrder, study: Assessment, *, picture: bool) -> None:
    """Write the files of the study as far as it is, and remove the picture of an earlier one."""
    write_csv(order.folder / CSV_NAME, study)
    write_hdf5(order.folder / HDF5_NAME, study, list(advice(study)))
    path = order.folder / PICTURE_NAME
    with writing(path):
        atomic_files.remove(path)
        if picture:
            _draw(path, study, _title(order, study.finest))


def _draw(path: Path, study: Assessment, title: str) -> None:
    """Write the picture, or print what it needs. Raises OSError."""
    try:
        from fretsolve.plots.canvas import rendered
        from fretsolve.study.plot import trade
    except ImportError as error:
        print(
            f"{path}: not drawn: matplotlib is needed, which cannot be imported ({error}): {how_to_install('plot')}",
            file=sys.stderr,
        )
        return
    content = rendered(trade(study, title), "png")
    with atomic_files.new_file(path, path.parent) as file:
        file.write(content)


def _conclude(order: StudyOrder, study: Assessment) -> int:
    """Print the outcome. Raises NoSolutionError if the reference or all runs failed, CaseError if all is 0."""
    if not order.quiet:
        _print(order, study)
    finest_row = study.finest_row
    if finest_row is not None and finest_row.is_reference and finest_row.outcome.failure:
        outcome = finest_row.outcome
        raise NoSolutionError(
            f"the {study.standard} ({words(outcome.trial.settings)}) has no solution, so no {study.difference}s are"
            f" known: {outcome.failure}"
        )
    if all(row.outcome.failure for row in study.rows):
        raise NoSolutionError(f"none of the runs has a solution: {study.rows[0].outcome.failure}")
    if not study.quantities:
        zero = ", ".join(map(str, study.left_out))
        raise CaseError(f"nothing to compare, since 0: {zero}; name others with --quantity", (), order.case)
    return 0


def _print(order: StudyOrder, study: Assessment) -> None:
    console = report_console()
    for table in tables(study, console.width):
        console.print()
        console.print(table)
    for line in (*notes(study), *advice(study)):
        print(line)
    names = [name for name in (CSV_NAME, HDF5_NAME, PICTURE_NAME) if (order.folder / name).exists()]
    print("written: " + ", ".join(str(order.folder / name) for name in names), flush=True)
