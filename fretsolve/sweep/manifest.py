"""The manifest of a sweep: every case with its settings and the name of its result, for all engines alike."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fretsolve.errors import CaseError, FileError
from fretsolve.sweep.points import Setting
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
    settings: tuple[Setting, ...]
    seconds: float

    @property
    def words(self) -> str:
        """The settings, for a sentence."""
        return ", ".join(f"{setting.key}={setting.value}" for setting in self.settings)


@dataclass(frozen=True)
class Manifest:
    """What a sweep is, in its `folder`. overrides: common to all cases, as `--set` takes them.

    quantities: to collect, ``NAME`` or ``NAME@STAGE``. memory: estimate for the largest case (bytes).
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

    @property
    def keys(self) -> tuple[str, ...]:
        """The varied keys."""
        return tuple(dict.fromkeys(setting.key for row in self.rows for setting in row.settings))

    @cached_property
    def unique(self) -> tuple[ManifestRow, ...]:
        """One row for each result: equal cases are run once."""
        return tuple({row.id: row for row in reversed(self.rows)}.values())[::-1]

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / RESULTS_NAME

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
    values = {
        "format": FORMAT,
        "sweep": str(manifest.sweep),
        "title": manifest.title,
        "case": str(manifest.case),
        "overrides": manifest.overrides,
        "quantities": manifest.quantities,
        "threads": manifest.threads,
        "memory": manifest.memory,
        "cases": [
            {
                "index": row.index,
                "id": row.id,
                "result": f"{RESULTS_NAME}/{row.id}.h5",
                "seconds": row.seconds,
                "settings": {setting.key: setting.value for setting in row.settings},
            }
            for row in manifest.rows
        ],
    }
    path = manifest.folder / MANIFEST_NAME
    with writing(path):
        manifest.results.mkdir(parents=True, exist_ok=True)
        atomic_files.write_text(path, json.dumps(values, indent=1, ensure_ascii=False) + "\n")


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
            tuple(_row(case) for case in values["cases"]),
        )
    except OSError as error:
        needed = "a folder made by sweep run is needed"
        raise FileError(f"cannot be read: {reason_of(error)}; {needed}", path) from None
    except (ValueError, KeyError, TypeError) as error:
        raise FileError(f"not the manifest of a sweep: {error}", path) from error


def _row(values: dict[str, Any]) -> ManifestRow:
    settings = tuple(Setting(key, value) for key, value in values["settings"].items())
    return ManifestRow(values["index"], values["id"], settings, values["seconds"])


def index_list(indices: Sequence[int]) -> str:
    """Write numbers as ``0-3,7,9-12``, the form of Slurm's --array."""
    parts: list[str] = []
    numbers = sorted(set(indices))
    for place, number in enumerate(numbers):
        if place and number == numbers[place - 1] + 1:
            parts[-1] = parts[-1].partition("-")[0] + f"-{number}"
        else:
            parts.append(str(number))
    return ",".join(parts)
