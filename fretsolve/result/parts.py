"""The files of a run: OUT, and until then its parts, one small file per increment, merged now and then.

A part ``FIRST-LAST.h5`` holds the increments FIRST to LAST: the rows of the history, the fields that the case
stores, and of the newest increment whatever else a restart needs. Parts are committed by a rename and never
modified. A merged part makes those it was merged from superfluous, which may stay behind after a kill.
"""

from __future__ import annotations

import itertools
import json
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from dataclasses import fields as dataclass_fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError, shortened
from fretsolve.result.checks import (
    COLUMN_NAMES,
    MOST_STEP_BYTES,
    checked_plane,
    content_of,
    read_column,
    require,
    require_modest,
    row_records,
    row_type,
    widened,
)
from fretsolve.result.header import RunHeader, sealed
from fretsolve.result.layout import (
    BULK_HISTORY,
    CHANGE,
    COLUMN_FILTERS,
    DISPLACEMENT,
    HEADER,
    HEADER_GROUP,
    PLAIN_FILTERS,
    RESTART,
    STEP,
    FieldQuantity,
    X,
    Y,
    chunk_shape,
    copy_chunks,
    create_column,
    create_field,
    quantities_of,
)
from fretsolve.result.state import Change, Fields, State, Summary, SummaryErrors
from fretsolve.system import atomic_files
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.foreign_files import open_hdf5, own_dataset, own_node

HEADER_NAME = "header.json"
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

CONTENT = "content"
"""Name of `content_of` in the text of the header."""

SUMMARY_NAMES, ERROR_NAMES = (
    tuple(column.name for column in dataclass_fields(kind)) for kind in (Summary, SummaryErrors)
)


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
    """Return every committed part, superfluous ones included, in order, merged ones first. Raises OSError."""
    parts = filter(None, map(_part_of, folder.iterdir()))
    return sorted(parts, key=lambda part: (part.first, -part.last))


def _part_of(path: Path) -> Part | None:
    match = _PART_NAME.fullmatch(path.name)
    return Part(path, int(match[1]), int(match[2])) if match else None


def contiguous_parts(folder: Path) -> list[Part]:
    """Return the parts that hold increments 0 to n without a gap, for the largest n. Raises OSError."""
    chosen: list[Part] = []
    for part in all_parts(folder):
        if part.first == (chosen[-1].last + 1 if chosen else 0):
            chosen.append(part)
    return chosen


def set_aside(folder: Path, parts: Sequence[Path]) -> Path:
    """Move parts, the last one first, from the parts `folder` to a new one beside it; return that. Raises OSError."""
    names = (folder.with_name(f"{folder.name}.damaged-{number}") for number in itertools.count(1))
    aside = next(name for name in names if not os.path.lexists(name))
    atomic_files.move(aside, *reversed(parts))
    return aside


def write_part(folder: Path, header: RunHeader, state: State, sources: Sequence[Path] = ()) -> Part:
    """Commit a part of all increments of `sources` up to `state`, or of `state` alone. Raises OSError, FileError."""
    first = state.summary.step
    if sources:
        with Piece(sources[0]) as piece:
            first = int(piece.rows()["step"][0])
    part = Part(folder / part_name(first, state.summary.step), first, state.summary.step)
    write_increments(part.path, header, sources, [] if sources else [state], state, digest=header.digest)
    return part


def part_name(first: int, last: int) -> str:
    """Return the name of the part of the increments `first` to `last`."""
    return f"{first:06d}-{last:06d}.h5"


def write_increments(
    path: Path,
    header: RunHeader,
    sources: Sequence[Path],
    states: Sequence[State],
    last_state: State,
    digest: bytes = b"",
) -> None:
    """Write the increments of `sources` and then of `states`, which end with `last_state`, as a part does.

    digest: that of the run, to which alone the part belongs; empty where other runs begin with it, too.
    """
    rows = read_rows(header, sources, states)
    first, last = int(rows["step"][0]), int(rows["step"][-1])
    steps = [step for step in range(first, last + 1) if header.stores_fields(step)]
    with atomic_files.new_hdf5(path, path.parent) as file:
        file.create_dataset("rows", data=rows, chunks=rows.shape, **COLUMN_FILTERS)
        if digest:
            file.create_dataset(RUN, data=np.frombuffer(digest, np.uint8), chunks=(len(digest),), **COLUMN_FILTERS)
        group = file.create_group("fields")
        layout = {"chunks": (len(steps),), **COLUMN_FILTERS} if steps else {}
        group.create_dataset("step", data=np.array(steps, STEP.dtype), **layout)
        if steps:
            _write_fields(group, header, steps, sources, states)
        _write_restart(file, last_state, header.stored_fields if last in steps else ())


