"""``fretsolve study``: a case run over crossed settings, what each run costs and how far it is off."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from fretsolve.commands.study_progress import study_progress
from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.export.text_report import NARROWEST, WIDTH
from fretsolve.study.assessment import Assessment, assess
from fretsolve.study.plan import Plan, make_plan
from fretsolve.study.result_files import CSV_NAME, HDF5_NAME, write_csv, write_hdf5
from fretsolve.study.run_trials import Outcome, is_done, make_runs
from fretsolve.study.table import tables
from fretsolve.study.wording import advice, notes
from fretsolve.system import atomic_files
from fretsolve.system.files import make_folder, writing
from fretsolve.system.optional import how_to_install
from fretsolve.system.signals import EXIT_STOPPED

if TYPE_CHECKING:
    from fretsolve.study.compared_with import TruthKind
    from fretsolve.study.trial import Trial
    from fretsolve.system.signals import StopRequest

PICTURE_NAME = "study.png"


@dataclass(frozen=True)
class StudyOrder:
    """What the command line asks for. out: a folder, None for the case's name with .study."""

    case: Path
    out: Path | None
    overrides: tuple[str, ...]
    varied: tuple[str, ...]
    quantities: tuple[str, ...]
    truth: TruthKind
    quiet: bool

    @property
    def folder(self) -> Path:
        """Where results, tables and the picture go."""
        return self.out or self.case.with_suffix(".study")


def study_case(order: StudyOrder, stop: StopRequest) -> int:
    """Make the runs, compare and report. Returns the exit code 0, 3 or 75; raises the errors of the others."""
    plan = make_plan(
        order.case, order.overrides, order.varied, order.quantities, order.truth, order.folder
    )
    make_folder(order.folder)
    _introduce(order, plan)
    outcomes: list[Outcome] = []
    with study_progress(plan.trials, quiet=order.quiet) as display:
        for outcome in make_runs(plan.trials, plan.observables, stop, display.increment):
            outcomes.append(outcome)
            display.outcome(outcome)
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


def _introduce(order: StudyOrder, plan: Plan) -> None:
    """Say what is about to be run, and what a person should hear of it."""
    warnings = [
        f"{key} changes the problem itself: what differs is no error; `fretsolve sweep` is made for that"
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
    print(f"{'reference' if plan.problem_keys else 'truth'}: {plan.truth_words}")
    if plan.unknown:
        print(f"left out, without a closed form: {', '.join(map(str, plan.unknown))}")
        if plan.why_unknown:
            print(f"({plan.why_unknown})")
    sys.stdout.flush()


def _title(order: StudyOrder, trial: Trial) -> str:
    return trial.setup.case.title or order.case.name


def _write(order: StudyOrder, study: Assessment, *, picture: bool) -> None:
    """The files of the study, as far as it is; a picture of another one does not stay beside them."""
    write_csv(order.folder / CSV_NAME, study)
    write_hdf5(order.folder / HDF5_NAME, study, list(advice(study)))
    path = order.folder / PICTURE_NAME
    with writing(path):
        atomic_files.remove(path)
        if picture:
            _draw(path, study, _title(order, study.finest))


def _draw(path: Path, study: Assessment, title: str) -> None:
    """Write the picture, or a line that says what it needs. Raises OSError."""
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
    """Say what came out. Raises NoSolutionError where there is nothing to compare with, or nothing to compare."""
    if not order.quiet:
        _print(order, study)
    finest_row = study.finest_row
    if finest_row is not None and finest_row.is_truth and finest_row.outcome.failure:
        outcome = finest_row.outcome
        raise NoSolutionError(
            f"the {study.standard} ({outcome.trial.combination.words}) has no solution, so no {study.difference}s are"
            f" known: {outcome.failure}"
        )
    if all(row.outcome.failure for row in study.rows):
        raise NoSolutionError(f"none of the runs has a solution: {study.rows[0].outcome.failure}")
    if not study.observables:
        zero = ", ".join(map(str, study.left_out))
        raise CaseError(f"nothing to compare, since 0: {zero}; name others with --quantity", (), order.case)
    return 0


def _print(order: StudyOrder, study: Assessment) -> None:
    console = Console(highlight=False)
    if not console.is_terminal or console.width < NARROWEST:
        console = Console(highlight=False, width=WIDTH)
    for table in tables(study, console.width):
        console.print()
        console.print(table)
    for line in notes(study):
        print(line)
    for sentence in advice(study):
        print(sentence)
    names = [name for name in (CSV_NAME, HDF5_NAME, PICTURE_NAME) if (order.folder / name).exists()]
    print("written: " + ", ".join(str(order.folder / name) for name in names), flush=True)
