"""Checks and error messages for files that a command writes, and reading of files that others may have made."""

from __future__ import annotations

import io
import os
import select
import shlex
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from fretsolve.errors import CaseError, FileError

PIPE_SECONDS = 15.0
"""Within which a pipe must give its text and be closed."""

PICTURE_MARK = "drawn by fretsolve"
"""In the metadata of every picture, by which one is known before it is replaced."""


class FilledFile(io.FileIO):
    """A file that HDF5 reads through h5py's file-like driver, which needs each buffer to be filled."""

    def readinto(self, buffer: Any) -> int:
        """Fill `buffer`, with zeros past the end of the file. Raises OSError."""
        view = memoryview(buffer)
        while view and (count := super().readinto(view)):
            view = view[count:]
        view[:] = bytes(len(view))
        return len(buffer)


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
    """Make a folder and the folders above it, unless they exist. Raises FileError."""
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


def require_folder(file: Path) -> None:
    """Raise FileError if the folder of `file`, which is to be written, is not there."""
    if not file.parent.is_dir():
        raise FileError(f"there is no folder {file.parent}; mkdir -p {shlex.quote(str(file.parent))} makes it", file)


def require_utf8(text: str, file: Path) -> None:
    """Raise FileError if `text`, a name that is to stand in another file, is not UTF-8; file: whose name it is."""
    if text.encode(errors="replace").decode() != text:
        message = "is not UTF-8 text, which the file to be written could not hold: rename that"
        raise FileError(f"the name of a file or folder {message}", file)


def require_ending(file: Path, what: str, *endings: str) -> None:
    """Raise CaseError unless the name of `file`, which is to hold `what`, has one of `endings`, such as ``.csv``."""
    if file.suffix.lower() not in endings:
        raise CaseError(f"the name of {what} must end in {' or '.join(endings)}", (), file)


def require_regular(path: Path, most: float = float("inf")) -> None:
    """Raise FileError unless `path` is a regular file of at most `most` bytes: a pipe or a device might never end.

    Raises OSError if it is not there.
    """
    found = path.stat()
    if stat.S_ISDIR(found.st_mode):
        raise FileError("is a folder; the name of a file is needed", path)
    if not stat.S_ISREG(found.st_mode):
        raise FileError("is not a regular file, but a pipe, a socket or a device; it is not read", path)
    if found.st_size > most:
        raise FileError(f"has {found.st_size} bytes; at most {most:.0f} are read", path)


def read_bytes(path: Path, most: int) -> bytes:
    """Return the content of a regular file of at most `most` bytes. Raises OSError, FileError."""
    # A pipe that takes the file's place after the check does not block the opening.
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with open(descriptor, "rb") as file:  # noqa: PTH123 - a descriptor
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            require_regular(path)
        content = file.read(min(status.st_size, most) + 1)  # no more memory than it takes
    if len(content) > most:
        require_regular(path, most)
    return content


def read_pipe(path: Path, most: int) -> bytes:
    """Return what comes through a pipe until it is closed. Raises OSError; FileError for too long a time or text."""
    content, end = b"", time.monotonic() + PIPE_SECONDS
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # does not wait for a writer
    with open(descriptor, "rb", buffering=0) as file:  # noqa: PTH123 - a descriptor
        ready = select.poll()
        ready.register(file, select.POLLIN)
        while len(content) <= most:
            if not ready.poll(1000.0 * max(end - time.monotonic(), 0.0)):
                raise FileError(f"is a pipe that nobody has closed within {PIPE_SECONDS:g} s", path)
            more = file.read(2**16)  # None if another process has taken it
            if more == b"":
                return content
            content += more or b""
    raise FileError(f"is a pipe of more than {most} bytes", path)


def require_own(path: Path, mark: bytes, what: str) -> None:
    """Raise FileError if there is a file at `path` without `mark`, which is in every `what` that fretsolve writes."""
    own = path.is_dir() or not os.path.lexists(path)  # no file takes the place of a folder
    with suppress(FileError), reported("cannot be read", path):
        own = own or mark in read_bytes(path, 2**28)
    if not own:
        message = f"is not {what} of fretsolve, so it is not replaced: move it away, or give another name with -o"
        raise FileError(message, path)


def read_small_text(path: Path, what: str, most: int = 2**30) -> str:
    """Return the UTF-8 text of a file that fretsolve has written. what: it in words. Raises OSError, FileError."""
    try:
        return read_bytes(path, most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"not {what}: byte {error.start} is not UTF-8 text", path) from None