def write_result(
    out: Path,
    folder: Path,
    header: RunHeader,
    sources: Sequence[Path],
    unsaved: Sequence[State],
    last_state: State | None,
    failure: tuple[str, str] | None,
) -> None:
    """Write the result file `out` from the parts `sources` in `folder`, and rename it into place.

    unsaved: the states after those of the parts; last_state: that of the last increment, None if there is none.
    failure: why the run failed and the kind of failure, None if it is complete; a failed result keeps what a restart
    needs. Raises FileExistsError if `out` exists, OSError, FileError.
    """
    rows = read_rows(header, sources, unsaved)
    steps = [step for step in rows["step"].tolist() if header.stores_fields(step)]
    if last_state is not None and last_state.summary.step not in steps:
        steps.append(last_state.summary.step)
        unsaved = [last_state, *(state for state in unsaved if state is not last_state)]
    with atomic_files.new_hdf5(out, folder, exclusive=True) as file:
        attributes = header.attributes("complete" if failure is None else "failed", failure)
        file.attrs.update(attributes)
        names = [quantity.name for quantity in header.stored_fields]
        content = content_of(rows, header.x, header.y, steps, names)
        text = np.frombuffer(sealed({**attributes, CONTENT: content}).encode(), np.uint8)
        create_column(file.create_group(HEADER_GROUP), HEADER, text)
        history, fields = file.create_group("history"), file.create_group("fields")
        scale, known = None, quantities_of(json.loads(header.effective_case))
        for name in rows.dtype.names or ():  # the step first
            column = create_column(history, known[name], rows[name], scale)
            scale = scale or column
        scales = [create_column(fields, *axis) for axis in ((STEP, steps), (X, header.x), (Y, header.y))]
        for quantity, dataset in _write_fields(fields, header, steps, sources, unsaved):
            dataset.attrs.update(quantity.attributes)
            for axis, scale in enumerate(scales):
                dataset.dims[axis].attach_scale(scale)
        if failure is not None and last_state is not None:
            kept = {quantity.name: quantity for quantity in RESTART + CHANGE}
            for name, dataset in _write_restart(file, last_state, header.stored_fields).items():
                dataset.attrs.update(kept[name].attributes)


def read_rows(header: RunHeader, sources: Sequence[Path], states: Sequence[State]) -> NDArray[Any]:
    """Return the history of the files `sources` and then of `states`, a record per increment. Raises FileError."""
    kind = row_type(header.errors, header.bulk)
    rows = []
    for state in states:
        values = vars(state.summary) | ({} if state.errors is None else vars(state.errors))
        rows.append(tuple(values[name] for name in kind.names or ()))
    tables = []
    for source in sources:
        with Piece(source) as piece:
            tables.append(piece.rows())
            piece.require_run(header)
            piece.require_steps(header.stores_fields)
    return np.concatenate([*(widened(table, kind) for table in tables), np.array(rows, kind)])


def _write_fields(
    group: Any, header: RunHeader, steps: Sequence[int], sources: Sequence[Path], states: Sequence[State]
) -> list[tuple[FieldQuantity, Any]]:
    """Write the stored fields of `steps`, from `sources` and `states`, to the HDF5 `group`; return the datasets.

    They are in the order of the increments, so that the file does not depend on where a run was stopped and resumed.
    """
    rank = {step: index for index, step in enumerate(steps)}
    missing = set(rank)
    targets = [(each, create_field(group, each, len(steps), header.shape)) for each in header.stored_fields]
    for source in sources:
        with Piece(source) as piece, damage_reported(source, "fields"):
            for index, step in enumerate(piece.field_steps):
                missing.discard(step)
                for quantity, target in targets if step in rank else ():
                    copy_chunks(piece.file["fields"][quantity.name], index, target, rank[step])
    for state in states:
        missing.discard(state.summary.step)
        for quantity, target in targets if state.summary.step in rank else ():
            target[rank[state.summary.step]] = component(state, quantity)
    if missing:
        raise FileError(f"the fields of increment {min(missing)} are missing in the parts", *sources[:1])
    return targets


