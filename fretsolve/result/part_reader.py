"""Read a part of a run or a result, which are alike, and name what is damaged in it.

What cannot be the history, the grid or a field of a result is refused, whatever has happened to its file. Functions
raise ValueError or KeyError for it, which `damage_reported` turns into a message.
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any, SupportsIndex
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError, shortened
from fretsolve.result.header import RunHeader, read_sealed
from fretsolve.result.history import History
from fretsolve.result.layout import DERIVED_FIELDS, ERRORS, FIELDS, QUANTITIES, STEP, optional_among, row_type
from fretsolve.result.state import ZONE_NAMES
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import reason_of
from fretsolve.system.hdf5_files import open_hdf5, own_dataset, own_node

_REASONS = {
    "truncated file": "the file is truncated: it was not copied or written to its end",
    "file signature not found": "not an HDF5 file, so no result of a run",
    "filter returned failure": "{} is damaged: the checksum does not match",
    "checksum": "{} is damaged: the checksum does not match",
}
"""The meaning of parts of HDF5's messages."""

_DAMAGE = (
    *(ArithmeticError, AttributeError, LookupError, MemoryError, TypeError, ValueError),
    *(BadZipFile, EOFError, struct.error, zlib.error),  # of files of NumPy
)
"""What reading a damaged file raises, besides OSError and RuntimeError of HDF5."""

RUN = "run"
"""Attribute of a part with the digest of its run."""


class Steps(tuple[int, ...]):
    """Increments, of which one of many is found at once."""

    @cached_property
    def _places(self) -> dict[int, int]:
        return {step: place for place, step in reversed(list(enumerate(self)))}

    def __contains__(self, step: object) -> bool:
        return step in self._places

    def index(self, step: int, *limits: SupportsIndex) -> int:
        """Return the place of an increment. Raises ValueError if it is not there."""
        return super().index(step, *limits) if limits or step not in self else self._places[step]


class PartReader(AbstractContextManager["PartReader"]):
    """An open part or result file. Raises FileError if it is damaged.

    field_steps: the increments whose fields it has; field_names: the names of these.
    """

    def __init__(self, path: Path):
        self.path = path
        with damage_reported(path), ExitStack() as opened:
            self.file = opened.enter_context(open_hdf5(path))
            steps = _read_column(own_dataset(self.file, "fields/step"))
            require(steps.dtype.kind in "iu", "fields/step", "whole numbers, one per increment")
            self.field_steps = Steps(steps.tolist())
            self._fields: dict[str, Any] = {}
            self.field_names = [one.name for one in FIELDS + DERIVED_FIELDS if one.name in self.file["fields"]]
            opened.pop_all()

    def __exit__(self, *_: object) -> None:
        self.file.close()

    @cached_property
    def rows(self) -> NDArray[Any]:
        """The history, a record per increment, with the error bars if there are any."""
        with damage_reported(self.path, "history"):
            if "rows" in self.file:
                return _read_column(own_dataset(self.file, "rows"), kinds="V")
            group = own_node(self.file, "history")
            columns = {name: _read_column(own_dataset(group, name)) for name in group if name in QUANTITIES}
            return _row_records(columns)

    def summaries(self) -> History:
        """Return the summaries of all increments."""
        return History.of_rows([self.rows])

    @cached_property
    def grid(self) -> tuple[DoubleArray, DoubleArray]:
        """x and y of the cell centres of a result file."""
        with damage_reported(self.path, "grid"):
            x, y = (_read_column(own_dataset(self.file, f"fields/{axis}")) for axis in ("x", "y"))
            return x, y

    def require_content(self, content: Mapping[str, Any]) -> None:
        """Raise FileError unless columns, axes and names of fields agree with a result's `content_of`."""
        with damage_reported(self.path, "header"):
            found = content_of(self.rows, *self.grid, self.field_steps, self.field_names)
            # A newer version may have more columns and fields.
            changed = [name for name, digest in found["columns"].items() if content["columns"].get(name) != digest]
            changed += sorted({name for name in content["fields"] if name in QUANTITIES} ^ set(found["fields"]))
        if changed:
            raise FileError(f"{', '.join(changed[:3])} was changed: it differs from the header", self.path)

    def require_part(self, header: RunHeader, first: int, last: int) -> None:
        """Raise FileError unless this is a part of a run, with the increments `first` to `last`.

        A result that has become a part does not name its run, but has a header of its own.
        """
        with damage_reported(self.path, RUN):
            if "rows" not in self.file:
                self.require_content(read_sealed(self.file)[1])
            elif self.file.attrs.get(RUN) != header.digest.encode():
                raise FileError("is a part of another run", self.path)
        if self.rows.dtype != header.row_type:
            raise FileError("does not have the columns of this run", self.path)
        with damage_reported(self.path):
            named = self.rows["step"].tolist() == list(range(first, last + 1))
            require(named, "rows", "the increments that the name says")
        self.require_steps(header.stores_fields)
        self.require_fields(header.shape)

    def require_steps(self, stores_fields: Callable[[int], bool]) -> None:
        """Raise FileError unless `field_steps` are the stored increments. A result stores the last increment, too."""
        with damage_reported(self.path, "fields/step"):
            steps = self.rows["step"].tolist()
            stored = tuple(step for step in steps if stores_fields(step))
            right = self.field_steps in (stored, (*stored, *steps[-1:]))
            require(right, "fields/step", "the increments that are stored")

    def require_fields(self, shape: tuple[int, int]) -> None:
        """Raise FileError unless the fields have a plane of `shape` for each of `field_steps`."""
        with damage_reported(self.path, "fields"):
            for name in self.field_names:
                dataset = own_dataset(self.file, f"fields/{name}")
                right = dataset.shape == (len(self.field_steps), *shape)
                require(right, f"fields/{name}", f"{len(self.field_steps)} planes of {shape[0]} x {shape[1]} cells")

    def read(self, name: str, step: int) -> NDArray[Any]:
        """Return a field ``(nx, ny)`` at `step`, one of `field_steps`."""
        with damage_reported(self.path, f"fields/{name} of increment {step}"):
            return checked_plane(name, np.asarray(self._field(name)[self.field_steps.index(step)]))

    def _field(self, name: str) -> Any:
        """Return the dataset of a field, checked once: HDF5 takes longer to measure one of many planes than to read it.

        Raises KeyError or ValueError.
        """
        if name not in self._fields:
            dataset, count = own_dataset(self.file, f"fields/{name}"), len(self.field_steps)
            require(len(dataset) == count, f"fields/{name}", f"{count} planes, one per stored increment")
            self._fields[name] = dataset
        return self._fields[name]

    def verify(self) -> None:
        """Read all fields, so that their checksums are compared. Raises FileError."""
        for name in self.field_names:
            for step in self.field_steps:
                self.read(name, step)


