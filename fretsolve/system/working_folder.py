"""A folder beside a file that is being made, for what only its making needs."""

from __future__ import annotations

import os
import re
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType

from fretsolve.system.atomic_files import STALE
from fretsolve.system.signals import end_by


class _Terminated(BaseException):
    """SIGTERM came."""


@contextmanager
def working_folder(target: Path) -> Iterator[Path]:
    """Yield a new folder beside `target`, which is removed at the end of the block, also at SIGTERM.

    What SIGKILL has left of earlier ones is removed after a day. Raises OSError.
    """
    _remove_stale(target)
    # In the folder of the target, since the folder for temporary files may be small.
    with (
        _unwound_by_sigterm(),
        TemporaryDirectory(dir=target.parent, prefix=f"{target.stem}.", suffix=".tmp") as folder,
    ):
        yield Path(folder)


def _remove_stale(target: Path) -> None:
    """Remove the folders of `target` that a kill has left: own ones with this name, untouched for a day."""
    name = re.compile(re.escape(target.stem) + r"\.[a-z0-9_]{8}\.tmp")
    begun = time.time() - STALE
    for path in target.parent.iterdir():
        if name.fullmatch(path.name) and path.is_dir() and not path.is_symlink():
            with suppress(FileNotFoundError):
                inside = [path, *path.iterdir()]
                if all(one.lstat().st_mtime < begun and one.lstat().st_uid == os.geteuid() for one in inside):
                    shutil.rmtree(path)


@contextmanager
def _unwound_by_sigterm() -> Iterator[None]:
    """Leave the block at SIGTERM, so that it removes its files, and end by the signal then.

    Where something else handles the signal, as in a run, it stays as it is.
    """
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def unwind(number: int, frame: FrameType | None) -> None:
        raise _Terminated

    signal.signal(signal.SIGTERM, unwind)
    try:
        yield
    except _Terminated:
        end_by(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
