"""One case of a sweep: solve it into its result file, and report how that ended."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

from fretsolve.errors import BusyError, CaseError, FretsolveError, NoSolutionError
from fretsolve.result.state import Summary
from fretsolve.result.writer import SAME_COMMAND, HistoryWriter
from fretsolve.simulation.run_to_file import Stop, solve_missing
from fretsolve.sweep.base_case import BaseCase, PreparedCase
from fretsolve.sweep.manifest import Manifest, ManifestRow
from fretsolve.system.signals import EXIT_STOPPED

EXIT_BUG = 70

UNSAVED = 2.0
"""Seconds of work that a kill may cost. A shorter case is written once, which is faster than saving each increment."""


@dataclass(frozen=True)
class SolvedCase:
    """How a run ended. code: that of `fretsolve run`; reason: why there is no solution; increments: in the result."""

    code: int
    reason: str = ""
    increments: int = 0


def solve(
    case: PreparedCase,
    stop: Stop,
    show: Callable[[Summary], None] = lambda summary: None,
    *,
    threads: int = 1,
    pause: float = 0.0,
) -> SolvedCase:
    """Solve what is missing of a case and save it.

    show: called after each increment; pause: seconds for which increments may stay unsaved. Raises FileError.
    """
    with HistoryWriter.open(
        case.out, case.header, resume=True, retry=False, pause=pause, advice=SAME_COMMAND
    ) as writer:
        if writer.complete:  # another process was faster
            return SolvedCase(0)
        try:
            complete = solve_missing(case.setup, writer, stop, threads=threads, show=lambda summary, _: show(summary))
        except NoSolutionError as error:
            return SolvedCase(error.exit_code, " ".join(str(error).splitlines()), len(writer.summaries))
        return SolvedCase(0 if complete else EXIT_STOPPED, "", len(writer.summaries))


@dataclass(frozen=True)
class Report:
    """How the run of a case ended.

    code: that of `fretsolve run`, 0 or 3 if there is a result; busy: another run is writing it. reason: one line, empty
    if there is nothing to say. increments: in the result; seconds: of this run.
    """

    index: int
    code: int
    reason: str = ""
    busy: bool = False
    increments: int = 0
    seconds: float = 0.0

    @property
    def has_result(self) -> bool:
        """Whether the case has a result, even if that is that there is no solution."""
        return self.code in (0, NoSolutionError.exit_code)

    @property
    def wrote_result(self) -> bool:
        """Whether this run wrote the result; a result that was there before adds no increments."""
        return self.code == NoSolutionError.exit_code or (self.code == 0 and self.increments > 0)

    @property
    def of_another(self) -> bool:
        """Whether another process has or had the case and reports it."""
        return self.busy or (self.has_result and not self.wrote_result)


@dataclass(frozen=True)
class CaseRunner:
    """Runs cases of the sweep `manifest`, and reads its case file once."""

    manifest: Manifest

    @cached_property
    def base(self) -> BaseCase:
        """The base case. Raises CaseError, FileError."""
        return BaseCase.read(self.manifest.case, self.manifest.overrides, self.manifest.threads)

    def run(self, row: ManifestRow, stop: Stop) -> Report:
        """Solve what is missing of a case. Errors are in the report and, if there is no result, in the case's note."""
        began = time.perf_counter()
        if self.manifest.result(row).exists():
            return Report(row.index, 0)
        busy = False
        try:
            solved = self._solve(row, stop)
        except BusyError as error:
            solved, busy = SolvedCase(error.exit_code, str(error)), True
        except FretsolveError as error:
            solved = SolvedCase(error.exit_code, " ".join(str(error).splitlines()))
        except MemoryError:
            solved = SolvedCase(CaseError.exit_code, "not enough memory; fewer grid.points are needed")
        except Exception as error:
            if os.environ.get("FRETSOLVE_DEBUG"):
                raise
            text = " ".join(str(error).split())
            solved = SolvedCase(EXIT_BUG, f"internal error: {type(error).__name__}: {text}")
        seconds = time.perf_counter() - began
        report = Report(row.index, solved.code, solved.reason, busy, solved.increments, seconds)
        leave_note(self.manifest, row, report)
        return report

    def _solve(self, row: ManifestRow, stop: Stop) -> SolvedCase:
        case = self.base.prepare(row.settings, self.manifest.results)
        if case.id != row.id:
            message = "has changed since the sweep began; give the command sweep run again"
            raise CaseError(message, (), self.manifest.case)
        return solve(case, stop, threads=self.manifest.threads, pause=UNSAVED)


def leave_note(manifest: Manifest, row: ManifestRow, report: Report) -> None:
    """Write beside the results why a case has none, unless it was merely stopped.

    A full disk stops nobody here.
    """
    note = manifest.note(row)
    with suppress(OSError):
        if report.has_result or (report.code == EXIT_STOPPED and not report.reason):
            note.unlink(missing_ok=True)
        elif not report.busy:
            note.write_text(json.dumps({"exit_code": report.code, "reason": report.reason}), encoding="utf-8")
