"""Names of stress quantities and of their file. Loads no NumPy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    """Return whether `path` is there, undamaged, and was computed from a result of the same case."""
    with suppress(FileError):
        require_made_from(result, path)
        return True
    return False


def require_made_from(result: Result, path: Path) -> None:
    """Raise FileError unless the file at `path` was computed from a result of the same case."""
    with opened_computed(path) as found:
        if found is None or found.attributes.get("effective_case") != result.attributes["effective_case"]:
            raise FileError(f"was not computed from {result.path.name}: make it again", path)


@dataclass(frozen=True, eq=False)
class ComputedFile:
    """An open file of what was computed from a result; attributes, content: of its header."""

    kind: Literal["stress", "fatigue"]
    file: Any
    attributes: Mapping[str, Any]
    content: Mapping[str, Any]


@contextmanager
def opened_computed(path: Path) -> Iterator[ComputedFile | None]:
    """Open a file of stresses or fatigue parameters; None for a result, or what is not HDF5 at all.

    Attributes are those of the header, which has a checksum. Raises FileError if it is damaged or missing.
    """
    with ExitStack() as opened:
        found = None
        with suppress(OSError, KeyError, RuntimeError, FileError):
            file = opened.enter_context(open_hdf5(path))
            if "history" not in file:
                found = next(((kind, file) for kind in _KINDS if kind in file), None)
        if found is None:
            opened.close()
            yield None
        else:
            yield ComputedFile(*found, *_header_of(path, *found))


def _header_of(path: Path, kind: str, file: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the attributes and the content in the header of a file. Raises FileError."""
    from fretsolve.result.header import read_sealed
    from fretsolve.result.part_reader import damage_reported

    with damage_reported(path, "the header"):
        if "header" not in file:
            message = "has no header with a checksum: it is damaged, or of another program"
            raise FileError(f"{message}; `fretsolve {kind} RESULT --overwrite` makes it again", path)
        attributes, content = read_sealed(file)
        if not str(attributes["format"]).startswith(f"fretsolve {kind} ") or not isinstance(content, dict):
            raise ValueError(f"the header is not that of a file that `fretsolve {kind}` writes")
        return attributes, content
