"""Read a part of a run or a result, which are alike, without any attribute, and name what is damaged in it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from dataclasses import fields as dataclass_fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError, shortened
from fretsolve.result.checks import (
    MOST_STEP_BYTES,
    checked_plane,
    read_column,
    require,
    require_modest,
    row_records,
    row_type,
)
from fretsolve.result.header import RunHeader
from fretsolve.result.layout import DERIVED_FIELDS, QUANTITIES, RESTART, WEAR
from fretsolve.result.state import Fields, State, Summary, SummaryErrors, WearState
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.foreign_files import open_hdf5, own_dataset, own_node

_PART_NAME = re.compile(r"([0-9]{6,18})-([0-9]{6,18})\.h5")
_REASONS = {
    "truncated file": "the file is truncated: it was not copied or written to its end",
    "file signature not found": "not an HDF5 file, so no result of a run",
    "filter returned failure": "{} is damaged: the checksum does not match",
    "checksum": "{} is damaged: the checksum does not match",
}
"""The meaning of parts of HDF5's messages."""

RUN = "run"
"""Dataset of a part with the digest of its run."""

SUMMARY_NAMES, ERROR_NAMES = (
    tuple(column.name for column in dataclass_fields(kind)) for kind in (Summary, SummaryErrors)
)


@dataclass(frozen=True)
class Part:
    """A committed part of the increments `first` to `last`."""

    path: Path
    first: int
    last: int

    @property
    def increments(self) -> int:
        """The number of increments it holds."""
        return self.last - self.first + 1


def part_of(path: Path) -> Part | None:
    """Return the committed part at `path`, or None if the name is not one of a part."""
    match = _PART_NAME.fullmatch(path.name)
    return Part(path, int(match[1]), int(match[2])) if match else None


