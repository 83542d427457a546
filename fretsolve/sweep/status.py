"""Tell how far a sweep is, from its files and from reports on results that were just written."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from fretsolve.errors import FileError
from fretsolve.result.lock import is_locked
from fretsolve.result.parts import contiguous_parts, parts_folder
from fretsolve.result.reader import read_attributes
from fretsolve.sweep.base_case import digest
from fretsolve.sweep.case_run import Report
from fretsolve.sweep.manifest import Manifest, ManifestRow
from fretsolve.system.foreign_files import read_small_text

Status = Literal["complete", "no solution", "running", "stopped", "error", "waiting"]
"""complete, no solution: there is a result; stopped: some increments are saved; error: it ended without a result."""


LARGEST_NOTE = 2**20
"""Bytes of a note, which is a line."""


@dataclass(frozen=True)
class CaseState:
    """Status of a case. exit_code, reason: of an ended case; increments: saved ones of a stopped case."""

    row: ManifestRow
    status: Status
    exit_code: int | None = None
    reason: str = ""
    increments: int = 0

    @property
    def has_result(self) -> bool:
        """True if nothing is left to run."""
        return self.status in ("complete", "no solution")


def states(manifest: Manifest, reports: Iterable[Report] = ()) -> Iterator[CaseState]:
    """Yield the state of every row; reports: on results that were just written and need not be read."""
    found: dict[str, CaseState] = {}
    for report in reports:
        if report.wrote_result:
            row = manifest.rows[report.index]
            found[row.id] = CaseState(row, "no solution" if report.code else "complete", report.code, report.reason)
    for row in manifest.rows:
        if row.id not in found:
            found[row.id] = state_of(manifest, row)
        yield replace(found[row.id], row=row)


def state_of(manifest: Manifest, row: ManifestRow) -> CaseState:
    """Return the state of a case."""
    out = manifest.result(row)
    if manifest.is_finished(row):
        try:
            attributes = own_attributes(manifest, row)
        except FileError as error:
            return CaseState(row, "error", error.exit_code, str(error))
        if attributes["status"] == "complete":
            return CaseState(row, "complete", 0)
        return CaseState(row, "no solution", 3, str(attributes.get("failure", "")))
    folder = parts_folder(out)
    if is_locked(folder):
        return CaseState(row, "running")
    try:
        note = json.loads(read_small_text(manifest.note(row), "a note", LARGEST_NOTE))
        return CaseState(row, "error", int(note["exit_code"]), str(note["reason"]))
    except (OSError, FileError, ValueError, KeyError, TypeError):
        pass
    try:
        increments = sum(part.last - part.first + 1 for part in contiguous_parts(folder))
    except OSError:
        return CaseState(row, "waiting")
    return CaseState(row, "stopped", increments=increments)


def own_attributes(manifest: Manifest, row: ManifestRow) -> dict[str, Any]:
    """Return the root attributes of the result of a case. Raises FileError, also if it is the result of another one."""
    out = manifest.result(row)
    attributes = read_attributes(out)
    if digest(attributes) != row.id:
        raise FileError("is the result of another case", out)
    return attributes


def missing(manifest: Manifest, rows: Iterable[ManifestRow] | None = None) -> list[ManifestRow]:
    """Return the cases that lack a file, each once; a file appears only when it is whole."""
    return [row for row in (manifest.unique if rows is None else rows) if not manifest.is_finished(row)]


def has_ended(manifest: Manifest, row: ManifestRow) -> bool:
    """Return whether a case has its files, or a note of why it has none."""
    return manifest.is_finished(row) or manifest.note(row).exists()


def is_taken(manifest: Manifest, row: ManifestRow) -> bool:
    """Return whether a case has ended, or a process is running it."""
    return has_ended(manifest, row) or is_locked(parts_folder(manifest.result(row)))


def counted(found: Sequence[CaseState]) -> str:
    """Return how many cases there are, and how many in each status that occurs, as a line."""
    numbers = Counter(one.status for one in found)
    parts = ", ".join(f"{numbers[status]} {status}" for status in get_args(Status) if status in numbers)
    return f"{len(found)} case{'s' if len(found) > 1 else ''}: {parts}"
