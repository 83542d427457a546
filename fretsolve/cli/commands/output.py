"""Carry out ``fretsolve show`` and ``fretsolve export``: print a result, or write it as files for other programs.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

import csv
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.history import OF_RIG
from fretsolve.case.other_names import nearest
from fretsolve.errors import CaseError, together
from fretsolve.post.export import FORMATS
from fretsolve.post.export.selection import stored_step
from fretsolve.post.export.tables import csv_heading, require_wear, write_heights, write_history_csv, write_npz
from fretsolve.post.export.text_report import print_report
from fretsolve.post.export.xdmf import points_file, require_readable, write_xdmf
from fretsolve.post.stress.computed_file import ComputedFile, opened_computed
from fretsolve.result import Result, open_result
from fretsolve.result.cycles.table import CYCLE_NAMES
from fretsolve.result.state import CORRECTED, CORRECTED_SUFFIX, ERROR_SUFFIX, ESTIMATED, stage_ends
from fretsolve.system.files import require_ending, require_free, require_other, writing
from fretsolve.system.progress import print_warnings


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
    if as_run in OF_RIG and as_run not in result.history:
        return f"{name} is known with a rig alone; the case has none"
    if as_run != name and as_run in (*ESTIMATED, *OF_RIG):
        known = name.endswith(ERROR_SUFFIX) or as_run in (*CORRECTED, *OF_RIG)
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


def export_result(out: Path, file_format: str, target: Path | None, steps: Sequence[int], overwrite: bool) -> int:
    """Write the result `out` to `target`, print its name, and return the exit code. Raises CaseError, FileError.

    target: None for the result's name with the format's ending; steps: none for all; overwrite: replace existing files.
    """
    if steps and file_format == "csv":
        raise CaseError("csv holds the history of all increments, so --step has no effect; leave it out", (), out)
    with opened_computed(out) as computed:
        if computed is not None:
            return _export_volumes(computed, out, file_format, target, steps, overwrite=overwrite)
    with open_result(out) as result:
        if not result.increments:
            raise CaseError(result.why_empty, (), result.path)
        target = target or result.path.with_suffix(FORMATS[file_format])
        require_ending(target, f"a {file_format} file", Path(f"x{FORMATS[file_format]}").suffix)
        for file in (target, points_file(target)) if file_format == "xdmf" else (target,):
            require_other(file, result.path, "the result itself")
            require_free(file, overwrite=overwrite)
        if file_format == "xdmf":
            require_readable(result, target)
        if file_format == "vtk":
            from fretsolve.post.export.vtk import require_own_grids  # loads scipy

            with writing(target):
                require_own_grids(target, overwrite=overwrite)
        try:
            exported = tuple(sorted({stored_step(result, step) for step in steps})) or result.steps
        except ValueError as error:
            raise CaseError(str(error), (), result.path) from error
        if file_format in ("vtk", "xdmf") and not result.fields:
            raise CaseError("no fields are stored; output.fields in the case file chooses them", (), result.path)
        if file_format == "heights":
            if len(steps) > 1:
                raise CaseError("heights are those of one increment; give --step once", (), result.path)
            require_wear(result, exported[-1] if exported else -1)
        with writing(target):
            warnings = _write(result, file_format, exported, target, exclusive=not overwrite)
    print_warnings(result.path, *warnings)
    print(target, flush=True)
    return 0


def _export_volumes(
    computed: ComputedFile, out: Path, file_format: str, target: Path | None, steps: Sequence[int], *, overwrite: bool
) -> int:
    """Write an open file of stresses or fatigue parameters as volumes, and print the name. Return the exit code."""
    if computed.kind == "crack":
        raise CaseError("a crack cannot be exported: the file itself is HDF5, as xarray and h5py read it", (), out)
    what = "stresses" if computed.kind == "stress" else "fatigue parameters"
    if file_format != "vtk":
        raise CaseError(f"{what} can be exported to vtk, not to {file_format}; the file itself is HDF5", (), out)
    if steps:
        raise CaseError(f"all of a file of {what} is exported; leave --step out", (), out)
    from fretsolve.post.export.vtk import VOLUME_NAME, require_own_grids, write_volumes

    target = target or out.with_suffix(FORMATS[file_format])
    require_ending(target, "a vtk file", FORMATS[file_format])
    require_free(target, overwrite=overwrite)
    with writing(target):
        require_own_grids(target, VOLUME_NAME, overwrite=overwrite)
        write_volumes(computed, target, exclusive=not overwrite)
    print(target, flush=True)
    return 0


def _write(result: Result, file_format: str, steps: Sequence[int], out: Path, *, exclusive: bool) -> Sequence[str]:
    """Write the file, and return warnings; exclusive: replace nothing."""
    if file_format == "vtk":
        from fretsolve.post.export.vtk import write_vtk

        return write_vtk(result, steps, out, exclusive=exclusive)
    if file_format == "xdmf":
        write_xdmf(result, steps, out, exclusive=exclusive)
    elif file_format == "heights":
        write_heights(result, steps[-1], out, exclusive=exclusive)
    elif file_format == "csv":
        write_history_csv(result, out, exclusive=exclusive)
    else:
        write_npz(result, steps, out, exclusive=exclusive)
    return ()
