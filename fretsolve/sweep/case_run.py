"""Solve cases of a sweep or study into their result files, and report how that ended."""

from __future__ import annotations

import itertools
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from fretsolve.case.loading import read_case
from fretsolve.elastic.kernels import load
from fretsolve.errors import EXIT_BUG, BusyError, CaseError, FretsolveError, NoSolutionError
from fretsolve.post.names import crack_path, fatigue_path, stress_path
from fretsolve.result import open_result
from fretsolve.result.state import Summary
from fretsolve.result.writer import NOTHING_SHARED, SAME_COMMAND, HistoryWriter
from fretsolve.simulation.accuracy.rounds import Round
from fretsolve.simulation.accuracy.saved_rounds import begun_round, solve_rounds
from fretsolve.simulation.run_to_file import Stop, solve_missing
from fretsolve.simulation.simulation import run
from fretsolve.sweep.beginnings import files_of
from fretsolve.sweep.manifest import Manifest, ManifestRow, RunReport, is_finished
from fretsolve.sweep.plan import BaseCase, PreparedCase
from fretsolve.system import atomic_files
from fretsolve.system.environment import compiler_asked
from fretsolve.system.signals import EXIT_STOPPED

Show = Callable[[PreparedCase, Summary], None]


def solve(
    case: PreparedCase,
    index: int,
    stop: Stop,
    show: Callable[[Summary], None] = lambda summary: None,
    *,
    threads: int = 1,
    pause: float = 0.0,
    shared: Mapping[int, Path] = NOTHING_SHARED,
) -> RunReport:
    """Solve what is missing of case `index`, save it and report how that ended.

    show: called after each increment; pause: seconds for which increments may stay unsaved; shared: files
    of beginnings, see `HistoryWriter.open`. Raises FileError.
    """
    began, code, reason = time.perf_counter(), 0, ""
    begun = begun_round(case.first, case.out, case.header_of)
    options: dict[str, Any] = {"retry": False, "pause": pause, "advice": SAME_COMMAND, "shared": shared}
    in_rounds = begun.asked.solver.accuracy is not None
    with HistoryWriter.open(case.out, case.header_of(begun), resume=True, in_rounds=in_rounds, **options) as writer:

        def solve_round(current: Round) -> bool:
            tell = lambda summary, _: show(summary)  # noqa: E731
            return solve_missing(current.setup, writer, stop, threads=threads, show=tell)

        solved = None
        try:
            if not writer.complete:
                solved = solve_rounds(writer, begun, case.header_of, solve_round)
                code = EXIT_STOPPED if solved is None else 0
        except NoSolutionError as error:
            code, reason = error.exit_code, _one_line(error)
        if code == 0:
            write_side_outputs(case, writer, threads)
        if writer.complete:  # another process was faster, or was ended before it had written the side outputs
            return RunReport(index, 0)
        seconds, notes = time.perf_counter() - began, tuple(writer.notes)
        if solved is not None and (reached := solved[1]) is not None and not reached.met:
            notes += (str(reached),)
        return RunReport(index, code, reason, increments=writer.increments, seconds=seconds, notes=notes)


def write_side_outputs(case: PreparedCase, writer: HistoryWriter, threads: int = 1) -> None:
    """Write the side outputs that the case asks for and that are missing; writer: of its result.

    Raises CaseError, FileError.
    """
    if is_finished(case.out, case.beside):
        return
    from fretsolve.post.crack.crack_file import write_case_crack
    from fretsolve.post.fatigue.fatigue_file import write_case_fatigue
    from fretsolve.post.stress.stress_file import write_case_stress

    output, folder = case.setup.case.output, writer.working_folder()
    with open_result(case.out) as result:
        if output.stress is not None and not stress_path(case.out).exists():
            write_case_stress(result, output.stress, threads, folder)
        if output.fatigue is not None and not fatigue_path(case.out).exists():
            write_case_fatigue(result, case.setup.case, threads, folder)
        if output.crack is not None and not crack_path(case.out).exists():
            write_case_crack(result, case.setup.case, folder)


