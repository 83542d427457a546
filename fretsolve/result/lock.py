"""One run at a time on one output: a lock on a file in the folder of its parts."""

from __future__ import annotations

import errno
import fcntl
import os
import pwd
import socket
import stat
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.errors import BusyError, FileError
from fretsolve.system import atomic_files
from fretsolve.system.files import read_small_text, reason_of

if TYPE_CHECKING:  # filelock takes 30 ms to load, and readers of results lock nothing
    from filelock import BaseFileLock

LOCK_NAME, HOLDER_NAME = "lock", "holder"

NO_LOCKS = {errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP}
"""Errors of a file system on which nobody can hold a lock. On ENOSYS filelock takes the file itself as lock."""

WITHOUT_LOCK = "the file system has no locks, so nothing keeps a second run from writing this result"


@dataclass(frozen=True)
class RunLock:
    """The right to write in a parts folder, kept until `release` or the end of the process, even by SIGKILL.

    HDF5's own locks do not keep a second process from truncating a file. note: a warning where the file system has no
    locks, so that none is held; else empty.
    """

    folder: Path
    lock: BaseFileLock
    note: str = ""

    @classmethod
    def acquire(cls, folder: Path) -> RunLock:
        """Lock `folder`, and create it if needed.

        Raises BusyError if another run holds the lock, FileError if the folder is a link or another user's, OSError.
        """
        from filelock import FileLock, Timeout  # on demand, as above

        _require_own(folder)
        # A reader that asks whether a run goes on holds the lock for some microseconds.
        lock, note = FileLock(folder / LOCK_NAME, timeout=0.2, thread_local=False), ""
        for _ in range(3):
            atomic_files.add_folder(folder, durable=False)  # until something is saved in it
            _require_own(folder)
            try:
                with warnings.catch_warnings(action="ignore"):  # without flock filelock takes the file itself as lock
                    lock.acquire(poll_interval=0.02)
            except FileNotFoundError:  # a run that ended just now has removed the folder
                continue
            except Timeout:
                break
            except OSError as error:
                if error.errno not in NO_LOCKS:
                    raise
                note = f"{WITHOUT_LOCK} ({reason_of(error)}): start one at a time"
            with suppress(OSError):  # the holder is only for the message of the next run
                (folder / HOLDER_NAME).unlink(missing_ok=True)
                with (folder / HOLDER_NAME).open("x") as file:
                    file.write(f"process {os.getpid()} on {socket.gethostname()}")
            return cls(folder, lock, note)
        holder = ""
        with suppress(OSError, FileError):
            holder = f" ({read_small_text(folder / HOLDER_NAME, 'a name', 1000)})"
        raise BusyError(f"another run is writing this output{holder}", folder)

    def release(self) -> None:
        """Give the lock back, and remove the folder if nothing else is in it."""
        with suppress(OSError):
            (self.folder / HOLDER_NAME).unlink(missing_ok=True)
        _remove_if_empty(self.folder)
        self.lock.release()


def _remove_if_empty(folder: Path) -> None:
    """Remove a folder in which there is only the lock. Whoever calls holds the lock, where there are locks."""
    with suppress(OSError):
        files = list(folder.iterdir())
        if all(path.name == LOCK_NAME for path in files):
            atomic_files.remove_folder(folder, *files)


def _require_own(folder: Path) -> None:
    """Raise FileError if `folder` or the lock in it is a link or something else, or if the folder is another user's.

    A run neither writes nor removes what a link leads to. Whoever owns the folder may put any increments into it.
    """
    with suppress(FileNotFoundError):
        _require_kind(folder, stat.S_ISDIR)
        owner = folder.stat().st_uid
        # Who owns the folder around it may replace it anyway. Some file systems show one owner for all files.
        if owner not in (os.geteuid(), folder.absolute().parent.stat().st_uid):
            message = f"belongs to another user ({_user_name(owner)}), so a run does not write there: copy it (cp -r)"
            raise FileError(f"{message} to go on with it, or give another name with -o", folder)
        _require_kind(folder / LOCK_NAME, stat.S_ISREG)


def _require_kind(path: Path, is_right: Callable[[int], bool]) -> None:
    """Raise FileError if `path` is a link or of another kind, FileNotFoundError if it is not there."""
    mode = path.lstat().st_mode
    if not is_right(mode):
        what = "is a link, which a run does not follow" if stat.S_ISLNK(mode) else "is in the way of a run's own"
        raise FileError(f"{what}: remove it, or give another name with -o", path)


def _user_name(number: int) -> str:
    with suppress(KeyError):
        return pwd.getpwuid(number).pw_name
    return str(number)


def is_locked(folder: Path) -> bool:
    """Return whether a run is writing in `folder`. A shared lock, which filelock lacks, keeps no other reader out."""
    with suppress(OSError):
        file = os.open(folder / LOCK_NAME, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        finally:
            os.close(file)
    return False
