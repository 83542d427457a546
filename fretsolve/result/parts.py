"""The parts of a run that is not finished: one small file per increment, merged now and then.

A part ``FIRST-LAST.h5`` holds the increments FIRST to LAST: the rows of the history, the fields that the case
stores, and of the newest increment whatever else a restart needs. Parts are committed by a rename and never
modified. A merged part makes those it was merged from superfluous, which may stay behind after a kill.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError
from fretsolve.result.header import RunHeader
from fretsolve.result.layout import (
    ERRORS,
    FORMER_NAMES,
    HISTORY,
    RESTART,
    STEP,
    FieldQuantity,
    copy_chunks,
    create_field,
    create_restart,
)
from fretsolve.result.state import Fields, State, Summary, SummaryErrors
from fretsolve.system import atomic_files

HEADER_NAME = "header.json"
_PART_NAME = re.compile(r"(\d{6,})-(\d{6,})\.h5")
_BY_NAME: Mapping[str, FieldQuantity] = {quantity.name: quantity for quantity in RESTART}
_ROW = np.dtype([(quantity.name, quantity.dtype) for quantity in (STEP, *HISTORY)])
_ERROR_ROW = np.dtype([(quantity.name, quantity.dtype) for quantity in ERRORS])


@dataclass(frozen=True)
class Part:
    """A committed part of the increments `first` to `last`."""

    path: Path
    first: int
    last: int


def parts_folder(out: Path) -> Path:
    """Return the folder of the parts of the result file `out`."""
    return out.with_name(out.name + ".parts")


def all_parts(folder: Path) -> list[Part]:
    """Return every committed part, superfluous ones included, in order. Raises OSError."""
    matches = [(path, _PART_NAME.fullmatch(path.name)) for path in folder.iterdir()]
    parts = [Part(path, int(match[1]), int(match[2])) for path, match in matches if match]
    return sorted(parts, key=lambda part: (part.first, part.last))


def contiguous_parts(folder: Path) -> list[Part]:
    """Return the parts that together hold increments 0 to n without a gap, n as large as possible. Raises OSError."""
    chosen: list[Part] = []
    for part in sorted(all_parts(folder), key=lambda part: (part.first, -part.last)):
        if part.first == (chosen[-1].last + 1 if chosen else 0):
            chosen.append(part)
    return chosen


def write_part(folder: Path, header: RunHeader, state: State) -> Part:
    """Commit one increment. Raises OSError."""
    errors = [] if state.errors is None else [state.errors]
    return _write(folder, header, [state.summary], errors, [], state)


def merge_parts(folder: Path, header: RunHeader, sources: Sequence[Path], state: State) -> Part:
    """Commit one part with all increments of `sources`, of which `state` is the last. Raises OSError, FileError."""
    rows: list[Summary] = []
    errors: list[SummaryErrors] = []
    for source in sources:
        with open_piece(source) as piece:
            rows += piece.summaries()
            errors += piece.errors()
    return _write(folder, header, rows, errors, sources, state)


def _write(
    folder: Path,
    header: RunHeader,
    rows: Sequence[Summary],
    errors: Sequence[SummaryErrors],
    sources: Sequence[Path],
    state: State,
) -> Part:
    """Commit a part with fields from `sources`, or of `state` alone if there are none."""
    part = Part(folder / f"{rows[0].step:06d}-{rows[-1].step:06d}.h5", rows[0].step, rows[-1].step)
    steps = [row.step for row in rows if header.stores_fields(row.step)]
    with atomic_files.new_hdf5(part.path, folder) as file:
        for name, values, kind in (("rows", rows, _ROW), ("error_rows", errors, _ERROR_ROW)):
            if values:
                table = np.array([astuple(value) for value in values], kind)
                file.create_dataset(name, data=table, chunks=table.shape, fletcher32=True)
        group = file.create_group("fields")
        group.create_dataset("step", data=np.array(steps, STEP.dtype))
        if steps:
            write_fields(group, header, steps, sources, [] if sources else [state])
        write_restart(file, state, header.stored_fields if state.summary.step in steps else ())
    return part


def write_fields(
    group: Any, header: RunHeader, steps: Sequence[int], sources: Sequence[Path], states: Sequence[State]
) -> None:
    """Write the stored fields of `steps` to the HDF5 `group`: those in `sources`, then those of `states`.

    The order is that of the increments, whatever parts they come from: the file must not depend on where a run was
    stopped and resumed. Raises FileError.
    """
    rank = {step: index for index, step in enumerate(steps)}
    names = [quantity.name for quantity in header.stored_fields]
    for quantity in header.stored_fields:
        create_field(group, quantity, len(steps), header.shape)
    for source in sources:
        with open_piece(source) as piece, damage_reported(source, "fields"):
            for index, step in enumerate(piece.field_steps):
                for name in names if step in rank else ():
                    copy_chunks(piece.file["fields"][name], index, group[name], rank[step])
    for state in states:
        for name in names if state.summary.step in rank else ():
            group[name][rank[state.summary.step]] = component(state, name)


def write_restart(file: Any, state: State, stored: Sequence[FieldQuantity]) -> None:
    """Write the arrays of `state` that are not among the fields `stored` for it, or there in another precision."""
    group = file.create_group("restart")
    for quantity in RESTART:
        values = component(state, quantity.name)
        if quantity not in stored or values.dtype != quantity.dtype:
            create_restart(group, quantity, values)


def component(state: State, name: str) -> NDArray[Any]:
    """Return the array ``(nx, ny)`` of `state` that is stored under `name`."""
    quantity = _BY_NAME[name]
    owner = state if quantity.array == "displacement" else state.fields
    array: NDArray[Any] = getattr(owner, quantity.array)
    return array if quantity.component is None else array[quantity.component]


class Piece:
    """An open part or result file: both are read alike. Raises FileError if it is damaged.

    field_steps: the increments whose fields it has; field_names: the names of these.
    """

    def __init__(self, path: Path):
        self.path = path
        with damage_reported(path):
            self.file = h5py.File(path, "r")
            try:
                self.field_steps: list[int] = self.file["fields/step"][:].tolist()
                self.field_names = [name for name in _BY_NAME if name in self.file["fields"]]
            except BaseException:
                self.file.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def history(self) -> dict[str, NDArray[Any]]:
        """Return the columns of the history, `step` first, those of the error bars last if there are any."""
        return self._columns("rows", _ROW) | self._columns("error_rows", _ERROR_ROW)

    def summaries(self) -> list[Summary]:
        """Return the rows of the history."""
        columns = [column.tolist() for column in self._columns("rows", _ROW).values()]
        return [Summary(*row) for row in zip(*columns, strict=True)]

    def errors(self) -> list[SummaryErrors]:
        """Return the error bars of each row, none if the run has no error bars."""
        columns = [column.tolist() for column in self._columns("error_rows", _ERROR_ROW).values()]
        return [SummaryErrors(*row) for row in zip(*columns, strict=True)]

    def _columns(self, rows: str, kind: np.dtype[Any]) -> dict[str, NDArray[Any]]:
        """Return columns from a part's dataset `rows` or a result's own; none of error bars if there are none."""
        names = kind.names or ()
        with damage_reported(self.path, "history"):
            stored = self.file[rows][:] if rows in self.file else self.file.get("history", {})
            present = stored.dtype.names if rows in self.file else stored
            if kind is _ERROR_ROW and names[0] not in present:
                return {}
            former = {name: FORMER_NAMES.get(name, name) for name in names if name not in present}
            return {name: stored[former.get(name, name)][:] for name in names}

    def read(self, name: str, step: int) -> NDArray[Any]:
        """Return a field ``(nx, ny)`` at `step`: one of `field_steps`, or the last if a restart is kept."""
        values: NDArray[Any]
        with damage_reported(self.path, f"fields/{name} of increment {step}"):
            if step in self.field_steps and name in self.field_names:
                values = self.file["fields"][name][self.field_steps.index(step)]
            elif step == self.history()["step"][-1]:
                values = self.file["restart"][name][:]
            else:
                raise FileError(f"the fields of increment {step} are not kept any more", self.path)
        return values

    def state(self) -> State:
        """Return the last increment, exactly as it was."""
        summary = self.summaries()[-1]
        with damage_reported(self.path, "restart"):
            kept = {name: dataset[:] for name, dataset in self.file["restart"].items()}
        for quantity in RESTART:
            if quantity.name not in kept:
                kept[quantity.name] = self.read(quantity.name, summary.step)
        arrays = {quantity.array: _whole(quantity.array, kept) for quantity in RESTART}
        displacement = arrays.pop("displacement")
        return State(summary, Fields(**arrays), displacement, next(reversed(self.errors()), None))

    def verify(self) -> None:
        """Read every dataset, so that its checksum is compared. Raises FileError."""
        datasets: list[Any] = []
        with damage_reported(self.path):
            self.file.visititems(lambda _, node: datasets.append(node) if hasattr(node, "shape") else None)
            for dataset in datasets:
                for index in range(len(dataset)) if dataset.ndim == 3 else ((),):
                    dataset[index]


@contextmanager
def open_piece(path: Path) -> Iterator[Piece]:
    """Open a `Piece` for the time of a `with` block. Raises FileError."""
    piece = Piece(path)
    try:
        yield piece
    finally:
        piece.close()


@contextmanager
def damage_reported(path: Path, what: str = "") -> Iterator[None]:
    """Turn what h5py raises on reading `path` into a FileError, except FileNotFoundError."""
    try:
        yield
    except FileNotFoundError:
        raise
    except (OSError, KeyError, RuntimeError) as error:
        raise FileError(_reason(error, what), path) from error


def _reason(error: Exception, what: str) -> str:
    message = " ".join(str(error).split())
    if isinstance(error, PermissionError):
        return "no permission to read the file"
    if isinstance(error, IsADirectoryError):
        return "a folder; the file of a result is needed"
    if "truncated file" in message:
        return "the file is truncated: it was not copied or written to its end"
    if "file signature not found" in message:
        return "not an HDF5 file, so no result of a run"
    if "filter returned failure" in message or "checksum" in message:
        return f"{what or 'the file'} is damaged: the checksum does not match"
    return f"cannot read {what or 'the file'}: {message}"


def _whole(array: str, components: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
    members = [components[quantity.name] for quantity in RESTART if quantity.array == array]
    return members[0] if len(members) == 1 else np.stack(members)
