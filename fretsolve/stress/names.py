"""Names of stress quantities and of their file. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from fretsolve.errors import FileError
from fretsolve.system.foreign_files import open_hdf5

Invariant = Literal["mises", "tension", "tresca"]

INVARIANTS: tuple[Invariant, ...] = ("mises", "tension", "tresca")

PEAK_NAMES = tuple(f"max_{name}" for name in INVARIANTS)
"""Columns with the largest stresses."""


def stress_path(result: Path) -> Path:
    """Return the name of the file of stresses beside a result."""
    return result.with_suffix(".stress.h5")


def is_stress_file(path: Path) -> bool:
    """Return whether `path` is a file of stresses; False for what is not HDF5 at all, or damaged."""
    try:
        with open_hdf5(path) as file:
            return "stress" in file and "history" not in file
    except (OSError, KeyError, RuntimeError, FileError):
        return False
