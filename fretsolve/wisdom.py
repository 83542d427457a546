"""FFTW's wisdom: what its planner measured on this machine, kept between runs in the user's cache folder."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import Any

from fretsolve.fftw import pyfftw

MEASURED_POINTS = 300 * 300
"""Padded sizes up to this many points are planned by FFTW's estimate: measuring takes 0.4 s and gains a tenth."""


def planner_effort(padded: tuple[int, int]) -> str:
    """FFTW's planner flag for a padded grid."""
    return "FFTW_ESTIMATE" if padded[0] * padded[1] <= MEASURED_POINTS else "FFTW_MEASURE"


_plans_made = 0  # as FFTW's wisdom itself, this is the process's


def plan(*arguments: Any, **options: Any) -> pyfftw.FFTW:
    """A plan of FFTW, counted in `plans_made`."""
    global _plans_made
    _plans_made += 1
    return pyfftw.FFTW(*arguments, **options)


def plans_made() -> int:
    """How many plans this process has made; as many may have been measured since the wisdom was last saved."""
    return _plans_made


def wisdom_file() -> Path:
    """Where the wisdom is kept: ``$FRETSOLVE_CACHE``, or fretsolve in the user's cache folder."""
    folder = os.environ.get("FRETSOLVE_CACHE")
    if folder is None:
        cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        folder = str(Path(cache) / "fretsolve")
    return Path(folder) / f"fftw-wisdom-{pyfftw.__version__}"


def load_wisdom() -> bool:
    """Tell FFTW what earlier runs measured; False where there is nothing, or nothing readable."""
    try:
        parts = wisdom_file().read_bytes().split(b"\0")
    except (OSError, RuntimeError):
        return False
    return len(parts) == 3 and all(pyfftw.import_wisdom(tuple(parts))[:2])


def save_wisdom() -> None:
    """Keep what FFTW knows by now; a cache that cannot be written is no error."""
    with contextlib.suppress(OSError, RuntimeError):
        path = wisdom_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        content = b"\0".join(pyfftw.export_wisdom())
        if path.exists() and path.read_bytes() == content:
            return
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(name).replace(path)