def require(holds: object, name: str, what: str) -> None:
    """Raise ValueError unless `holds`; name: of the dataset; what: it must hold that."""
    if not holds:
        raise ValueError(f"{name} must hold {what}")


def checked_plane(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """Return a field of one increment. Raises ValueError if the field cannot have these values."""
    kinds = ("uint8",) if name == "zone" else ("float32", "float64")
    require(values.ndim == 2 and values.size and values.dtype in kinds, name, "a number per cell")
    if name == "zone":
        require(values.max() < len(ZONE_NAMES), name, "zones")
    elif name == "gap":
        require((values > -np.inf).all(), name, "numbers, infinite only off a body")  # False for NaN
    else:
        require(np.isfinite(values).all(), name, "finite numbers")
    return values


def _read_column(dataset: Any, kinds: str = "iuf") -> NDArray[Any]:
    """Return a column of numbers. Raises ValueError if it is none, or far larger than its stored bytes."""
    name = dataset.name.lstrip("/")
    require(dataset.ndim == 1 and dataset.dtype.kind in kinds, name, "numbers, one per increment")
    # Histories of runs compress to a third. A small file may hold more, which memory has room for.
    if dataset.nbytes > max(2**28, 32 * dataset.id.get_storage_size()):
        raise ValueError(f"{name} would take {dataset.nbytes} bytes, far more than there are in the file")
    return np.asarray(dataset[:])


def read_columns(group: Any, digests: Mapping[str, str]) -> dict[str, NDArray[Any]]:
    """Return the columns of an HDF5 group. Raises ValueError or KeyError unless they have these `digests_of`."""
    columns = {name: _read_column(own_dataset(group, name)) for name in digests}
    for name, digest in digests_of(columns).items():
        require(digest == digests[name], name, "what the header says, it was changed")
    return columns


def digests_of(columns: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    """Return 16 digits of the SHA-256 of each column."""
    return {name: hashlib.sha256(column.tobytes()).hexdigest()[:16] for name, column in columns.items()}


def content_of(
    rows: NDArray[Any], x: DoubleArray, y: DoubleArray, steps: Sequence[int], names: Sequence[str]
) -> dict[str, Any]:
    """Return the digests of the columns and axes of a result, and the names of its fields."""
    arrays = {name: rows[name] for name in rows.dtype.names or ()}
    arrays |= {"x": x, "y": y, "step of fields": np.array(steps, STEP.dtype)}
    return {"columns": digests_of(arrays), "fields": list(names)}


def _row_records(columns: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
    """Return columns as a record per increment. Raises KeyError or ValueError if one is missing or too short."""
    rows = np.empty(columns["step"].shape, row_type(ERRORS[0].name in columns, optional_among(columns.keys())))
    for name in rows.dtype.names or ():
        require(columns[name].shape == rows.shape, name, f"{len(rows)} numbers, one per increment")
        rows[name] = columns[name]
    return rows


@contextmanager
def damage_reported(path: Path, what: str = "") -> Iterator[None]:
    """Turn what h5py raises on reading `path` into a FileError, except FileNotFoundError."""
    try:
        yield
    except FileNotFoundError:
        raise
    except PermissionError as error:
        raise FileError("no permission to read the file", path) from error
    except IsADirectoryError as error:
        raise FileError("a folder; the file of a result is needed", path) from error
    except (OSError, KeyError, RuntimeError) as error:
        missing = isinstance(error, KeyError) and str(error.args[0] if error.args else "")
        if missing and " " not in missing:
            raise FileError(f"cannot read {what or 'the file'}: {shortened(missing)} is missing", path) from error
        message, what = reason_of(error) if isinstance(error, OSError) else str(error), what or "the file"
        reasons = (reason.format(what) for part, reason in _REASONS.items() if part in message)
        raise FileError(next(reasons, f"cannot read {what}: {shortened(message)}"), path) from error
    except _DAMAGE as error:
        raise FileError(f"cannot read {what or 'the file'}: {shortened(str(error))}", path) from error