def run_serially(
    cases: Sequence[PreparedCase], stop: Stop, show: Show = lambda case, summary: None
) -> Iterator[RunReport]:
    """Run `cases`, unless their results are there; yield a report as each ends. A stop saves the case under way.

    show: called after each saved increment. Raises FileError.
    """
    missing = [case for case in cases if not is_finished(case.out, case.beside)]
    warm: set[object] = set()
    for index, case in enumerate(cases):
        if is_finished(case.out, case.beside):
            yield RunReport(index, 0)
            continue
        if _kind(case) not in warm and not stop.requested:
            warm.add(_kind(case))
            _warm_up([other for other in missing if _kind(other) == _kind(case)], stop)
        report = RunReport(index, EXIT_STOPPED) if stop.requested else solve(case, index, stop, partial(show, case))
        if report.code == EXIT_STOPPED:
            return
        yield report


def _kind(case: PreparedCase) -> object:
    return case.setup.grid.shape, case.setup.model.terms


def _warm_up(cases: Sequence[PreparedCase], stop: Stop) -> None:
    """Compile the kernels and plan the transforms of `cases`, which are of one kind, so that no cost includes that.

    That takes up to 3 increments of the cheapest one, which call all solvers and whose results are dropped.
    """
    cheapest = min(cases, key=lambda case: (case.expected.seconds, -case.setup.case.solver.tolerance))
    with suppress(FretsolveError):
        for state in itertools.islice(run(cheapest.setup), 3):
            if stop.requested or not cheapest.setup.model.has_shear or state.summary.iterations_tangential:
                break


@dataclass(frozen=True)
class CaseRunner:
    """Runs cases of the sweep `manifest`, and reads its case file once."""

    manifest: Manifest

    @cached_property
    def base(self) -> BaseCase:
        """The base case. Raises CaseError, FileError."""
        manifest = self.manifest
        wanted = manifest.compiled and compiler_asked() is not False
        compiled = None if wanted is None else load(wanted).compiled
        return BaseCase.of(read_case(manifest.case), manifest.overrides, manifest.threads, compiled=compiled)

    def run(self, row: ManifestRow, stop: Stop) -> RunReport:
        """Solve what is missing of a case. Errors are in the report and, if there is no result, in the case's note."""
        began = time.perf_counter()
        if self.manifest.is_finished(row):
            return RunReport(row.index, 0)
        try:
            case = self.base.prepare(row.settings, self.manifest.results)
            if case.id != row.id:
                message = "has changed since the sweep began; give the command sweep run again"
                raise CaseError(message, (), self.manifest.case)
            # A kill may cost 2 s of work. A shorter case is written once, which is faster.
            shared = files_of(row.shared, self.manifest.folder)
            report = solve(case, row.index, stop, threads=self.manifest.threads, pause=2.0, shared=shared)
        except FretsolveError as error:
            report = RunReport(row.index, error.exit_code, _one_line(error), isinstance(error, BusyError))
        except MemoryError:
            report = RunReport(row.index, CaseError.exit_code, "not enough memory; fewer grid.points are needed")
        except Exception as error:
            if os.environ.get("FRETSOLVE_DEBUG"):
                raise
            report = RunReport(row.index, EXIT_BUG, f"internal error: {type(error).__name__}: {_one_line(error)}")
        report = replace(report, seconds=time.perf_counter() - began)
        leave_note(self.manifest, row, report)
        return report


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def leave_note(manifest: Manifest, row: ManifestRow, report: RunReport) -> None:
    """Write beside the results why a case has none, unless it was merely stopped. A full disk is no error here."""
    note = manifest.note(row)
    with suppress(OSError):
        if report.has_result or (report.code == EXIT_STOPPED and not report.reason):
            note.unlink(missing_ok=True)
        elif not report.busy:
            with atomic_files.new_file(note, durable=False) as file:
                file.write(json.dumps({"exit_code": report.code, "reason": report.reason}).encode())
