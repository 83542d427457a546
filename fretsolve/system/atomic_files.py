# ruff: noqa: PTH102, PTH105, PTH106, PTH108
"""Change files so that a kill or a power cut leaves each of them whole: with its old content or its new one.

Every call that changes a file goes through this module's `os`, which the tests replace to make each call fail.
`working_folder` makes a folder beside a file that is being made, for what only its making needs.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

from fretsolve.system.files import FilledFile, TakenError
from fretsolve.system.signals import ENDING, end_by

_TEMPORARY = re.compile(r"(.+)\.[0-9a-f]{16}\.tmp")
"""Names of files that are being written."""

LONGEST_ENDING = len(".0123456789abcdef.tmp")
"""Bytes that the name of a file is longer by while it is written."""

HDF5_VERSIONS = ("v110", "v110")
"""HDF5 1.10 and later read such files, and all of their metadata have checksums."""

STALE = 86400.0
"""Seconds after which a temporary file counts as left by a kill, if other processes may write the same file. Clocks of
servers differ, and may be set forward."""


class WriteThroughFile(FilledFile):
    """A new file that remembers its first error instead of raising it.

    If a write fails while HDF5 closes a file, the interpreter crashes at exit. So HDF5 writes through this object
    (h5py's file-like driver), which drops all writes after a failed one and reports the failure in `check`.
    """

    def __init__(self, path: Path):
        super().__init__(path, "x+", opener=lambda name, flags: os.open(name, flags, 0o666))
        self.path = path
        self._error: OSError | None = None

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        size = len(view)
        try:
            while view and self._error is None:
                view = view[os.write(self.fileno(), view) :]
        except OSError as error:
            self._error = error
        return size

    def truncate(self, size: int | None = None) -> int:
        size = self.tell() if size is None else size
        try:
            if self._error is None:
                os.ftruncate(self.fileno(), size)
        except OSError as error:
            self._error = error
        return size

    def check(self) -> None:
        """Raise the first error of a write, if any."""
        if self._error is not None:
            raise self._error


@contextmanager
def new_file(
    target: Path, folder: Path | None = None, *, durable: bool = True, exclusive: bool = False
) -> Iterator[WriteThroughFile]:
    """Open a new file, which replaces `target` in one step once the block ends without an error.

    Until then it has a name of its own, so that several processes may write `target` at once. folder: where it lies, on
    the same file system; by default beside `target`, where it also removes what kills have left. durable: wait until
    file and name are on the disk. exclusive: raise TakenError instead if `target` exists by then. Raises OSError, and
    gives no new name then.
    """
    if exclusive:
        _require_absent(target)
    if folder is None:
        remove_stale(target)
    temporary = (folder or target.parent) / f"{target.name}.{secrets.token_hex(8)}.tmp"
    try:
        with WriteThroughFile(temporary) as file:
            yield file
            file.check()
            if durable:
                os.fsync(file.fileno())
        new = exclusive or not os.path.lexists(target)
        if exclusive:
            _name_new(temporary, target)
        else:
            os.replace(temporary, target)
    except BaseException:
        _take_back(temporary)
        raise
    try:
        if durable:
            sync_folder(target.parent)
    except BaseException:
        if new:
            _take_back(target)
        raise


def _take_back(*made: Path) -> None:
    """Remove files and empty folders after an error, the last one first, as far as that can be done."""
    for path in reversed(made):
        with suppress(OSError):
            if path.is_dir():
                os.rmdir(path)
            else:
                os.unlink(path)


@contextmanager
def all_or_none() -> Iterator[Callable[[Path], AbstractContextManager[None]]]:
    """Yield a function `making`, for files and folders that belong together: ``with making(path):`` makes one of them.

    If the block fails, those that it has made and that were not there before are removed. One that it has replaced
    stays as it is.
    """
    made: list[Path] = []

    @contextmanager
    def making(path: Path) -> Iterator[None]:
        new = not os.path.lexists(path)
        yield
        if new:
            made.append(path)

    try:
        yield making
    except BaseException:
        _take_back(*made)
        raise


def _require_absent(target: Path) -> None:
    if os.path.lexists(target):
        raise TakenError(errno.EEXIST, os.strerror(errno.EEXIST), str(target))


def _name_new(temporary: Path, target: Path) -> None:
    """Rename a file, and replace nothing: a rename would replace what has appeared since a check."""
    try:
        os.link(temporary, target)
    except FileExistsError as error:
        raise TakenError(*error.args) from error
    except OSError:  # a file system without hard links, where the moment after the check remains
        _require_absent(target)
        os.replace(temporary, target)
    else:
        try:
            os.unlink(temporary)
        except BaseException:
            _take_back(target)
            raise


@contextmanager
def new_hdf5(target: Path, folder: Path | None = None, *, exclusive: bool = False) -> Iterator[Any]:
    """Open a new `h5py.File` as `new_file` does. Raises OSError.

    Without a cache chunks lie in the order in which they are written, so that equal runs give equal files.
    """
    import h5py

    with new_file(target, folder, exclusive=exclusive) as raw:
        try:
            with h5py.File(raw, "w", libver=HDF5_VERSIONS, rdcc_nbytes=0) as file:
                yield file
        except Exception:
            raw.check()  # whatever HDF5 reports after a failed write, that write is the cause
            raise


def write_text(target: Path, text: str, *, exclusive: bool = False) -> None:
    """Write a small file as `new_file` does. Raises OSError."""
    with new_file(target, exclusive=exclusive) as file:
        file.write(text.encode())


def sync_folder(folder: Path) -> None:
    """Make the names in `folder` survive a power cut. Raises OSError."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # some network file systems cannot sync a folder
            raise
    finally:
        os.close(descriptor)


def add_folder(folder: Path, *, durable: bool = True) -> None:
    """Create `folder` unless it exists; durable: wait until its name is on the disk. Raises OSError."""
    with suppress(FileExistsError):
        os.mkdir(folder)
        if durable:
            sync_folder(folder.parent)


def remove(*files: Path, durable: bool = True) -> None:
    """Remove the files of one folder that exist, in order; durable: wait until they are gone on the disk.

    Raises OSError.
    """
    removed = False
    for file in files:
        with suppress(FileNotFoundError):
            os.unlink(file)
            removed = True
    if removed and durable:
        sync_folder(files[0].parent)


def rename(file: Path, target: Path) -> None:
    """Give a file a new name on the same file system. Raises OSError, also if another file has that name."""
    _name_new(file, target)
    sync_folder(target.parent)
    sync_folder(file.parent)


def move(folder: Path, *files: Path) -> None:
    """Move the files of one folder, in order, to a new `folder` on the same file system. Raises OSError."""
    os.mkdir(folder)
    sync_folder(folder.parent)
    for file in files:
        os.replace(file, folder / file.name)
    sync_folder(folder)
    sync_folder(files[0].parent)


def remove_folder(folder: Path, *files: Path) -> None:
    """Remove a folder, and first all the files in it. A power cut may bring them back. Raises OSError."""
    for file in files:
        os.unlink(file)
    os.rmdir(folder)


def remove_stale(target: Path) -> None:
    """Remove what kills have left of a file that other processes may be writing. Raises OSError."""
    begun = time.time() - STALE
    for path in temporaries(target.parent):
        with suppress(FileNotFoundError):
            left = path.lstat()
            if _written(path) == target.name and left.st_mtime < begun and left.st_uid == os.geteuid():
                remove(path)


def temporaries(folder: Path) -> list[Path]:
    """Return the files in `folder` that `new_file` is writing, or that kills have left. Raises OSError."""
    return sorted(path for path in folder.iterdir() if _written(path))


def _written(path: Path) -> str:
    """Return the name of the file that a temporary one is to replace; empty if it is none of `new_file`."""
    match = _TEMPORARY.fullmatch(path.name)
    return match[1] if match and path.is_file() and not path.is_symlink() else ""


class _Ended(BaseException):
    """A signal came that ends the process."""

    def __init__(self, number: int):
        super().__init__(number)
        self.number = signal.Signals(number)


@contextmanager
def working_folder(target: Path, folder: Path | None = None) -> Iterator[Path]:
    """Yield a new folder, which is removed at the end of the block, also at a signal that ends the process.

    folder: where it lies; by default beside `target`, where what kills have left of earlier ones is removed after a
    day. Raises OSError.
    """
    if folder is None:
        _remove_stale_folders(target)
    # Not where temporary files lie by default, which may be a small place.
    where = folder or target.parent
    with _unwound(), TemporaryDirectory(dir=where, prefix=f"{target.stem}.", suffix=".tmp") as working:
        yield Path(working)


def _remove_stale_folders(target: Path) -> None:
    """Remove the folders of `target` that a kill has left: own ones with this name, untouched for a day."""
    begun = time.time() - STALE
    for path in _working_folders(target.parent, re.escape(target.stem)):
        with suppress(FileNotFoundError):
            inside = [path, *path.iterdir()]
            if all(one.lstat().st_mtime < begun and one.lstat().st_uid == os.geteuid() for one in inside):
                shutil.rmtree(path)


def _working_folders(folder: Path, stem: str = ".+") -> list[Path]:
    """Return the folders in `folder` that `working_folder` has made for targets of a `stem`. Raises OSError."""
    found = (path for path in folder.iterdir() if re.fullmatch(stem + r"\.[a-z0-9_]{8}\.tmp", path.name))
    return [path for path in found if path.is_dir() and not path.is_symlink()]


def remove_temporaries(folder: Path) -> None:
    """Remove what kills have left in `folder`, in which nobody else is writing. Raises OSError."""
    remove(*temporaries(folder))
    for path in _working_folders(folder):
        shutil.rmtree(path)


@contextmanager
def _unwound() -> Iterator[None]:
    """Leave the block at a signal that ends the process, so that it removes its files, and end by the signal then.

    A signal that something else handles, as in a run, or that is ignored, as under nohup, is left alone.
    """
    main = threading.current_thread() is threading.main_thread()
    ending = [number for number in ENDING if main and signal.getsignal(number) is signal.SIG_DFL]

    def unwind(number: int, frame: FrameType | None) -> None:
        for one in ending:
            signal.signal(one, signal.SIG_IGN)  # while the files are removed
        raise _Ended(number)

    for number in ending:
        signal.signal(number, unwind)
    try:
        yield
    except _Ended as ended:
        end_by(ended.number)
    finally:
        for number in ending:
            signal.signal(number, signal.SIG_DFL)
