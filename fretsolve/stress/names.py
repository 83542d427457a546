"""Names of stress quantities and of their file. Loads no NumPy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fretsolve.errors import FileError
from fretsolve.system.foreign_files import open_hdf5

if TYPE_CHECKING:
    from fretsolve.result import Result

_KINDS: tuple[Literal["stress", "fatigue"], ...] = ("stress", "fatigue")

Invariant = Literal["mises", "tension", "tresca"]

INVARIANTS: tuple[Invariant, ...] = ("mises", "tension", "tresca")

OUTERMOST = "in the last cells that were looked at: it may be larger beyond; a larger --window shows"
"""What is said of a largest value at the end of the window."""

PEAK_NAMES = tuple(f"max_{name}" for name in INVARIANTS)
"""Columns with the largest stresses."""


def stress_path(result: Path) -> Path:
    """Return the name of the file of stresses beside a result."""
    return result.with_suffix(".stress.h5")


def is_made_from(result: Result, path: Path) -> bool:
    """Return whether `path` is there, and was computed from a result of the same case."""
    with suppress(OSError, KeyError, RuntimeError, FileError), open_hdf5(path) as file:
        return bool(file.attrs["effective_case"] == result.attributes["effective_case"])
    return False


@dataclass(frozen=True, eq=False)
class ComputedFile:
    """An open file of what was computed from a result."""

    kind: Literal["stress", "fatigue"]
    file: Any


@contextmanager
def opened_computed(path: Path) -> Iterator[ComputedFile | None]:
    """Open a file of stresses or fatigue parameters; None for a result, what is not HDF5 at all, or damaged."""
    with ExitStack() as opened:
        found = None
        with suppress(OSError, KeyError, RuntimeError, FileError):
            file = opened.enter_context(open_hdf5(path))
            if "history" not in file:
                found = next((ComputedFile(kind, file) for kind in _KINDS if kind in file), None)
        if found is None:
            opened.close()
        yield found