def _write_restart(file: Any, state: State, stored: Sequence[FieldQuantity]) -> Any:
    """Write, uncompressed, the arrays of `state` that `stored` lacks or has in another precision; return the group."""
    group = file.create_group("restart")
    for quantity in RESTART:
        values = component(state, quantity)
        if quantity not in stored or values.dtype != quantity.dtype:
            group.create_dataset(quantity.name, data=values, chunks=chunk_shape(*values.shape), **PLAIN_FILTERS)
    for quantity in CHANGE if state.change is not None else ():
        values = component(state, quantity)
        group.create_dataset(quantity.name, data=values, chunks=chunk_shape(*values.shape), **PLAIN_FILTERS)
    return group


def component(state: State, quantity: FieldQuantity) -> NDArray[Any]:
    """Return the array ``(nx, ny)`` of `state` that is stored as `quantity`."""
    owner = state.change if quantity in CHANGE else state if quantity in DISPLACEMENT else state.fields
    array: NDArray[Any] = getattr(owner, quantity.array)
    return array if quantity.component is None else array[quantity.component]


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
            self.field_names = [quantity.name for quantity in RESTART if quantity.name in self.file["fields"]]
            opened.pop_all()

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def rows(self) -> NDArray[Any]:
        """Return the history, a record per increment, with the error bars if there are any."""
        with damage_reported(self.path, "history"):
            if "rows" not in self.file:
                group = own_node(self.file, "history")
                known = {name: own_dataset(group, name) for name in group if name in COLUMN_NAMES}
                require_modest(known)
                return row_records({name: read_column(dataset) for name, dataset in known.items()})
            stored = {name: own_dataset(self.file, name) for name in ("rows", "error_rows") if name in self.file}
            require_modest(stored)
            tables = [dataset[:] for dataset in stored.values()]
            # Parts of earlier versions keep the error bars apart.
            rows = row_records({name: read_column(table[name]) for table in tables for name in table.dtype.names or ()})
            part = _part_of(self.path)
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
        """Raise FileError if this is a part of another run. Parts of earlier versions do not say."""
        with damage_reported(self.path, RUN):
            if RUN in self.file and own_dataset(self.file, RUN)[:].tobytes() != header.digest:
                raise FileError("is a part of another run", self.path)

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
                plane = own_dataset(self.file, f"fields/{name}")[self.field_steps.index(step)]
            elif step == self.rows()["step"][-1]:
                plane = own_dataset(self.file, f"restart/{name}")[:]
            else:
                raise FileError(f"the fields of increment {step} are not kept any more", self.path)
            return checked_plane(name, np.asarray(plane))

    def state(self) -> State:
        """Return the last increment, exactly as it was."""
        rows = self.rows()
        names = rows.dtype.names or ()
        kind = row_type(ERROR_NAMES[0] in names, BULK_HISTORY[0].name in names)
        values = dict(zip(kind.names or (), widened(rows[-1:], kind)[0].item(), strict=True))
        summary, errors = _summary(values), [values[name] for name in ERROR_NAMES if name in values]
        with damage_reported(self.path, "restart"):
            group = own_node(self.file, "restart")
            kept = {name: checked_plane(name, own_dataset(group, name)[:]) for name in group}
        of_state: dict[str, list[NDArray[Any]]] = {}
        for quantity in RESTART:
            field = kept[quantity.name] if quantity.name in kept else self.read(quantity.name, summary.step)
            of_state.setdefault(quantity.array, []).append(field)
        changes: dict[str, list[NDArray[Any]]] = {}
        for quantity in CHANGE:
            if quantity.name in kept:
                changes.setdefault(quantity.array, []).append(kept[quantity.name])
        shapes = {part.shape for arrays in (of_state, changes) for array in arrays.values() for part in array}
        with damage_reported(self.path, "restart"):
            require(len(shapes) == 1, "restart", "one grid")
            change = Change(**_stacked(changes)) if changes else None
        fields = _stacked(of_state)
        displacement = fields.pop("displacement")
        return State(summary, Fields(**fields), displacement, SummaryErrors(*errors) if errors else None, change)

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
        message, what = " ".join(str(error).split()), what or "the file"
        reasons = (reason.format(what) for part, reason in _REASONS.items() if part in message)
        raise FileError(next(reasons, f"cannot read {what}: {shortened(message)}"), path) from error
    except (ArithmeticError, AttributeError, LookupError, MemoryError, TypeError, ValueError) as error:
        raise FileError(f"cannot read {what or 'the file'}: {shortened(str(error))}", path) from error
