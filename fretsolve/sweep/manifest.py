"""The manifest of a sweep: every case with its settings and the name of its result, and how far each case is."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, Field, ValidationError

from fretsolve.errors import CaseError, FileError, NoSolutionError, dotted, shortened
from fretsolve.result.lock import is_locked
from fretsolve.result.parts import contiguous_parts, parts_folder
from fretsolve.result.reader import read_attributes
from fretsolve.sweep.beginnings import FOLDER_NAME as BEGINNINGS_NAME
from fretsolve.sweep.beginnings import Beginning
from fretsolve.system import atomic_files
from fretsolve.system.files import read_small_text, reason_of, reported, require_utf8, writing

MANIFEST_NAME = "manifest.json"
RESULTS_NAME = "results"
FORMAT = 1
OF_A_CASE = re.compile(r"[0-9a-f]{16}\.")
"""Beginning of the names of files of a case."""

_OWN_NAME = re.compile(
    r"(results|beginnings|slurm|table\.csv|table\.h5)$|(manifest\.json|table\.csv|table\.h5)\..*tmp$"
)
"""Files and folders of a sweep whose manifest is missing, or is being written."""

CaseId = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
"""The digest of a case, which names its files."""

SideOutput = Literal["stress", "fatigue", "crack"]
"""What a case may ask for beside its result NAME.h5, in the file NAME.stress.h5, NAME.fatigue.h5 or NAME.crack.h5."""

Status = Literal["complete", "no solution", "running", "stopped", "error", "waiting"]
"""complete, no solution: there is a result; stopped: some increments are saved; error: it ended without a result."""


@dataclass(frozen=True)
class ManifestRow:
    """One case. index: its place in the sweep, from 0; id: names its result, equal for equal cases.

    seconds: estimated time; shared: beginnings that other cases have as well; beside: its side outputs.
    """

    index: int
    id: CaseId
    settings: Mapping[str, str]
    seconds: float
    shared: tuple[Beginning, ...] = ()
    beside: tuple[SideOutput, ...] = ()

    @property
    def words(self) -> str:
        """The settings, for a sentence."""
        return ", ".join(f"{key}={value}" for key, value in self.settings.items())


@dataclass(frozen=True)
class Manifest:
    """All that the engines know of a sweep or study. overrides: common to all cases, as `--set` takes them.

    quantities: to collect, ``NAME`` or ``NAME@STAGE``; memory: estimate for the largest case (bytes); results_name: the
    folder of the results inside `folder`, which a study leaves empty; compiled: whether the cases together pay for
    loading the compiled kernels, None where each case decides.
    """

    folder: Path
    sweep: Path
    title: str
    case: Path
    overrides: tuple[str, ...]
    quantities: tuple[str, ...]
    threads: int
    memory: float
    rows: tuple[ManifestRow, ...] = field(repr=False)
    results_name: str = RESULTS_NAME
    compiled: bool | None = None

    @property
    def keys(self) -> tuple[str, ...]:
        """The varied keys."""
        return tuple(dict.fromkeys(key for row in self.rows for key in row.settings))

    @cached_property
    def unique(self) -> tuple[ManifestRow, ...]:
        """One row for each result: equal cases are run once."""
        return tuple({row.id: row for row in reversed(self.rows)}.values())[::-1]

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / self.results_name

    def result(self, row: ManifestRow) -> Path:
        """Return the result file of a case."""
        return self.results / f"{row.id}.h5"

    def note(self, row: ManifestRow) -> Path:
        """Return the file that says why a case has ended without a result."""
        return self.results / f"{row.id}.note"

    def is_finished(self, row: ManifestRow) -> bool:
        """Return whether nothing of a case is left to run: its result is there, with its side outputs."""
        return is_finished(self.result(row), row.beside)

    def has_ended(self, row: ManifestRow) -> bool:
        """Return whether a case has its files, or a note of why it has none."""
        return self.is_finished(row) or self.note(row).exists()

    def is_taken(self, row: ManifestRow) -> bool:
        """Return whether a case has ended, or a process is running it."""
        return self.has_ended(row) or is_locked(parts_folder(self.result(row)))

    def missing(self, rows: Iterable[ManifestRow] | None = None) -> list[ManifestRow]:
        """Return the cases that lack a file, each once; a file appears only when it is whole."""
        return [row for row in (self.unique if rows is None else rows) if not self.is_finished(row)]

    def own_attributes(self, row: ManifestRow) -> dict[str, Any]:
        """Return the root attributes of the result of a case. Raises FileError, also if another case has it."""
        out = self.result(row)
        attributes = read_attributes(out)
        if digest(attributes) != row.id:
            raise FileError("is the result of another case", out)
        return attributes


def is_finished(out: Path, beside: Sequence[str]) -> bool:
    """Return whether a result is there, with its side outputs unless there is no solution."""
    if not out.exists():
        return False
    if all(out.with_suffix(f".{name}.h5").exists() for name in beside):
        return True
    try:
        return bool(read_attributes(out)["status"] != "complete")
    except FileError:
        return True  # whoever reads it reports the damage


def digest(attributes: Mapping[str, Any]) -> str:
    """Return a digest of all that the outcome of a run depends on, which title and expected values do not change.

    attributes: of the run's header or result; what the rounds of an accuracy pick does not count.
    """
    effective = json.loads(attributes["effective_case"])
    for key in json.loads(attributes["provenance"]).get("picked_keys", ()):
        group, name = key.split(".")
        effective[group].pop(name, None)
    case = {name: value for name, value in effective.items() if name not in ("title", "expect")}
    rest = [attributes.get(name) for name in ("inputs", "fretsolve_version", "format_version")]
    identity = json.dumps([case, *rest], sort_keys=True)
    return hashlib.sha256(identity.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class RunReport:
    """End of the run of a case.

    code: the exit code of `fretsolve run`, 0 or 3 if there is a result; busy: another run is writing it. reason: one
    line, empty if there is nothing to say. increments: in the result; seconds: of this run; notes: warnings.
    """

    index: int
    code: int
    reason: str = ""
    busy: bool = False
    increments: int = 0
    seconds: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def has_result(self) -> bool:
        """True if the case has a result, even one that says that there is no solution."""
        return self.code in (0, NoSolutionError.exit_code)

    @property
    def wrote_result(self) -> bool:
        """True if this run wrote the result; a result that was there before adds no increments."""
        return self.code == NoSolutionError.exit_code or (self.code == 0 and self.increments > 0)

    @property
    def of_another(self) -> bool:
        """True if another process has or had the case and reports it."""
        return self.busy or (self.has_result and not self.wrote_result)


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


def states(manifest: Manifest, reports: Iterable[RunReport] = ()) -> Iterator[CaseState]:
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
    """Return the state of a case, from its files."""
    if manifest.is_finished(row):
        try:
            attributes = manifest.own_attributes(row)
            if attributes["status"] == "complete":
                _require_side_outputs(manifest.result(row), row.beside)
                return CaseState(row, "complete", 0)
        except FileError as error:
            return CaseState(row, "error", error.exit_code, str(error))
        return CaseState(row, "no solution", 3, str(attributes.get("failure", "")))
    folder = parts_folder(manifest.result(row))
    if is_locked(folder):
        return CaseState(row, "running")
    with suppress(OSError, FileError, ValueError, KeyError, TypeError):
        # a note is a line
        note = json.loads(read_small_text(manifest.note(row), "a note", 2**20))
        return CaseState(row, "error", int(note["exit_code"]), str(note["reason"]))
    try:
        increments = sum(part.last - part.first + 1 for part in contiguous_parts(folder))
    except OSError:
        return CaseState(row, "waiting")
    return CaseState(row, "stopped", increments=increments)


def _require_side_outputs(out: Path, beside: Sequence[SideOutput]) -> None:
    """Raise FileError if the header of a file beside a result cannot be read."""
    if beside:
        from fretsolve.post.stress.computed_file import opened_beside  # few sweeps have such files

        for kind in beside:
            with opened_beside(out.with_suffix(f".{kind}.h5"), kind, None):
                pass


def counted(found: Sequence[CaseState]) -> str:
    """Return how many cases there are, and how many in each status that occurs, as a line."""
    numbers = Counter(one.status for one in found)
    parts = ", ".join(f"{numbers[status]} {status}" for status in get_args(Status) if status in numbers)
    return f"{len(found)} case{'s' if len(found) > 1 else ''}: {parts}"


def index_list(indices: Sequence[int]) -> str:
    """Write numbers as ``0-3,7,9-12``, the form of Slurm's --array."""
    groups = itertools.groupby(enumerate(sorted(set(indices))), lambda pair: pair[1] - pair[0])
    runs = [[number for _, number in group] for _, group in groups]
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def require_own(folder: Path, sweep: Path) -> None:
    """Raise CaseError if `folder` holds another sweep, whose file still exists. An edited file is the same sweep.

    Raises FileError if a file or a link that no sweep has written is in the way.
    """
    require_no_link(folder)
    if not os.path.lexists(folder / MANIFEST_NAME):
        require_own_names(folder, _OWN_NAME, "no sweep")
        require_own_names(folder / RESULTS_NAME, OF_A_CASE, "no sweep")
        return
    try:
        there = read_manifest(folder).sweep
    except FileError as error:
        raise FileError(f"{error.message}; give another folder with -o, or remove this file", error.file) from error
    with suppress(OSError):  # a sweep file is gone
        if not there.samefile(sweep):
            raise CaseError(f"holds the sweep of {there}; give another folder with -o, or remove this one", (), folder)


