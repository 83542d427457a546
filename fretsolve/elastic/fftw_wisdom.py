"""FFTW's wisdom: what its planner measured on this machine, kept between runs in the user's cache folder."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Any

from fretsolve.elastic.fftw import pyfftw
from fretsolve.system import atomic_files

MEASURED_POINTS = 300 * 300
"""Padded sizes up to this many points are planned by FFTW's estimate: measuring takes 0.4 s and gains a tenth."""


def planner_effort(padded: tuple[int, int]) -> str:
    """FFTW's planner flag for a padded grid."""
    return "FFTW_ESTIMATE" if padded[0] * padded[1] <= MEASURED_POINTS else "FFTW_MEASURE"


_measured_plans = 0  # as FFTW's wisdom itself, this and what follows is the process's
_known_file: tuple[str, int, int, int] | None = None


def plan(*arguments: Any, flags: tuple[str, ...], **options: Any) -> pyfftw.FFTW:
    """A plan of FFTW; measured ones are counted in `measured_plans`."""
    global _measured_plans
    _measured_plans += "FFTW_MEASURE" in flags
    return pyfftw.FFTW(*arguments, flags=flags, **options)


def measured_plans() -> int:
    """How many measured plans this process has made: as many may be new since the wisdom was last saved.

    Those that FFTW estimates are the same each time, with the same wisdom.
    """
    return _measured_plans


def wisdom_file() -> Path:
    """Where the wisdom is kept: ``$FRETSOLVE_CACHE``, or fretsolve in the user's cache folder."""
    folder = os.environ.get("FRETSOLVE_CACHE")
    if folder is None:
        cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        folder = str(Path(cache) / "fretsolve")
    return Path(folder) / f"fftw-wisdom-{pyfftw.__version__}"


def load_wisdom() -> bool:
    """Tell FFTW what earlier runs measured; False where there is nothing, or nothing readable.

    Nothing is read where this process knows the file already.
    """
    global _known_file
    try:
        path = wisdom_file()
        found = _state_of(path)
        if found == _known_file:
            return True
        parts = path.read_bytes().split(b"\0")
    except (OSError, RuntimeError):
        return False
    loaded = len(parts) == 3 and all(pyfftw.import_wisdom(tuple(parts))[:2])
    _known_file = found if loaded else None
    return loaded


def save_wisdom() -> None:
    """Keep what FFTW knows by now, and what other processes have saved meanwhile; a cache that cannot be written is no
    error."""
    global _known_file
    load_wisdom()
    with contextlib.suppress(OSError, RuntimeError):
        path = wisdom_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        content = b"\0".join(pyfftw.export_wisdom())
        if path.exists() and path.read_bytes() == content:
            return
        with atomic_files.new_file(path, durable=False) as file:
            file.write(content)
            written = _state_of(file.path)
        _known_file = (str(path), *written[1:])


def _state_of(path: Path) -> tuple[str, int, int, int]:
    """What changes when the file is written anew."""
    status = path.stat()
    return str(path), status.st_ino, status.st_mtime_ns, status.st_size
