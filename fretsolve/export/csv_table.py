"""The history as CSV: one row per increment, the units in the header, every digit of every number."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.system import atomic_files

if TYPE_CHECKING:
    from fretsolve.result import Result


def write_csv(result: Result, path: Path) -> None:
    """Write the history. Raises OSError."""
    names = list(result.history)
    columns = [result.history[name].tolist() for name in names]
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow([heading(name, result.units(name)) for name in names])
    writer.writerows(zip(*columns, strict=True))
    atomic_files.write_text(path, text.getvalue())


def heading(name: str, units: str) -> str:
    """Such as ``Mz (N mm)``; a plain number has no units."""
    return name if units == "1" else f"{name} ({units})"
