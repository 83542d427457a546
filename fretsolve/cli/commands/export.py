"""Carry out ``fretsolve export``: write a result as files for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fretsolve.errors import CaseError
from fretsolve.post.export import FORMATS
from fretsolve.post.export.selection import stored_step
from fretsolve.post.export.tables import require_wear, write_heights, write_history_csv, write_npz
from fretsolve.post.export.xdmf import points_file, require_readable, write_xdmf
from fretsolve.post.stress.computed_file import ComputedFile, opened_computed
from fretsolve.result import Result, open_result
from fretsolve.system.files import require_ending, require_free, require_other, writing
from fretsolve.system.progress import print_warnings


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
    """Write an open file of stresses or fatigue parameters as volumes, and print the name. Return the exit code.

    Raises CaseError, FileError.
    """
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
        write_volumes(computed, out, target, exclusive=not overwrite)
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
