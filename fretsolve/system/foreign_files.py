"""Read files that others may have made or damaged: regular files of a plausible size, and HDF5 that holds its own data.

Loads no h5py until an HDF5 file is opened.
"""

from __future__ import annotations

import errno
import itertools
import os
import select
import stat
import subprocess
import sys
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from fretsolve.errors import FileError
from fretsolve.system.files import reported

LARGEST_RATIO = 1100
"""Bytes of numbers for a stored byte. zlib reaches 1032; data that take more are not in the file."""

TRIAL_SECONDS = 10
"""Processor time for all attributes of an HDF5 file, which takes milliseconds."""

PIPE_SECONDS = 15.0
"""Within which a pipe must give its text and be closed."""

MOST_NODES, DEEPEST = 2**15, 64
"""Groups and datasets of an HDF5 file, and groups within one another."""

NO_LOCKS = {errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP}
"""Errors of a file system on which nobody can hold a lock. On ENOSYS filelock takes the file itself as lock."""

PICTURE_MARK = "drawn by fretsolve"
"""In the metadata of every picture, by which one is known before it is replaced."""

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


def open_hdf5(path: Path) -> Any:
    """Open an HDF5 file for reading, without a lock where the file system has none: the file is whole.

    With one elsewhere, since HDF5 opens no file of a process in both ways. Raises FileError if it is not a regular
    file, OSError.
    """
    import h5py

    require_regular(path)
    try:
        return h5py.File(path, "r")
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        return h5py.File(path, "r", locking=False)


def try_attributes(path: Path) -> None:
    """Raise FileError if HDF5 crashes or does not come to an end with the attributes of `path`.

    Texts in them have no checksum, and HDF5 may loop without end on damage. So another process tries it first.
    """
    with reported("cannot be read", path):
        found = path.stat()
    _try_attributes(path.absolute(), found.st_size, found.st_mtime_ns)


@cache
def _try_attributes(path: Path, size: int, changed: int) -> None:
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
    import h5py

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
    import h5py

    node = group
    for part in name.split("/"):
        if not isinstance(node, h5py.Group):
            raise ValueError(f"{node.name} is not a group")
        if node.id.links.get_info(part.encode()).type != h5py.h5l.TYPE_HARD:  # KeyError if there is none
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
    import h5py

    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{name} is not a dataset")
    if dataset.shape is None:
        raise ValueError(f"{name} has no values")
    layout = dataset.id.get_create_plist()
    if layout.get_layout() == h5py.h5d.VIRTUAL or layout.get_external_count():
        raise ValueError(f"the values of {name} lie in other files, which are not read")
    if dataset.nbytes > LARGEST_RATIO * dataset.id.get_storage_size():
        raise ValueError(f"{name} of {dataset.nbytes} bytes is not in the file")
