"""``fretsolve study``: run a case over crossed settings, and weigh the error of each run against its cost."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fretsolve.cli.case_messages import CaseMessages, none_solved
from fretsolve.cli.commands.plot import require_matplotlib
from fretsolve.errors import CaseError, FileError, NoSolutionError
from fretsolve.post.export.text_report import report_console
from fretsolve.sweep.case_run import run_serially
from fretsolve.sweep.manifest import MANIFEST_NAME, states
from fretsolve.sweep.outcome import CaseOutcome, read_outcome
from fretsolve.sweep.quantity import listed
from fretsolve.sweep.study.assessment import (
    CSV_NAME,
    HDF5_NAME,
    PICTURE_NAME,
    Assessment,
    assess,
    require_own_folder,
    write_study_csv,
    write_study_hdf5,
)
from fretsolve.sweep.study.plan import NOUNS, StudyPlan, StudyRequest, make_study_plan
from fretsolve.sweep.study.report import advice, failures, notes, tables
from fretsolve.system import atomic_files
from fretsolve.system.files import make_folder, writing
from fretsolve.system.progress import print_error_line
from fretsolve.system.signals import EXIT_STOPPED, StopRequest


def study_case(out: Path | None, stop: StopRequest, *, quiet: bool, **asked: Any) -> int:
    """Run the cases of a study, compare them and report. Return the exit code 0 or 75; errors have the other codes.

    out: a folder, None for the case's name with .study; asked: the fields of a `StudyRequest`.
    """
    request = StudyRequest(**asked)
    case = request.case
    folder = out or case.with_suffix(".study")
    if (folder / MANIFEST_NAME).exists():
        raise CaseError("holds a sweep; give another folder with -o", (), folder)
    require_own_folder(folder)
    plan = make_study_plan(request, folder)
    for row in plan.manifest.rows:
        if plan.manifest.result(row).exists():
            try:
                plan.manifest.own_attributes(row)
            except FileError as error:
                raise FileError(f"{error.message}; remove it to run the case again", error.file) from error
    make_folder(folder)
    messages = CaseMessages(plan.manifest, plan.manifest.missing(), len(plan.cases), quiet=quiet, bar=True)
    messages.start(case, folder, _warnings(plan), _about_reference(plan))
    outcomes = _run(plan, stop, messages)
    complete = len(outcomes) == len(plan.cases)
    if outcomes:
        study = assess(plan, outcomes)
        drawn = complete and not plan.problem_keys and any(row.compared for row in study.rows)
        _write(folder, study, plan.manifest.title if drawn else None)
    if not complete:
        messages.end(list(states(plan.manifest)))
        return EXIT_STOPPED
    if quiet:
        for line in failures(study):
            print_error_line(line)
    else:
        _print(folder, study)
    _require_comparison(case, study)
    return 0


def _warnings(plan: StudyPlan) -> Iterator[str]:
    for key in plan.problem_keys:
        yield f"{key} changes the problem itself. Differences are not errors; use `fretsolve sweep`."
    yield from dict.fromkeys(text for case in plan.cases for text in case.setup.model.warnings)


def _about_reference(plan: StudyPlan) -> Iterator[str]:
    yield f"reference: {plan.reference_words}"
    if plan.unknown:
        yield f"left out, with no {NOUNS[plan.kind]}: {listed(plan.unknown)}"
    if plan.why_unknown:
        yield f"({plan.why_unknown})"


def _run(plan: StudyPlan, stop: StopRequest, messages: CaseMessages) -> list[CaseOutcome]:
    """Run what is missing, and return the outcomes in the order of the plan; fewer of them if a signal has come."""
    outcomes: list[CaseOutcome] = []
    with messages.progress():
        reports = run_serially(plan.cases, stop, messages.increment)
        for case, report in zip(plan.cases, reports, strict=False):
            outcome = read_outcome(case.out, plan.quantities, case.setup.load_path, corrected=plan.corrected)
            outcomes.append(outcome)
            messages.warn(case.out, report.notes)
            messages.case(
                case.id,
                **case.settings,
                status="failed" if outcome.failure else "complete",
                reused="no" if report.wrote_result else "yes",
                increments=outcome.increments,
                operator_applications=outcome.applications,
                wall_time=f"{outcome.seconds:.3g}",
            )
    return outcomes


def _write(folder: Path, study: Assessment, title: str | None) -> None:
    """Write the files of the study as far as it is, and remove the picture of an earlier one.

    title: of the picture, None for no picture.
    """
    path = folder / PICTURE_NAME
    with atomic_files.all_or_none() as making:
        with making(folder / CSV_NAME):
            write_study_csv(folder / CSV_NAME, study)
        with making(folder / HDF5_NAME):
            write_study_hdf5(folder / HDF5_NAME, study, list(advice(study)))
        with writing(path):
            atomic_files.remove(path)
            if title is not None:
                _draw(path, study, title)


def _draw(path: Path, study: Assessment, title: str) -> None:
    """Write the picture, or print what it needs. Raises OSError."""
    try:
        require_matplotlib()
    except CaseError as error:
        print_error_line(f"{path}: not drawn: {error}")
        return
    from fretsolve.post.plots.canvas import rendered
    from fretsolve.sweep.study.plot import trade

    content = rendered(trade(study, f"{title}{', corrected values' * study.plan.corrected}"), "png")
    with atomic_files.new_file(path) as file:
        file.write(content)


def _require_comparison(source: Path, study: Assessment) -> None:
    """Raise NoSolutionError if the reference or all cases failed, CaseError if all quantities are 0."""
    failed = [row for row in study.rows if row.outcome.failure]
    for row in failed:
        if row.is_reference:
            raise NoSolutionError(
                f"the reference ({row.words}) has no solution, so no {study.difference}s are known:"
                f" {row.outcome.failure}"
            )
    if len(failed) == len(study.rows):
        raise none_solved(source, failed[0].outcome.failure)
    if not study.quantities:
        why, left_out = "0 or not known in the reference", listed(study.left_out)
        if study.plan.cases[0].setup.model.line:
            why = "0, or displacements of a line contact, which a reference_depth makes known"
        raise CaseError(f"nothing to compare, since {why}: {left_out}; name others with --quantity", (), source)


def _print(folder: Path, study: Assessment) -> None:
    console = report_console()
    for table in tables(study, console.width):
        console.print()
        console.print(table)
    for line in (*notes(study), *advice(study)):
        print(line)
    paths = [folder / name for name in (CSV_NAME, HDF5_NAME, PICTURE_NAME)]
    print("written: " + ", ".join(str(path) for path in paths if path.exists()), flush=True)
