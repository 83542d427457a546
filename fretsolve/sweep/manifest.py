"""The manifest of a sweep: every case with its settings and the name of its result, for all engines alike."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fretsolve.errors import CaseError, FileError
from fretsolve.study.variation import Setting
from fretsolve.system import atomic_files
from fretsolve.system.files import reason_of

MANIFEST_NAME = "manifest.json"
RESULTS_NAME = "results"
FORMAT = 1


@dataclass(frozen=True)
class Row:
    """One case. index: its place in the sweep, from 0; id: what names its result, the same for equal cases.

    seconds: estimated.
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

    quantities: what is collected, ``NAME`` or ``NAME@STAGE``. memory: estimated, of the largest case (bytes).
    """

    folder: Path
    sweep: Path
    title: str
    case: Path
    overrides: tuple[str, ...]
    quantities: tuple[str, ...]
    threads: int
    memory: float
    rows: tuple[Row, ...] = field(repr=False)

    @property
    def keys(self) -> tuple[str, ...]:
        """The varied keys."""
        return tuple(dict.fromkeys(setting.key for row in self.rows for setting in row.settings))

    @cached_property
    def unique(self) -> tuple[Row, ...]:
        """One row for each result: equal cases are run once."""
        return tuple({row.id: row for row in reversed(self.rows)}.values())[::-1]

    def row(self, index: int, identity: str) -> Row:
        """The case that was named so when it was given out. Raises CaseError where the sweep is another one by now."""
        if index >= len(self.rows) or self.rows[index].id != identity:
            message = f"case {index} is another one than when the run began; give the command sweep run again"
            raise CaseError(message, (), self.folder / MANIFEST_NAME)
        return self.rows[index]

    def result(self, row: Row) -> Path:
        """The result file of a case."""
        return self.folder / RESULTS_NAME / f"{row.id}.h5"

    def note(self, row: Row) -> Path:
        """Where it says why a case has ended without a result."""
        return self.folder / RESULTS_NAME / f"{row.id}.note"


def require_own(folder: Path, sweep: Path) -> None:
    """Raise CaseError where `folder` has the manifest of another sweep, whose file is there; edited, it is the same."""
    try:
        there = read_manifest(folder).sweep
        other = not there.samefile(sweep)
    except (FileError, OSError):  # no manifest, or one or both of the sweep files are gone
        return
    if other:
        raise CaseError(f"holds the sweep of {there}; give another folder with -o, or remove this one", (), folder)


def write_manifest(manifest: Manifest) -> None:
    """Write it into its folder, made if need be, in one step. Raises FileError."""
    head = {
        "format": FORMAT,
        "sweep": str(manifest.sweep),
        "title": manifest.title,
        "case": str(manifest.case),
        "overrides": manifest.overrides,
        "quantities": manifest.quantities,
        "threads": manifest.threads,
        "memory": manifest.memory,
    }
    lines = [
        json.dumps(
            {
                "index": row.index,
                "id": row.id,
                "result": f"{RESULTS_NAME}/{row.id}.h5",
                "seconds": row.seconds,
                "settings": {setting.key: setting.value for setting in row.settings},
            },
            ensure_ascii=False,
        )
        for row in manifest.rows
    ]
    cases = ",\n  ".join(lines)
    text = json.dumps(head, indent=1, ensure_ascii=False)[:-2] + f',\n "cases": [\n  {cases}\n ]\n}}\n'
    path = manifest.folder / MANIFEST_NAME
    with atomic_files.reported(path):
        (manifest.folder / RESULTS_NAME).mkdir(parents=True, exist_ok=True)
        atomic_files.write_text(path, text)


def read_manifest(folder: Path) -> Manifest:
    """Raises FileError."""
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
            tuple(_row(row) for row in values["cases"]),
        )
    except OSError as error:
        needed = "a folder is needed that sweep run has made"
        raise FileError(f"cannot be read: {reason_of(error)}; {needed}", path) from None
    except (ValueError, KeyError, TypeError) as error:
        raise FileError(f"not the manifest of a sweep: {error}", path) from error


def _row(values: dict[str, Any]) -> Row:
    settings = tuple(Setting(key, value) for key, value in values["settings"].items())
    return Row(values["index"], values["id"], settings, values["seconds"])


def index_list(indices: Sequence[int]) -> str:
    """Numbers as ``0-3,7,9-12``, the form of Slurm's --array."""
    parts: list[str] = []
    numbers = sorted(set(indices))
    for place, number in enumerate(numbers):
        if place and number == numbers[place - 1] + 1:
            parts[-1] = parts[-1].partition("-")[0] + f"-{number}"
        else:
            parts.append(str(number))
    return ",".join(parts)
