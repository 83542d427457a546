"""Checks and error messages for files that a command writes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fretsolve.errors import CaseError, FileError


class TakenError(FileExistsError):
    """Another file has taken the name of a file while that was being written."""


def reason_of(error: OSError) -> str:
    """Return why a call of the operating system has failed, without the name of the file."""
    return os.strerror(error.errno) if error.errno else str(error)


@contextmanager
def reported(problem: str, file: Path | str, advice: str = "") -> Iterator[None]:
    """Turn an OSError in the block into a FileError such as ``FILE: cannot be read: Permission denied`` + `advice`."""
    try:
        yield
    except OSError as error:
        raise FileError(f"{problem}: {reason_of(error)}{advice}", file) from error


@contextmanager
def writing(file: Path | str) -> Iterator[None]:
    """Turn an OSError in the block, which writes `file`, into a FileError."""
    with reported("cannot be written", file):
        try:
            yield
        except TakenError as error:
            message = "another file has taken this name meanwhile: move it away, or give another name"
            raise FileError(message, file) from error


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, unless they exist. Raises FileError."""
    with reported("cannot be made a folder", folder):
        folder.mkdir(parents=True, exist_ok=True)


def require_free(
    *files: Path, overwrite: bool = False, advice: str = "--overwrite replaces it, or give another name with -o"
) -> None:
    """Raise CaseError if one of `files` is a folder, or exists without `overwrite`; advice: what would help."""
    for file in files:
        if file.is_dir():
            raise CaseError("is a folder; the name of a file is needed", (), file)
        if file.exists() and not overwrite:
            raise CaseError(f"exists: {advice}", (), file)


def require_other(file: Path, source: Path, what: str) -> None:
    """Raise CaseError if `file`, which is to be written, is `source`; what: that in words."""
    if file.resolve() == source.resolve() or (file.exists() and source.exists() and file.samefile(source)):
        raise CaseError(f"would replace {what}; give another name with -o", (), file)


def require_utf8(text: str, file: Path) -> None:
    """Raise FileError if `text`, a name that is to stand in another file, is not UTF-8; file: whose name it is."""
    if text.encode(errors="replace").decode() != text:
        message = "is not UTF-8 text, which the file to be written could not hold: rename that"
        raise FileError(f"the name of a file or folder {message}", file)


def require_ending(file: Path, what: str, *endings: str) -> None:
    """Raise CaseError unless the name of `file`, which is to hold `what`, has one of `endings`, such as ``.csv``."""
    if file.suffix.lower() not in endings:
        raise CaseError(f"the name of {what} must end in {' or '.join(endings)}", (), file)
