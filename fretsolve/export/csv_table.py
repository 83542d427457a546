"""Write the history as CSV: one row per increment, the units in the header, every digit of every number."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from fretsolve.result import Result
from fretsolve.system import atomic_files


def write_csv(result: Result, path: Path) -> None:
    """Write the history. Raises OSError."""
    units = {name: result.units(name) for name in result.history}
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow([name if unit == "1" else f"{name} ({unit})" for name, unit in units.items()])
    writer.writerows(zip(*(column.tolist() for column in result.history.values()), strict=True))
    atomic_files.write_text(path, text.getvalue())
