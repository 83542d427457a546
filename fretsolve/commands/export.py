"""Carry out ``fretsolve export``: write a result as files for other programs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.errors import CaseError
from fretsolve.export.selection import stored_step
from fretsolve.export.xdmf import points_file
from fretsolve.result import Result, open_result
from fretsolve.system.files import require_ending, require_free, writing

SUFFIXES = {"vtk": ".pvd", "xdmf": ".xdmf", "csv": ".csv", "npz": ".npz"}
"""Ending of the file's name, per format."""


@dataclass(frozen=True)
class ExportOrder:
    """What the command line asks for.

    out: None for the result's name with the format's suffix; steps: none for all; overwrite: replace existing files.
    """

    result: Path
    file_format: str
    out: Path | None
    steps: tuple[int, ...]
    overwrite: bool


def export_result(order: ExportOrder) -> int:
    """Write the file, print its name, and return the exit code. Raises CaseError, FileError."""
    if order.steps and order.file_format == "csv":
        raise CaseError("--step has no effect on csv, which holds the history; leave it out")
    with open_result(order.result) as result:
        if not result.increments:
            raise CaseError(result.why_empty, (), result.path)
        out = order.out or result.path.with_suffix(SUFFIXES[order.file_format])
        _require_target(out, order, result)
        try:
            steps = tuple(sorted({stored_step(result, step) for step in order.steps})) or result.steps
        except ValueError as error:
            raise CaseError(str(error), (), result.path) from error
        if order.file_format in ("vtk", "xdmf") and not result.fields:
            raise CaseError("no fields are stored; output.fields in the case file chooses them", (), result.path)
        with writing(out):
            warnings = _write(result, order.file_format, steps, out)
    for warning in warnings:
        print(f"{result.path}: warning: {warning}", file=sys.stderr)
    print(out, flush=True)
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


def _require_target(out: Path, order: ExportOrder, result: Result) -> None:
    """Raise CaseError if `out` does not end as the format does, or names the result or a file that is to stay."""
    require_ending(out, order.file_format, SUFFIXES[order.file_format])
    targets = (out, points_file(out)) if order.file_format == "xdmf" else (out,)
    for path in targets:
        same = path.exists() and result.path.exists() and path.samefile(result.path)
        if same or path.resolve() == result.path.resolve():
            raise CaseError("would replace the result itself; give another name with -o", (), path)
    require_free(*targets, overwrite=order.overwrite)
