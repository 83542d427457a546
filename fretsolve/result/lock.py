"""One run at a time on one output."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import time
from contextlib import suppress
from pathlib import Path

from fretsolve.errors import BusyError
from fretsolve.system import atomic_files

LOCK_NAME = "lock"
ATTEMPTS = 10
PAUSE = 0.02
"""Seconds between attempts: a reader that asks whether a run goes on holds the lock for some microseconds."""


class RunLock:
    """The right to write in a parts folder, kept until `release` or the end of the process, however it ends.

    It is an flock of the file ``lock`` in the folder: HDF5's own locks do not keep a second process from
    truncating a file, and a file that merely exists would stay behind after SIGKILL.
    """

    def __init__(self, folder: Path, descriptor: int):
        self.folder = folder
        self._descriptor = descriptor

    @classmethod
    def acquire(cls, folder: Path) -> RunLock:
        """Lock `folder`, created if need be. Raises BusyError where another run holds it, and OSError."""
        for attempt in range(ATTEMPTS):
            atomic_files.make_folder(folder)
            lock = cls._try(folder)
            if lock is not None:
                return lock
            if attempt + 1 < ATTEMPTS:
                time.sleep(PAUSE)
        raise BusyError(f"another run is writing this output{_holder(folder)}", folder)

    @classmethod
    def _try(cls, folder: Path) -> RunLock | None:
        path = folder / LOCK_NAME
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except FileNotFoundError:  # a run that ended just now took the folder away
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.fstat(descriptor).st_nlink == 0:  # it was taken away between open and flock
                raise BlockingIOError
            with suppress(OSError):  # who holds the lock is only for the message of the next run
                os.ftruncate(descriptor, 0)
                os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
        except BlockingIOError:
            os.close(descriptor)
            return None
        except OSError:
            os.close(descriptor)
            raise
        return cls(folder, descriptor)

    def release(self) -> None:
        """Give the lock back, and remove the folder where nothing else is in it."""
        with suppress(OSError):
            if [path.name for path in self.folder.iterdir()] == [LOCK_NAME]:
                atomic_files.remove_folder(self.folder, self.folder / LOCK_NAME)
        os.close(self._descriptor)


def is_locked(folder: Path) -> bool:
    """Whether a run is writing in `folder`, as far as can be told."""
    try:
        descriptor = os.open(folder / LOCK_NAME, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno == errno.EWOULDBLOCK
    finally:
        os.close(descriptor)
    return False


def _holder(folder: Path) -> str:
    try:
        text = (folder / LOCK_NAME).read_text()
    except OSError:
        return ""
    return f" ({text})" if text else ""
