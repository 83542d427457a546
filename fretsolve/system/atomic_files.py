# ruff: noqa: PTH102, PTH105, PTH106, PTH108
"""Changes on disk that survive a kill or a power cut: a file appears whole under its name, or not at all.

Every call that changes something goes through this module's `os`, which the tests replace to make each fail.
"""

from __future__ import annotations

import errno
import glob
import io
import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import h5py

from fretsolve.system.files import writing

LIBRARY_VERSIONS = ("v110", "v110")
"""Read by HDF5 1.10 and later, and with checksums on all metadata."""

TEMPORARY_SUFFIX = ".tmp"

STALE = 3600.0
"""Age in seconds at which a temporary file was left by a kill, where other processes may be writing the same file."""


class WriteThroughFile(io.RawIOBase):
    """A new random access file that remembers its first error instead of raising it.

    HDF5 cannot recover from a write that fails while it closes a file: the interpreter then crashes at exit.
    So HDF5 writes through this object (h5py's file-like driver), which drops all writes after a failed one
    and reports the failure afterwards, in `sync`.
    """

    def __init__(self, path: Path):
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self._position = 0
        self._error: OSError | None = None

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        if whence == os.SEEK_CUR:
            offset += self._position
        elif whence == os.SEEK_END:
            offset += os.fstat(self._descriptor).st_size
        self._position = offset
        return offset

    def tell(self) -> int:
        return self._position

    def readinto(self, buffer: Any) -> int:
        data = os.pread(self._descriptor, len(buffer), self._position)
        buffer[:] = data.ljust(len(buffer), b"\0")
        self._position += len(buffer)
        return len(buffer)

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        try:
            self._write_at(self._position, view)
        except OSError as error:
            self._error = error
        self._position += len(view)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        size = self._position if size is None else size
        try:
            if self._error is None:
                os.ftruncate(self._descriptor, size)
        except OSError as error:
            self._error = error
        return size

    def check(self) -> None:
        """Raise the first error of a write, if any."""
        if self._error is not None:
            raise self._error

    def sync(self) -> None:
        """Raise the first error of a write, if any; then wait until all is on the disk."""
        self.check()
        os.fsync(self._descriptor)

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def close(self) -> None:
        if not self.closed:
            os.close(self._descriptor)
        super().close()

    def _write_at(self, position: int, view: memoryview) -> None:
        while view and self._error is None:
            written = os.pwrite(self._descriptor, view, position)
            view, position = view[written:], position + written


@contextmanager
def new_file(target: Path, folder: Path) -> Iterator[WriteThroughFile]:
    """A file to write, which replaces `target` in one step once the block is left without an error.

    Until then it lies in `folder` under a name of its own, so that several processes may write `target` at the same
    time (`remove_temporaries` clears up after a kill). `folder` must be on the file system of `target`. Raises OSError.
    """
    temporary = folder / f"{target.name}.{secrets.token_hex(4)}{TEMPORARY_SUFFIX}"
    file = WriteThroughFile(temporary)
    try:
        try:
            yield file
            file.sync()
        finally:
            file.close()
        os.replace(temporary, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise
    sync_folder(target.parent)


@contextmanager
def new_hdf5(target: Path, folder: Path, image: bytes = b"") -> Iterator[h5py.File]:
    """`new_file` as an HDF5 file; image: one to begin with. Raises OSError."""
    with new_file(target, folder) as raw:
        try:
            raw.write(image)
            with h5py.File(raw, "r+" if image else "w", libver=LIBRARY_VERSIONS) as file:
                yield file
        except Exception:
            raw.check()  # whatever HDF5 met after a failed write, that write is the cause
            raise


def write_text(target: Path, text: str) -> None:
    """Write a small file in `target`'s own folder. Raises OSError."""
    with new_file(target, target.parent) as file:
        file.write(text.encode())


@contextmanager
def reported(target: Path) -> Iterator[None]:
    """Around writing a file anew: clears up what a kill has left of it, and raises FileError for an OSError."""
    with writing(target):
        remove_stale(target)
        yield


def sync_folder(folder: Path) -> None:
    """Make the names in `folder` survive a power cut. Raises OSError."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # some network file systems know no sync of a folder
            raise
    finally:
        os.close(descriptor)


def make_folder(folder: Path) -> None:
    """Create `folder` if there is none. Raises OSError."""
    with suppress(FileExistsError):
        os.mkdir(folder)
        sync_folder(folder.parent)


def remove(*files: Path) -> None:
    """Remove files of one folder, in order; those that are not there are passed over. Raises OSError."""
    removed = False
    for file in files:
        with suppress(FileNotFoundError):
            os.unlink(file)
            removed = True
    if removed:
        sync_folder(files[0].parent)


def remove_folder(folder: Path, file: Path) -> None:
    """Remove a folder and the only file in it. Raises OSError."""
    os.unlink(file)
    os.rmdir(folder)
    sync_folder(folder.parent)


def remove_temporaries(folder: Path) -> None:
    """Clear up what a killed run left half written, in a folder that nobody else writes to. Raises OSError."""
    remove(*sorted(folder.glob("*" + TEMPORARY_SUFFIX)))


def remove_stale(target: Path) -> None:
    """Clear up what kills have left of a file that other processes may be writing. Raises OSError."""
    begun = time.time() - STALE
    for path in target.parent.glob(f"{glob.escape(target.name)}.*{TEMPORARY_SUFFIX}"):
        with suppress(FileNotFoundError):
            if path.stat().st_mtime < begun:
                remove(path)
