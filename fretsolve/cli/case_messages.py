"""Print how the cases of a sweep or study go: before they run, as each ends, and at the end."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from fretsolve.errors import NoSolutionError, printable
from fretsolve.result.state import Summary
from fretsolve.sweep.manifest import CaseState, Manifest, ManifestRow, counted
from fretsolve.sweep.plan import PreparedCase
from fretsolve.sweep.study.plan import words
from fretsolve.system.progress import key_value_line, print_error_line, print_warnings, progress_bar


class CaseMessages:
    """Print warnings, and unless `quiet` all else: a line per case that ends, or a bar on a terminal if `bar`.

    todo: cases without a result; runs: how many cases are reported, by default the cases in `todo`.
    """

    def __init__(
        self,
        manifest: Manifest,
        todo: Sequence[ManifestRow],
        runs: int | None = None,
        *,
        quiet: bool = False,
        bar: bool = False,
    ):
        self.manifest, self.runs, self.quiet = manifest, len(todo) if runs is None else runs, quiet
        self.expected = {row.id: row.seconds for row in todo}
        self.ended, self.before = 0, 0.0
        self.warned: set[str] = set()
        self.bar = None
        if bar and not quiet and sys.stdout.isatty():
            self.bar = progress_bar(f"run {{task.fields[run]}}/{self.runs}", "{task.fields[detail]}")
            self.bar.add_task("", total=sum(self.expected.values()), run=1, detail="")

    def start(self, source: Path, folder: Path, warnings: Iterable[str], more: Iterable[str] = ()) -> None:
        """Print the warnings about the file `source`, what is about to be run, and the lines `more`."""
        print_warnings(source, *warnings)
        if self.quiet:
            return
        count, unique, left = len(self.manifest.rows), len(self.manifest.unique), len(self.expected)
        equal = f", {unique} of them different" if unique < count else ""
        there = f", {unique - left} done already" if left < unique else ""
        cases = f"{count} case{'s' if count > 1 else ''} of {', '.join(self.manifest.keys)}{equal}{there}"
        lines = (self.manifest.title, f"results: {folder}", cases, *more)
        print(*map(printable, lines), sep="\n", flush=True)

    def progress(self) -> AbstractContextManager[object]:
        """Show the bar, if there is one, within a block."""
        return self.bar or nullcontext()

    def increment(self, case: PreparedCase, summary: Summary) -> None:
        """Show an increment that is saved."""
        if self.bar is not None:
            done, increments = summary.step + 1, case.setup.load_path.increments
            detail = printable(f"{words(case.settings, line=case.setup.model.line)}: increment {done}/{increments}")
            completed = self.before + self.expected.get(case.id, 0.0) * done / increments
            self.bar.update(self.bar.task_ids[0], completed=completed, detail=detail)

    def case(self, name: str, **values: Any) -> None:
        """Show that the case whose result is `name` has ended; values: what the line says of the case."""
        self.ended += 1
        self.before += self.expected.pop(name, 0.0)
        if self.bar is not None:
            self.bar.update(self.bar.task_ids[0], completed=self.before, run=min(self.ended + 1, self.runs))
        elif not self.quiet:
            key_value_line(run=self.ended, runs=self.runs, **values)

    def warn(self, result: Path, texts: Iterable[str]) -> None:
        """Print warnings about a result, each text once for all results."""
        for text in texts:
            if text not in self.warned:
                print_warnings(result, text)
            self.warned.add(text)

    def end(self, states: Sequence[CaseState]) -> None:
        """Print how many cases have which status, and what to do about cases without a result."""
        if not self.quiet:
            print(counted(states), flush=True)
            if self.manifest.missing():
                print_error_line("the same command goes on with what is missing")


def none_solved(source: Path, reason: str) -> NoSolutionError:
    """Return the error if no case of the file `source` has a solution."""
    error = NoSolutionError(f"none of the cases has a solution: {reason}")
    error.file = source
    return error
