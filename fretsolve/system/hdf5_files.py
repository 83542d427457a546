"""Read HDF5 files that others may have made or damaged, which must hold their own data."""

from __future__ import annotations

import itertools
import os
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import h5py

from fretsolve.errors import FileError
from fretsolve.system.files import FilledFile, reported, require_regular

LARGEST_RATIO = 1100
"""Bytes of numbers for a stored byte. zlib reaches 1032; data that take more are not in the file."""

TRIAL_SECONDS = 10
"""Processor time for all attributes of an HDF5 file, which takes milliseconds."""

MOST_NODES, DEEPEST = 2**15, 64
"""Groups and datasets of an HDF5 file, and groups within one another."""

_TRIAL = """
import sys
file, seconds, most_nodes, *sys.path = sys.argv[1:]
import resource
import h5py
used, most = resource.getrusage(resource.RUSAGE_SELF), int(seconds)
most += int(used.ru_utime + used.ru_stime)
resource.setrlimit(resource.RLIMIT_CPU, (most, most))
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
try:
    with h5py.File(file, "r", locking=False) as opened:
        dict(opened.attrs)
        left = iter(range(int(most_nodes)))
        opened.visititems(lambda name, node: [dict(node.attrs)] and (None if next(left, None) is not None else True))
except Exception:
    pass  # the caller meets it, too, and reports it
print("ended")
"""


class _OpenedFile(FilledFile):
    """A file that is only read, so that an error of its closing means nothing: all that was needed has been read."""

    def close(self) -> None:
        with suppress(OSError):
            super().close()

    __del__ = close  # without the warning of a file that nobody has closed: h5py closes such files


class OpenedHDF5(h5py.File):  # type: ignore[misc]  # h5py has no types
    """An HDF5 file that is read through Python's files.

    Errors of the disk keep their numbers then. If HDF5 met an error of closing, the file would stay in its tables, and
    the interpreter might crash at exit.
    """

    def __init__(self, path: Path):
        """Open it. Raises OSError."""
        self._stream = _OpenedFile(path)
        try:
            super().__init__(self._stream, "r")
        except BaseException:
            self._stream.close()
            raise

    def close(self) -> None:
        """Close it."""
        super().close()
        self._stream.close()


def open_hdf5(path: Path) -> OpenedHDF5:
    """Open an HDF5 file for reading, without a lock: it is whole.

    Raises FileError if it is not a regular file, OSError.
    """
    require_regular(path)
    return OpenedHDF5(path)


def try_attributes(path: Path) -> None:
    """Raise FileError if HDF5 crashes or does not come to an end with the attributes of `path`.

    Texts in them have no checksum, and HDF5 may loop without end on damage. So another process tries it first.
    """
    with reported("cannot be read", path):
        found = path.stat()
    _try_attributes(path.absolute(), found.st_size, found.st_mtime_ns)


@cache
def _try_attributes(path: Path, size: int, changed: int) -> None:
    import subprocess  # for files that are no results

    require_regular(path)
    # Isolated, so that no module of the working folder is run; installed ones are found where this process has them.
    words = os.fspath(path), str(TRIAL_SECONDS), str(MOST_NODES), *filter(None, sys.path)
    line = [sys.executable, "-I", "-c", _TRIAL, *words]
    done = subprocess.run(line, capture_output=True, check=False)
    if done.returncode != 0 or done.stdout != b"ended\n":
        raise FileError("is damaged: the HDF5 library cannot read its attributes", path)


def dataset_names(file: Any) -> list[str]:
    """Return the names of all datasets of an HDF5 file, without following a link.

    Raises ValueError if there are too many or too deep groups: HDF5 would take minutes.
    """
    names: list[str] = []
    count = itertools.count(1)

    def visit(name: str, node: Any) -> bool | None:
        if isinstance(node, h5py.Dataset):
            names.append(name)
        return True if next(count) > MOST_NODES or name.count("/") > DEEPEST else None

    if file.visititems(visit):
        raise ValueError(f"it has more than {MOST_NODES} groups and datasets, or {DEEPEST} groups within one another")
    return names


def own_node(group: Any, name: str) -> Any:
    """Return the group or dataset `name` of an HDF5 file or group, without following a link.

    Raises KeyError if there is none, ValueError if a link leads there.
    """
    node = group
    for part in name.split("/"):
        if not isinstance(node, h5py.Group):
            raise ValueError(f"{node.name} is not a group")
        if not node.id.links.exists(part.encode()):
            raise KeyError(part)
        if node.id.links.get_info(part.encode()).type != h5py.h5l.TYPE_HARD:
            raise ValueError(f"{name} is a link to another place, which is not followed")
        node = node[part]
    return node


def own_dataset(group: Any, name: str) -> Any:
    """Return the dataset `name` of an HDF5 file or group, whose values lie in the file itself.

    Raises KeyError if there is none, ValueError if its values lie in other files, or not in the file at all.
    """
    dataset = own_node(group, name)
    require_own_data(dataset, name)
    return dataset


def require_own_data(dataset: Any, name: str) -> None:
    """Raise ValueError unless `dataset` is an HDF5 dataset all of whose values lie in its own file."""
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{name} is not a dataset")
    if dataset.shape is None:
        raise ValueError(f"{name} has no values")
    layout = dataset.id.get_create_plist()
    if layout.get_layout() == h5py.h5d.VIRTUAL or layout.get_external_count():
        raise ValueError(f"the values of {name} lie in other files, which are not read")
    if dataset.nbytes > LARGEST_RATIO * dataset.id.get_storage_size():
        raise ValueError(f"{name} of {dataset.nbytes} bytes is not in the file")