def require_no_link(folder: Path) -> None:
    """Raise FileError if a folder into which the cases of a sweep write is a link."""
    for name in (RESULTS_NAME, BEGINNINGS_NAME):
        if (folder / name).is_symlink():
            message = "is a link, which a sweep does not follow; give another folder with -o, or remove it"
            raise FileError(message, folder / name)


def require_own_names(folder: Path, own: re.Pattern[str], of_what: str) -> None:
    """Raise FileError if a file in `folder` has a name that is not one of `own`; hidden files do not count.

    of_what: such as "no sweep", which would give a file such a name.
    """
    with reported("cannot be read", folder):
        names = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    for name in sorted(names):
        if not (name.startswith(".") or own.match(name)):
            message = f"holds {name}, which {of_what} has written"
            raise FileError(f"{message}; give another folder with -o, one that is new or empty", folder)


class _Stored(BaseModel):
    """The manifest's file, whose keys have the names of the fields of `Manifest`."""

    format: int
    sweep: Path
    title: str
    case: Path
    overrides: tuple[str, ...]
    quantities: tuple[str, ...]
    threads: Annotated[int, Field(ge=1, le=10**6)]
    memory: float
    compiled: bool | None
    cases: Annotated[tuple[ManifestRow, ...], Field(min_length=1)]


