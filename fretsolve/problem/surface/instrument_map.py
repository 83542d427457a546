"""Read heights from files of instruments, by the library SurfaceTopography."""

from __future__ import annotations

from pathlib import Path

from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.surface.raw_map import RawMap


def read_instrument(file: Path, key: KeyPath) -> RawMap:
    """Read the first height map of a file. key: place of the file's name in the case. Raises CaseError, FileError."""
    raise CaseError(f"{file.name!r} has an unknown ending", key)
