"""Carry out ``fretsolve export``: write a result as files for other programs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from fretsolve.errors import CaseError
from fretsolve.export.selection import stored_step
from fretsolve.export.xdmf import points_file
from fretsolve.result import Result, open_result
from fretsolve.system.files import require_ending, require_free, writing

SUFFIXES = {"vtk": ".pvd", "xdmf": ".xdmf", "csv": ".csv", "npz": ".npz"}
"""Ending of the file's name, per format."""


def export_result(out: Path, file_format: str, target: Path | None, steps: Sequence[int], overwrite: bool) -> int:
    """Write the result `out` to `target`, print its name, and return the exit code. Raises CaseError, FileError.

    target: None for the result's name with the format's ending; steps: none for all; overwrite: replace existing files.
    """
    if steps and file_format == "csv":
        raise CaseError("--step has no effect on csv, which holds the history; leave it out", (), out)
    with open_result(out) as result:
        if not result.increments:
            raise CaseError(result.why_empty, (), result.path)
        target = target or result.path.with_suffix(SUFFIXES[file_format])
        require_ending(target, file_format, SUFFIXES[file_format])
        files = (target, points_file(target)) if file_format == "xdmf" else (target,)
        _require_other(files, result.path)
        require_free(*files, overwrite=overwrite)
        try:
            exported = tuple(sorted({stored_step(result, step) for step in steps})) or result.steps
        except ValueError as error:
            raise CaseError(str(error), (), result.path) from error
        if file_format in ("vtk", "xdmf") and not result.fields:
            raise CaseError("no fields are stored; output.fields in the case file chooses them", (), result.path)
        with writing(target):
            warnings = _write(result, file_format, exported, target)
    for warning in warnings:
        print(f"{result.path}: warning: {warning}", file=sys.stderr)
    print(target, flush=True)
    return 0


def _write(result: Result, file_format: str, steps: Sequence[int], out: Path) -> Sequence[str]:
    """Write the file with the libraries of its format alone, and return warnings."""
    if file_format == "csv":
        from fretsolve.export.tables import write_csv

        write_csv(result, out)
    elif file_format == "npz":
        from fretsolve.export.tables import write_npz

        write_npz(result, steps, out)
    elif file_format == "xdmf":
        from fretsolve.export.xdmf import write_xdmf

        write_xdmf(result, steps, out)
    else:
        from fretsolve.export.vtk import write_vtk

        return write_vtk(result, steps, out)
    return ()


def _require_other(files: Sequence[Path], result: Path) -> None:
    """Raise CaseError if one of `files` is the result itself."""
    for path in files:
        same = path.exists() and result.exists() and path.samefile(result)
        if same or path.resolve() == result.resolve():
            raise CaseError("would replace the result itself; give another name with -o", (), path)