def write_manifest(manifest: Manifest) -> None:
    """Write the manifest into its folder, in one step; make the folder if need be. Raises FileError."""
    common = {name: getattr(manifest, name) for name in _Stored.model_fields if name not in ("format", "cases")}
    cases = [{"result": f"{RESULTS_NAME}/{row.id}.h5", **asdict(row)} for row in manifest.rows]
    values = {"format": FORMAT, **common, "cases": cases}
    path = manifest.folder / MANIFEST_NAME
    text = json.dumps(values, indent=1, ensure_ascii=False, default=str) + "\n"
    require_utf8(text, path)
    with writing(path):
        manifest.results.mkdir(parents=True, exist_ok=True)
        atomic_files.write_text(path, text)


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest in `folder`. Raises FileError."""
    path = folder / MANIFEST_NAME
    try:
        found = _Stored.model_validate_json(read_small_text(path, "the manifest of a sweep"), strict=True)
        if found.format != FORMAT:
            raise FileError(f"has format {found.format}; this fretsolve reads format {FORMAT}", path)
        if [case.index for case in found.cases] != list(range(len(found.cases))):
            raise ValueError("the cases are not numbered from 0 on")
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = f"{dotted(first['loc'])}: " if first["loc"] else ""
        raise FileError(f"not the manifest of a sweep: {place}{shortened(first['msg'])}", path) from None
    except OSError as error:
        needed = "a folder made by sweep run is needed"
        raise FileError(f"cannot be read: {reason_of(error)}; {needed}", path) from None
    except ValueError as error:
        raise FileError(f"not the manifest of a sweep: {error}", path) from error
    common = {name: getattr(found, name) for name in _Stored.model_fields if name not in ("format", "cases")}
    return Manifest(folder, rows=found.cases, **common)
