"""The manifest of a sweep: every case with its settings and the name of its result."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from fretsolve.errors import CaseError, FileError
from fretsolve.system import atomic_files
from fretsolve.system.files import reason_of, writing

MANIFEST_NAME = "manifest.json"
RESULTS_NAME = "results"
FORMAT = 1


@dataclass(frozen=True)
class ManifestRow:
    """One case. index: its place in the sweep, from 0; id: names its result, the same for equal cases.

    seconds: estimated time.
    """

    index: int
    id: str
    settings: Mapping[str, str]
    seconds: float

    @property
    def words(self) -> str:
        """The settings, for a sentence."""
        return ", ".join(f"{key}={value}" for key, value in self.settings.items())


@dataclass(frozen=True)
class Manifest:
    """All that the engines know of a sweep or study. overrides: common to all cases, as `--set` takes them.

    quantities: to collect, ``NAME`` or ``NAME@STAGE``; memory: estimate for the largest case (bytes); results_name: the
    folder of the results inside `folder`, which a study leaves empty.
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


def require_own(folder: Path, sweep: Path) -> None:
    """Raise CaseError if `folder` holds another sweep, whose file still exists. An edited file is the same sweep."""
    try:
        there = read_manifest(folder).sweep
        other = not there.samefile(sweep)
    except (FileError, OSError):  # there is no manifest, or a sweep file is gone
        return
    if other:
        raise CaseError(f"holds the sweep of {there}; give another folder with -o, or remove this one", (), folder)


def write_manifest(manifest: Manifest) -> None:
    """Write the manifest into its folder, in one step; make the folder if need be. Raises FileError."""
    names = ("sweep", "title", "case", "overrides", "quantities", "threads", "memory")
    common = {name: getattr(manifest, name) for name in names}
    cases = [{"result": f"{RESULTS_NAME}/{row.id}.h5", **vars(row)} for row in manifest.rows]
    values = {"format": FORMAT, **common, "cases": cases}
    path = manifest.folder / MANIFEST_NAME
    with writing(path):
        manifest.results.mkdir(parents=True, exist_ok=True)
        atomic_files.write_text(path, json.dumps(values, indent=1, ensure_ascii=False, default=str) + "\n")


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest in `folder`. Raises FileError."""
    path = folder / MANIFEST_NAME
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        if values["format"] != FORMAT:
            raise FileError(f"has format {values['format']}; this fretsolve reads format {FORMAT}", path)
        return Manifest(
            folder,
            Path(values["sweep"]),
            values["title"],
            Path(values["case"]),
            tuple(values["overrides"]),
            tuple(values["quantities"]),
            values["threads"],
            values["memory"],
            tuple(
                ManifestRow(case["index"], case["id"], case["settings"], case["seconds"]) for case in values["cases"]
            ),
        )
    except OSError as error:
        needed = "a folder made by sweep run is needed"
        raise FileError(f"cannot be read: {reason_of(error)}; {needed}", path) from None
    except (ValueError, KeyError, TypeError) as error:
        raise FileError(f"not the manifest of a sweep: {error}", path) from error


def index_list(indices: Sequence[int]) -> str:
    """Write numbers as ``0-3,7,9-12``, the form of Slurm's --array."""
    groups = itertools.groupby(enumerate(sorted(set(indices))), lambda pair: pair[1] - pair[0])
    runs = [[number for _, number in group] for _, group in groups]
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)
