"""Files that commands write for people: which may be replaced, and what is said of one that cannot be written.

Light, since commands use it that need nothing else; results are written by `fretsolve.system.atomic_files`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from fretsolve.errors import CaseError, FileError


def reason_of(error: OSError) -> str:
    """Why a call of the operating system has failed, without the name of the file."""
    return os.strerror(error.errno) if error.errno else str(error)


@contextmanager
def writing(file: Path | str) -> Iterator[None]:
    """Around writing `file`: raises FileError for an OSError."""
    try:
        yield
    except OSError as error:
        raise FileError(f"cannot be written: {reason_of(error)}", file) from error


def make_folder(folder: Path) -> None:
    """Make a folder, with those above it, where there is none. Raises FileError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot be made a folder: {reason_of(error)}", folder) from error


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A file to write, which takes the place of `path` once the block is left without an error. Raises OSError."""
    temporary = path.with_name(path.name + ".tmp")
    try:
        with temporary.open("wb") as file:
            yield file
        temporary.replace(path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise


def require_free(
    *files: Path, overwrite: bool = False, advice: str = "--overwrite replaces it, or give another name with -o"
) -> None:
    """Raise CaseError where one of `files` is a folder, or is there without `overwrite`; advice: what would help."""
    for file in files:
        if file.is_dir():
            raise CaseError("is a folder; the name of a file is needed", (), file)
        if file.exists() and not overwrite:
            raise CaseError(f"exists: {advice}", (), file)


def require_ending(file: Path, what: str, *endings: str) -> None:
    """Raise CaseError where `file` does not end on one of `endings`, such as ``.csv``; what: that it is to hold."""
    if file.suffix.lower() not in endings:
        raise CaseError(f"no name for {what}; one that ends on {', '.join(endings)} is needed", (), file)
