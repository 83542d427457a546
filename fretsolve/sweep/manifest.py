"""The manifest of a sweep: every case with its settings and the name of its result."""

from __future__ import annotations

import itertools
import json
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from fretsolve.errors import CaseError, FileError, dotted, shortened
from fretsolve.result.reader import read_attributes
from fretsolve.sweep.beginnings import FOLDER_NAME as BEGINNINGS_NAME
from fretsolve.sweep.beginnings import Beginning
from fretsolve.system import atomic_files
from fretsolve.system.files import reason_of, reported, require_utf8, writing
from fretsolve.system.foreign_files import read_small_text

MANIFEST_NAME = "manifest.json"
RESULTS_NAME = "results"
FORMAT = 1
OF_A_CASE = re.compile(r"[0-9a-f]{16}\.")
"""Beginning of the names of files of a case."""

_OWN_NAME = re.compile(
    r"(results|beginnings|slurm|table\.csv|table\.h5)$|(manifest\.json|table\.csv|table\.h5)\..*tmp$"
)
"""Files and folders of a sweep whose manifest is missing, or is being written."""


@dataclass(frozen=True)
class ManifestRow:
    """One case. index: its place in the sweep, from 0; id: names its result, the same for equal cases.

    seconds: estimated time; shared: beginnings that other cases have as well; beside: names of the files that it has
    beside a complete result.
    """

    index: int
    id: str
    settings: Mapping[str, str]
    seconds: float
    shared: tuple[Beginning, ...] = ()
    beside: tuple[str, ...] = ()

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

    def is_finished(self, row: ManifestRow) -> bool:
        """Return whether nothing of a case is left to run: its result is there, with the files beside it."""
        return is_finished(self.result(row), row.beside)

    def note(self, row: ManifestRow) -> Path:
        """Return the file that says why a case has ended without a result."""
        return self.results / f"{row.id}.note"


def is_finished(out: Path, beside: Sequence[str]) -> bool:
    """Return whether a result is there, with the files beside it unless there is no solution."""
    if not out.exists():
        return False
    if all(out.with_suffix(f".{name}.h5").exists() for name in beside):
        return True
    try:
        return bool(read_attributes(out)["status"] != "complete")
    except FileError:
        return True  # whoever reads it reports the damage


class _StoredBeginning(BaseModel):
    """A beginning in the manifest's file. Its key becomes the name of a file, too."""

    model_config = ConfigDict(strict=True)
    key: Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
    increments: Annotated[int, Field(ge=1)]


class _StoredRow(BaseModel):
    """A case in the manifest's file. Its id becomes the name of a file, so it is nothing but a digest."""

    model_config = ConfigDict(strict=True)
    index: int
    id: Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
    settings: dict[str, str]
    seconds: float
    shared: tuple[_StoredBeginning, ...]
    beside: tuple[Literal["stress", "fatigue"], ...]


class _Stored(BaseModel):
    """The manifest's file."""

    model_config = ConfigDict(strict=True)
    format: int
    sweep: str
    title: str
    case: str
    overrides: tuple[str, ...]
    quantities: tuple[str, ...]
    threads: Annotated[int, Field(ge=1, le=10**6)]
    memory: float
    compiled: bool | None
    cases: Annotated[tuple[_StoredRow, ...], Field(min_length=1)]


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
    other = False
    with suppress(OSError):  # a sweep file is gone
        other = not there.samefile(sweep)
    if other:
        raise CaseError(f"holds the sweep of {there}; give another folder with -o, or remove this one", (), folder)


def require_no_link(folder: Path) -> None:
    """Raise FileError if one of the folders in that of a sweep, into which its cases write, is a link."""
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


def write_manifest(manifest: Manifest) -> None:
    """Write the manifest into its folder, in one step; make the folder if need be. Raises FileError."""
    names = ("sweep", "title", "case", "overrides", "quantities", "threads", "memory", "compiled")
    common = {name: getattr(manifest, name) for name in names}
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
        text = read_small_text(path, "the manifest of a sweep")
        values = _Stored.model_validate_json(text)
        if values.format != FORMAT:
            raise FileError(f"has format {values.format}; this fretsolve reads format {FORMAT}", path)
        if [case.index for case in values.cases] != list(range(len(values.cases))):
            raise ValueError("the cases are not numbered from 0 on")
        return Manifest(
            folder,
            Path(values.sweep),
            values.title,
            Path(values.case),
            values.overrides,
            values.quantities,
            values.threads,
            values.memory,
            tuple(map(_row, values.cases)),
            compiled=values.compiled,
        )
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = f"{dotted(first['loc'])}: " if first["loc"] else ""
        raise FileError(f"not the manifest of a sweep: {place}{shortened(first['msg'])}", path) from None
    except OSError as error:
        needed = "a folder made by sweep run is needed"
        raise FileError(f"cannot be read: {reason_of(error)}; {needed}", path) from None
    except ValueError as error:
        raise FileError(f"not the manifest of a sweep: {error}", path) from error


def _row(case: _StoredRow) -> ManifestRow:
    shared = tuple(Beginning(one.key, one.increments) for one in case.shared)
    return ManifestRow(case.index, case.id, case.settings, case.seconds, shared, case.beside)


def index_list(indices: Sequence[int]) -> str:
    """Write numbers as ``0-3,7,9-12``, the form of Slurm's --array."""
    groups = itertools.groupby(enumerate(sorted(set(indices))), lambda pair: pair[1] - pair[0])
    runs = [[number for _, number in group] for _, group in groups]
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)