class Piece(AbstractContextManager["Piece"]):
    """An open part or result file: both are read alike, without any attribute. Raises FileError if it is damaged.

    field_steps: the increments whose fields it has; field_names: the names of these.
    """

    def __init__(self, path: Path):
        self.path = path
        with damage_reported(path), ExitStack() as opened:
            self.file = opened.enter_context(open_hdf5(path))
            steps = own_dataset(self.file, "fields/step")
            require_modest({"fields/step": steps}, MOST_STEP_BYTES)
            require(steps.ndim == 1 and steps.dtype.kind in "iu", "fields/step", "whole numbers, one per increment")
            self.field_steps: list[int] = steps[:].tolist()
            known = RESTART + DERIVED_FIELDS
            self.field_names = [quantity.name for quantity in known if quantity.name in self.file["fields"]]
            self._rows: NDArray[Any] | None = None
            opened.pop_all()

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def rows(self) -> NDArray[Any]:
        """Return the history, a record per increment, with the error bars if there are any. It is read once."""
        if self._rows is None:
            self._rows = self._read_rows()
        return self._rows

    def _read_rows(self) -> NDArray[Any]:
        with damage_reported(self.path, "history"):
            if "rows" not in self.file:
                group = own_node(self.file, "history")
                known = {name: own_dataset(group, name) for name in group if name in QUANTITIES}
                require_modest(known)
                return row_records({name: read_column(dataset) for name, dataset in known.items()})
            stored = own_dataset(self.file, "rows")
            require_modest({"rows": stored})
            table = stored[:]
            rows = row_records({name: read_column(table[name]) for name in table.dtype.names or ()})
            part = part_of(self.path)
            of_name = part is None or rows["step"].tolist() == list(range(part.first, part.last + 1))
            require(of_name, "rows", "the increments that the name says")
            return rows

    def summaries(self) -> list[Summary]:
        """Return the summaries of all increments."""
        rows = self.rows()
        return [_summary(dict(zip(rows.dtype.names or (), row, strict=True))) for row in rows.tolist()]

    def grid(self) -> tuple[DoubleArray, DoubleArray]:
        """Return x and y of the cell centres of a result file."""
        with damage_reported(self.path, "grid"):
            axes = {axis: own_dataset(self.file, f"fields/{axis}") for axis in ("x", "y")}
            require_modest(axes)
            x, y = (dataset[:] for dataset in axes.values())
            for name, axis in (("x", x), ("y", y)):
                require(axis.ndim == 1 and axis.dtype == np.float64 and len(axis), f"fields/{name}", "numbers")
                require(np.isfinite(axis).all() and (np.diff(axis) > 0.0).all(), f"fields/{name}", "ascending numbers")
            return x, y

    def require_run(self, header: RunHeader) -> None:
        """Raise FileError if this is a part of another run, or has other columns. Only parts name their run."""
        rows = self.rows()
        with damage_reported(self.path, RUN):
            if RUN in self.file and own_dataset(self.file, RUN)[:].tobytes() != header.digest:
                raise FileError("is a part of another run", self.path)
        if rows.dtype != row_type(header.errors, header.optional_columns):
            raise FileError("does not have the columns of this run", self.path)

    def require_steps(self, stores_fields: Callable[[int], bool], until: int | None = None) -> None:
        """Raise FileError unless `field_steps` are those that are stored, before `until`, by default the last."""
        with damage_reported(self.path, "fields/step"):
            steps = self.rows()["step"].tolist()
            until = until if until is not None else steps[-1] if steps else 0
            found = [step for step in self.field_steps if step < until or step not in steps]
            expected = [step for step in steps if step < until and stores_fields(step)]
            require(found == expected, "fields/step", "the increments that are stored")

    def require_fields(self, shape: tuple[int, int]) -> None:
        """Raise FileError unless the fields have a plane of `shape` for each of `field_steps`."""
        with damage_reported(self.path, "fields"):
            for name in self.field_names:
                dataset = own_dataset(self.file, f"fields/{name}")
                right = dataset.shape == (len(self.field_steps), *shape)
                require(right, f"fields/{name}", f"{len(self.field_steps)} planes of {shape[0]} x {shape[1]} cells")

    def read(self, name: str, step: int) -> NDArray[Any]:
        """Return a field ``(nx, ny)`` at `step`: one of `field_steps`, or the last if a restart is kept."""
        with damage_reported(self.path, f"fields/{name} of increment {step}"):
            if step in self.field_steps and name in self.field_names:
                dataset, count = own_dataset(self.file, f"fields/{name}"), len(self.field_steps)
                require(len(dataset) == count, f"fields/{name}", f"{count} planes, one per stored increment")
                plane = dataset[self.field_steps.index(step)]
            elif step == self.rows()["step"][-1]:
                plane = own_dataset(self.file, f"restart/{name}")[:]
            else:
                raise FileError(f"the fields of increment {step} are not kept any more", self.path)
            return checked_plane(name, np.asarray(plane))

    def state(self) -> State:
        """Return the last increment, exactly as it was."""
        rows = self.rows()
        values = dict(zip(rows.dtype.names or (), rows[-1].item(), strict=True))
        summary, errors = _summary(values), [values[name] for name in ERROR_NAMES if name in values]
        with damage_reported(self.path, "restart"):
            group = own_node(self.file, "restart")
            kept = {name: checked_plane(name, own_dataset(group, name)[:]) for name in group}
        of_state: dict[str, list[NDArray[Any]]] = {}
        for quantity in RESTART:
            field = kept[quantity.name] if quantity.name in kept else self.read(quantity.name, summary.step)
            of_state.setdefault(quantity.array, []).append(field)
        for quantity in DERIVED_FIELDS:
            if quantity.name in kept or quantity.name in self.field_names:
                stored = kept.get(quantity.name)
                field = self.read(quantity.name, summary.step) if stored is None else stored
                of_state[quantity.array] = [field]
        worn: dict[str, list[NDArray[Any]]] = {}
        for quantity in WEAR:
            if quantity.name in kept:
                worn.setdefault(quantity.array, []).append(kept[quantity.name])
        shapes = {part.shape for arrays in (of_state, worn) for array in arrays.values() for part in array}
        with damage_reported(self.path, "restart"):
            require(len(shapes) == 1, "restart", "one grid")
            wear = WearState(**_stacked(worn)) if worn else None
        fields = _stacked(of_state)
        displacement = fields.pop("displacement")
        return State(summary, Fields(**fields), displacement, SummaryErrors(*errors) if errors else None, wear)

    def verify(self) -> None:
        """Read every dataset, so that its checksum is compared. Raises FileError."""
        datasets: list[str] = []
        with damage_reported(self.path):
            self.file.visititems(lambda name, node: datasets.append(name) if hasattr(node, "shape") else None)
            for name in datasets:
                dataset = own_dataset(self.file, name)
                require_modest({name: dataset} if dataset.ndim == 1 else {})
                for index in range(len(dataset)) if dataset.ndim == 3 else ((),):
                    dataset[index]


def _summary(values: Mapping[str, Any]) -> Summary:
    """Return the summary in a record of the history."""
    return Summary(**{name: values[name] for name in SUMMARY_NAMES if name in values})


def _stacked(arrays: dict[str, list[NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """Return the arrays with their components joined."""
    return {name: parts[0] if len(parts) == 1 else np.stack(parts) for name, parts in arrays.items()}


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
        message, what = " ".join(str(error).split()), what or "the file"
        reasons = (reason.format(what) for part, reason in _REASONS.items() if part in message)
        raise FileError(next(reasons, f"cannot read {what}: {shortened(message)}"), path) from error
    except (ArithmeticError, AttributeError, LookupError, MemoryError, TypeError, ValueError) as error:
        raise FileError(f"cannot read {what or 'the file'}: {shortened(str(error))}", path) from error
