"""Files of stresses, fatigue parameters or a crack of a result: a sealed header and a group per body."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar

from fretsolve.errors import FileError
from fretsolve.result import Result
from fretsolve.result.header import read_sealed
from fretsolve.result.layout import FIELD_FILTERS, Quantity
from fretsolve.result.part_reader import damage_reported, require
from fretsolve.system.files import reported
from fretsolve.system.hdf5_files import open_hdf5, own_node

Kind = Literal["stress", "fatigue", "crack"]
"""The command that writes the file."""

CONTENTS: dict[Kind, str] = {"stress": "stresses", "fatigue": "fatigue parameters", "crack": "a crack"}

DEPTH = Quantity("depth", "mm", "distance from the surface into the body")

OfBody = TypeVar("OfBody")


@dataclass(frozen=True, eq=False)
class ComputedFile:
    """An open file of what was computed from a result; attributes, content: of its header."""

    path: Path
    kind: Kind
    file: Any
    attributes: Mapping[str, Any]
    content: Mapping[str, Any]

    def bodies(self, kind: Kind, read: Callable[[Path, Any, Any], OfBody]) -> dict[int, OfBody]:
        """Return what `read` makes of the path, the group and the content of each body, by their numbers.

        Raises FileError if the file is not of `kind`, or is damaged.
        """
        if self.kind != kind or not self.content:
            raise not_of_kind(kind, self.path)
        with damage_reported(self.path, _words(kind)):
            return {
                int(number): read(self.path, own_node(self.file, f"{kind}/body_{number}"), content)
                for number, content in self.content.items()
            }


def _words(kind: Kind) -> str:
    return f"the {CONTENTS[kind].split()[-1]}"


def not_of_kind(kind: Kind, path: Path) -> FileError:
    """Return the error of a file that is not of a kind."""
    return FileError(f"is not a file of {CONTENTS[kind]}, which `fretsolve {kind}` writes", path)


@contextmanager
def opened_computed(path: Path) -> Iterator[ComputedFile | None]:
    """Open a file that was computed from a result; None for a result itself, or what is not HDF5 at all.

    Attributes come from the header, which has a checksum. Raises FileError if the header is damaged or missing, or if
    the disk fails.
    """
    with ExitStack() as opened:
        file = _opened(path)
        found = None if file is None else _described(path, opened.enter_context(file))
        if found is None:
            opened.close()
        yield found


def _opened(path: Path) -> Any | None:
    """Return an open HDF5 file, None if there is none at `path`, or none that HDF5 can open. Raises FileError."""
    try:
        return open_hdf5(path)
    except (OSError, RuntimeError, FileError) as error:
        if getattr(error, "errno", None) in (None, errno.ENOENT, errno.ENOTDIR):
            return None
        with damage_reported(path):
            raise


def _described(path: Path, file: Any) -> ComputedFile | None:
    """Return an open file with what its header says, None if it is not one that was computed. Raises FileError."""
    with damage_reported(path, "the header"):
        if "header" in file:
            attributes, content = read_sealed(file)
            form = str(attributes.get("format", ""))  # results have none
            kind = next((one for one in CONTENTS if form.startswith(f"fretsolve {one} ")), None)
            require(isinstance(content, dict), "the header", "what is in the file")
            if kind is None:
                return None
            with damage_reported(path, _words(kind)):
                for number in content:
                    own_node(file, f"{kind}/body_{number}")
            return ComputedFile(path, kind, file, attributes, content)
        kind = None if "history" in file else next((one for one in CONTENTS if one in file), None)
    if kind is not None:
        message = "has no header with a checksum: it is damaged, or of another program"
        raise FileError(f"{message}; `fretsolve {kind} RESULT --overwrite` makes it again", path)
    return None


@contextmanager
def opened_beside(path: Path, kind: Kind, result: Result | None) -> Iterator[ComputedFile]:
    """Open a file of a kind. Raises FileError if it is damaged, of another kind, or not computed from `result`."""
    if result is not None:
        require_made_from(result, path)
    with reported("cannot be read", path), opened_computed(path) as found:
        if found is None:
            require_readable(path)
            raise not_of_kind(kind, path)
        yield found


def is_made_from(result: Result, path: Path) -> bool:
    """Return whether `path` is there, undamaged, and was computed from a result of the same case."""
    with suppress(FileError):
        require_made_from(result, path)
        return True
    return False


def require_made_from(result: Result, path: Path) -> None:
    """Raise FileError unless the file at `path` was computed from a result of the same case, or if it is damaged."""
    with opened_computed(path) as found:
        if found is None:
            require_readable(path)
        if found is None or found.attributes.get("effective_case") != result.attributes["effective_case"]:
            raise FileError(f"was not computed from {result.path.name}: make it again", path)


def require_readable(path: Path) -> None:
    """Raise FileError if a file is missing, or is so damaged that HDF5 cannot tell what is in it."""
    with reported("cannot be read", path), damage_reported(path), open_hdf5(path) as file:
        list(file)


def create_values(
    group: Any, name: str, scales: Sequence[Any], dtype: str, chunks: tuple[int, ...], **attributes: str
) -> Any:
    """Create a dataset over the axes `scales`, and return it; attributes: `units` and `long_name`."""
    shape = tuple(map(len, scales))
    dataset = group.create_dataset(name, shape, dtype, chunks=chunks, **FIELD_FILTERS)
    dataset.attrs.update(attributes)
    for axis, scale in enumerate(scales):
        dataset.dims[axis].attach_scale(scale)
    return dataset
