"""An `os` whose n-th change on disk fails, or is the last one before a kill or a power cut."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

CHANGES = ("open", "ftruncate", "write", "fsync", "replace", "link", "unlink", "mkdir", "rmdir")


class SimulatedKillError(OSError):
    """Stands for the end of the process: nothing reaches the disk any more."""


class FaultyOs:
    """Passes all on to `os`, but for the change number `fail_at` (from 0; none if negative).

    kind "error": that change fails once, as on a full disk. kind "kill": it and all later ones do not happen,
    a write is torn in half. kind "power cut": besides, what was not synced is lost: renames, removals and
    folders since the last sync of their folder, and the second half of files that were not synced.
    """

    def __init__(self, fail_at: int = -1, kind: str = "error"):
        self.fail_at = fail_at
        self.kind = kind
        self.calls: list[str] = []
        self._dead = False
        self._paths: dict[int, Path] = {}
        self._unsynced_files: set[Path] = set()
        self._undo: list[tuple[Path, Callable[[], None]]] = []

    def __getattr__(self, name: str) -> Any:
        real = getattr(os, name)
        if name not in CHANGES:
            return real

        def change(*arguments: Any) -> Any:
            self._meet_fault(name, arguments)
            undo = self._how_to_undo(name, arguments) if self.kind == "power cut" else None
            result = real(*arguments)
            self._note(name, arguments, result, undo)
            return result

        return change

    def _meet_fault(self, name: str, arguments: tuple[Any, ...]) -> None:
        if self._dead:
            raise SimulatedKillError(errno.EIO, "killed")
        self.calls.append(name)
        if len(self.calls) - 1 != self.fail_at:
            return
        if self.kind == "error":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if name == "write":
            descriptor, data = arguments
            os.write(descriptor, data[: len(data) // 2])
        self._dead = True
        if self.kind == "power cut":
            self._cut_power()
        raise SimulatedKillError(errno.EIO, "killed")

    def _how_to_undo(self, name: str, arguments: tuple[Any, ...]) -> tuple[Path, Callable[[], None]] | None:
        if name == "replace":
            source, target = map(Path, arguments)
            before = target.read_bytes() if target.exists() else None
            return target.parent, lambda: _restore(target, before, source)
        if name == "link":
            return Path(arguments[1]).parent, lambda: Path(arguments[1]).unlink(missing_ok=True)
        if name in ("unlink", "mkdir", "rmdir"):
            path = Path(arguments[0])
            if name == "unlink" and path.exists():
                data = path.read_bytes()
                return path.parent, lambda: _restore(path, data)
            if name == "mkdir":
                return path.parent, lambda: _remove_tree(path)
            if name == "rmdir":
                return path.parent, path.mkdir
        return None

    def _note(self, name: str, arguments: tuple[Any, ...], result: Any, undo: Any) -> None:
        if undo is not None:
            self._undo.append(undo)
        if name == "open":
            self._paths[result] = Path(arguments[0])
        elif name in ("write", "ftruncate"):
            self._unsynced_files.add(self._paths[arguments[0]])
        elif name == "fsync":
            path = self._paths[arguments[0]]
            self._unsynced_files.discard(path)
            self._undo = [entry for entry in self._undo if entry[0] != path]
        elif name == "replace" and Path(arguments[0]) in self._unsynced_files:
            self._unsynced_files.remove(Path(arguments[0]))
            self._unsynced_files.add(Path(arguments[1]))

    def _cut_power(self) -> None:
        for path in self._unsynced_files:
            if path.exists():
                os.truncate(path, path.stat().st_size // 2)
        for _, undo in reversed(self._undo):
            undo()


def _restore(path: Path, data: bytes | None, moved_from: Path | None = None) -> None:
    if moved_from is not None and path.exists() and moved_from.parent.exists():
        moved_from.write_bytes(path.read_bytes())
    if data is None:
        path.unlink(missing_ok=True)
    elif path.parent.exists():
        path.write_bytes(data)


def _remove_tree(folder: Path) -> None:
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()
