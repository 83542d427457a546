"""Carry out ``fretsolve show``: print a result as tables, as CSV or as JSON."""

from __future__ import annotations

import csv
import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.other_names import nearest
from fretsolve.case.problems import together
from fretsolve.errors import CaseError
from fretsolve.post.export.tables import csv_heading
from fretsolve.post.export.text_report import print_report
from fretsolve.result import Result, open_result
from fretsolve.result.cycles.table import CYCLE_NAMES
from fretsolve.result.state import CORRECTED, CORRECTED_SUFFIX, ERROR_SUFFIX, ESTIMATED, stage_ends


def show_result(out: Path, *, every_increment: bool, columns: str | None, as_json: bool, as_csv: bool) -> int:
    """Print the result `out`. columns: names of columns of the history with commas between, None for all that tell.

    as_json, as_csv: print for programs, all digits of all columns, unless some are named. Raises CaseError, FileError.
    """
    with open_result(out) as result:
        names = _named(columns, result)
        if as_json:
            print(json.dumps(as_object(result, names, every_increment=every_increment), indent=1, allow_nan=False))
        elif as_csv:
            write_csv(result, names, every_increment=every_increment)
        else:
            print_report(result, every_increment=every_increment, columns=names or None)
    return 0


def _named(columns: str | None, result: Result) -> list[str]:
    """Return the named columns, none if none is named. Raises CaseError."""
    names = [name.strip() for name in columns.split(",")] if columns is not None else []
    wrong = [CaseError(_missing(name, result), (), "--columns") for name in names if name not in result.history]
    if wrong:
        raise together(wrong)
    return names


def _missing(name: str, result: Result) -> str:
    """Return why a result has no such column, and which one would be right."""
    if name in CYCLE_NAMES:
        return f"{name} is a column of the cycles, whose table is printed below the history; leave it out"
    as_run = name.removesuffix(ERROR_SUFFIX).removesuffix(CORRECTED_SUFFIX)
    if as_run != name and as_run in ESTIMATED:
        known = name.endswith(ERROR_SUFFIX) or as_run in CORRECTED
        if known and f"{as_run}{ERROR_SUFFIX}" not in result.history:
            return f"{name} is not there, since the case ran without error bars; run it with --error-bars"
        right = f"{as_run}{ERROR_SUFFIX}" if name.endswith(ERROR_SUFFIX) else as_run
        return f"{name} is not there, since {as_run} is not corrected for the number of increments; use {right}"
    of_bars = any(part in name for part in (ERROR_SUFFIX[:3], CORRECTED_SUFFIX[:4]))
    columns = [one for one in result.history if of_bars or not one.endswith((ERROR_SUFFIX, CORRECTED_SUFFIX))]
    return f"{name!r} is not a column of the history; {nearest(name, columns)}"


def _rows(result: Result, names: list[str], *, every_increment: bool) -> dict[str, list[Any]]:
    """Return columns of the history at the ends of stages or in all increments; all columns if none is named."""
    rows = np.arange(result.increments) if every_increment else stage_ends(result.history["stage"])
    chosen = list(dict.fromkeys(["step", "stage", *names])) if names else list(result.history)
    return {name: result.history[name][rows].tolist() for name in chosen}


def as_object(result: Result, names: list[str], *, every_increment: bool) -> dict[str, Any]:
    """Return what JSON is printed of a result; what is not known is null."""
    history = _rows(result, names, every_increment=every_increment)
    found: dict[str, Any] = {
        "result": str(result.path),
        "title": result.effective_case.get("title"),
        "status": result.status,
        "increments": result.increments,
        "units": {name: result.units(name) for name in history},
        "history": {name: _finite(values) for name, values in history.items()},
    }
    if "failure" in result.attributes:
        found["failure"] = str(result.attributes["failure"])
    if (cycles := result.cycles) is not None:
        found["cycle_units"] = dict(cycles.units)
        found["cycles"] = {name: _finite(values.tolist()) for name, values in cycles.columns.items()}
        found["cycle_notes"] = list(cycles.notes)
        found["periodic"] = [periodic for _, periodic in cycles.outcomes]
    return found


def _finite(values: list[Any]) -> list[Any]:
    return [None if isinstance(value, float) and not math.isfinite(value) else value for value in values]


def write_csv(result: Result, names: list[str], *, every_increment: bool) -> None:
    """Print the history as CSV, units in the heading, as ``fretsolve export --to csv`` writes it."""
    history = _rows(result, names, every_increment=every_increment)
    units = {name: result.units(name) for name in history}
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(csv_heading(units))
    writer.writerows(zip(*history.values(), strict=True))
