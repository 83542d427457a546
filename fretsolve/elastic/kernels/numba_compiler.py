"""Compile loops by numba, and keep them on disk; count the time of that. Only where numba is used this is imported.

Files of the cache have checksums: damaged code would crash, or give other numbers.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.caching import FunctionCache, IndexDataCacheFile

from fretsolve.errors import FileError
from fretsolve.system.files import read_bytes

if getattr(numba.config, "DISABLE_JIT", False):  # Python itself would run the loops over cells
    raise ImportError("NUMBA_DISABLE_JIT is set")

_DIGEST_SIZE = hashlib.sha256().digest_size


def compiled_form(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return what compiles a function at its first call, and keeps it on disk if there is a place for it."""
    # C calls none, and Python none whose name begins with an underscore; each way in takes the compiler time.
    options = options | {"no_cfunc_wrapper": True, "no_cpython_wrapper": function.__name__.startswith("_")}
    compiled: Any = numba.njit(nogil=True, error_model="numpy", **options)(function)
    with suppress(RuntimeError):  # neither the package's folder nor the user's cache can be written
        try:
            compiled._cache = KernelCache(function)
        except (AttributeError, TypeError):  # another numba, whose cache has other parts: without checksums
            compiled.enable_caching()
    return compiled


class KernelCache(FunctionCache):
    """The compiled forms of a kernel on disk. Whatever cannot be read is compiled again, and replaced if possible.

    Raises RuntimeError if there is no folder that can be written.
    """

    def __init__(self, function: Any):
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp(), _stamp_of_kernels()
        self._cache_file = _CheckedFiles(self.cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled form for a signature, None if there is none."""
        with suppress(Exception):  # whatever unpickling raises for a file of another version
            return super().load_overload(sig, target_context)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a compiled form. A disk that is full is no error."""
        with suppress(OSError):
            super().save_overload(sig, data)


class _CheckedFiles(IndexDataCacheFile):
    """The files of a kernel, each with its SHA-256 at the end, which unpickling ignores."""

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BytesIO]:
        with super()._open_for_write(filepath) as file:
            yield (content := BytesIO())
            file.write(content.getvalue() + hashlib.sha256(content.getvalue()).digest())

    def _load_index(self) -> Any:
        return super()._load_index() if _is_whole(self._index_path) else {}

    def _load_data(self, name: str) -> Any:
        if not _is_whole(path := self._data_path(name)):
            raise OSError(f"{path} is damaged")  # which numba takes as if there were no file
        return super()._load_data(name)


def _stamp_of_kernels() -> tuple[tuple[str, int, int], ...]:
    """Return what tells the modules of kernels from others: a compiled kernel holds constants and code of several."""
    found = ((path.name, path.stat()) for path in sorted(Path(__file__).parents[2].glob("*/kernels/*.py")))
    return tuple((name, status.st_mtime_ns, status.st_size) for name, status in found)


def _is_whole(path: str) -> bool:
    """Return whether a file of the cache is there and ends with the checksum of what is before."""
    with suppress(OSError, FileError):
        # a kernel takes some 100 kB
        content = read_bytes(Path(path), 2**26)
        return hashlib.sha256(content[:-_DIGEST_SIZE]).digest() == content[-_DIGEST_SIZE:]
    return False


def _clock(name: str) -> Callable[[], float]:
    """Return a function that returns the wall-clock time (s) of one kind of the compiler's events in this process."""
    listener = event.TimingListener()
    event.register(name, listener)
    return lambda: float(listener.duration) if listener.done else 0.0


class _FirstCompilation(event.Listener):
    """Calls `tell` when a kernel is compiled, once."""

    tell: Callable[[], None] | None = None

    def on_start(self, event: Any) -> None:
        tell, self.tell = self.tell, None
        if tell is not None:
            tell()

    def on_end(self, event: Any) -> None:
        pass


_first_compilation = _FirstCompilation()
event.register("numba:compile", _first_compilation)


def when_compiling(tell: Callable[[], None]) -> None:
    """Call `tell` when the next kernel is compiled; kernels on disk are not compiled."""
    _first_compilation.tell = tell


compile_seconds = _clock("numba:compile")
readying_seconds = _clock("numba:compiler_lock")
