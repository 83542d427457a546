"""``fretsolve export``: a result as files of other tools."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.errors import CaseError
from fretsolve.export.xdmf import points_file
from fretsolve.result import open_result
from fretsolve.system.files import require_ending, require_free, writing

if TYPE_CHECKING:
    from fretsolve.result import Result

SUFFIXES = {"vtk": ".pvd", "xdmf": ".xdmf", "csv": ".csv", "npz": ".npz"}
"""What the name of the file ends on, per format."""


@dataclass(frozen=True)
class ExportOrder:
    """What the command line asks for.

    out: None for the result's name with the format's suffix; steps: none for all; overwrite: files that are there.
    """

    result: Path
    file_format: str
    out: Path | None
    steps: tuple[int, ...]
    overwrite: bool


def export_result(order: ExportOrder) -> int:
    """Write the file and tell where it lies; the exit code. Raises CaseError, FileError."""
    if order.steps and order.file_format == "csv":
        raise CaseError("--step has no effect on csv, which holds the history; leave it out")
    with open_result(order.result) as result:
        if not result.increments:
            raise CaseError(result.why_empty, (), result.path)
        out = order.out or result.path.with_suffix(SUFFIXES[order.file_format])
        _require_target(out, order, result)
        steps = _chosen(result, order.steps)
        with writing(out):
            notes = _write(result, order.file_format, steps, out)
    for note in notes:
        print(f"{result.path}: warning: {note}", file=sys.stderr)
    print(out, flush=True)
    return 0


def _write(result: Result, file_format: str, steps: Sequence[int], out: Path) -> Sequence[str]:
    """Write it; what a person should hear of it."""
    if file_format == "csv":
        from fretsolve.export.csv_table import write_csv

        write_csv(result, out)
        return ()
    if file_format == "npz":
        from fretsolve.export.npz import write_npz

        write_npz(result, steps, out)
        return ()
    _require_fields(result)
    if file_format == "xdmf":
        from fretsolve.export.xdmf import write_xdmf

        write_xdmf(result, steps, out)
        return ()
    from fretsolve.export.vtk import write_vtk

    return write_vtk(result, steps, out)


def _require_target(out: Path, order: ExportOrder, result: Result) -> None:
    """Raise CaseError where `out` is no name for the format, that of the result, or that of a file not to replace."""
    require_ending(out, order.file_format, SUFFIXES[order.file_format])
    targets = (out, points_file(out)) if order.file_format == "xdmf" else (out,)
    for path in targets:
        if path.resolve() == result.path.resolve() or _same(path, result.path):
            raise CaseError("would replace the result itself; give another name with -o", (), path)
    require_free(*targets, overwrite=order.overwrite)


def _same(one: Path, other: Path) -> bool:
    return one.exists() and other.exists() and one.samefile(other)


def _require_fields(result: Result) -> None:
    if not result.fields:
        raise CaseError("no fields are stored; output.fields in the case file chooses them", (), result.path)


def _chosen(result: Result, asked: Sequence[int]) -> tuple[int, ...]:
    """The increments asked for, in order (negative: from the end), by default all with fields. Raises CaseError."""
    wanted = [step + result.increments if step < 0 else step for step in asked]
    for name, step in zip(asked, wanted, strict=True):
        if not 0 <= step < result.increments:
            raise CaseError(f"--step {name}: there are the increments 0 to {result.increments - 1}", (), result.path)
        if step not in result.steps:
            nearest = min(result.steps, key=lambda stored: abs(stored - step))
            raise CaseError(
                f"--step {name}: its fields are not stored (output.every); the nearest ones are those of {nearest}",
                (),
                result.path,
            )
    return tuple(sorted(set(wanted))) if wanted else result.steps
