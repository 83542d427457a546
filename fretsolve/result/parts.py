"""The files of a run: OUT, and until then the folder OUT.parts.

A part ``FIRST-LAST.h5`` holds the increments FIRST to LAST: rows of the history, and the fields that the case stores.
``LAST.npz`` holds the state after them, from which a run goes on. It is committed before its part, and goes once it is
of no more use; a part is never modified.
"""

from __future__ import annotations

import io
import itertools
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import IO, Any, Literal

import numpy as np
from numpy.typing import NDArray

from fretsolve.result.header import RunHeader, write_sealed
from fretsolve.result.layout import (
    FIELD_FILTERS,
    STEP,
    FieldQuantity,
    Quantity,
    X,
    Y,
    create_column,
    create_field,
    described,
    has_cycles,
    quantities_of,
)
from fretsolve.result.part_reader import RUN, PartReader, content_of, damage_reported, require
from fretsolve.result.state import Before, Fields, State, WearState, errors_of, row_of, summary_of
from fretsolve.system import atomic_files
from fretsolve.system.files import require_regular
from fretsolve.system.hdf5_files import own_dataset

HEADER_NAME = "header.json"

ROUND_NAME = "round.h5"
"""The result of a round of an accuracy after which another one may follow, so that it is not OUT yet."""

RESTART = "restart"
"""Dataset of a failed result with the bytes of its last state."""

_PART_NAME = re.compile(r"([0-9]{6,18})-([0-9]{6,18})\.h5")
_STATE_NAME = re.compile(r"[0-9]{6,18}\.npz")
_ARRAYS = {"fields": Fields, "wear": WearState, "before": Before}
"""What a state holds arrays in, besides its own."""


@dataclass(frozen=True)
class Part:
    """A committed part of the increments `first` to `last`; state: the file of the state after them."""

    path: Path
    first: int
    last: int

    @classmethod
    def named(cls, folder: Path, first: int, last: int) -> Part:
        """Return the part of these increments, which need not be there."""
        return cls(folder / f"{first:06d}-{last:06d}.h5", first, last)

    @property
    def state(self) -> Path:
        return self.path.with_name(f"{self.last:06d}.npz")


def parts_folder(out: Path) -> Path:
    """Return the folder of the parts of the result file `out`."""
    return out.with_name(out.name + ".parts")


def all_parts(folder: Path) -> list[Part]:
    """Return every committed part, in order. Raises OSError."""
    names = filter(None, (_PART_NAME.fullmatch(path.name) for path in folder.iterdir()))
    return sorted((Part(folder / name[0], int(name[1]), int(name[2])) for name in names), key=lambda part: part.first)


def contiguous_parts(folder: Path) -> list[Part]:
    """Return the parts that hold increments 0 to n without a gap, for the largest n. Raises OSError."""
    chosen: list[Part] = []
    for part in all_parts(folder):
        if part.first == (chosen[-1].last + 1 if chosen else 0):
            chosen.append(part)
    return chosen


def all_states(folder: Path) -> list[Path]:
    """Return the files of states, in order. Raises OSError."""
    return sorted(path for path in folder.iterdir() if _STATE_NAME.fullmatch(path.name))


def free_name(path: Path) -> Path:
    """Return a name beside a damaged file or folder to which it can be moved."""
    names = (path.with_name(f"{path.name}.damaged-{number}") for number in itertools.count(1))
    return next(name for name in names if not os.path.lexists(name))


def write_part(folder: Path, header: RunHeader, states: Sequence[State]) -> Part:
    """Commit the last one of `states`, and then a part of all. Raises OSError."""
    first, last = states[0].summary.step, states[-1].summary.step
    part = Part.named(folder, first, last)
    write_state(part, header, states[-1])
    with atomic_files.new_hdf5(part.path, folder) as file:
        file.attrs[RUN] = np.bytes_(header.digest)
        steps = [step for step in range(first, last + 1) if header.stores_fields(step)]
        fields = file.create_group("fields")
        fields["step"] = np.array(steps, STEP.dtype)
        rows, _ = _write_fields(fields, header, steps, [], states)
        file.create_dataset("rows", data=rows, chunks=rows.shape, **FIELD_FILTERS)
    return part


def write_state(part: Part, header: RunHeader, state: State) -> None:
    """Commit the state after `part`. Raises OSError."""
    with atomic_files.new_file(part.state, part.path.parent) as file:
        _save_state(file, header, state)


def _save_state(file: IO[bytes], header: RunHeader, state: State) -> None:
    arrays: dict[str, Any] = {"row": _rows(header, [state]), "displacement": state.displacement}
    for name in _ARRAYS:
        held = {} if getattr(state, name) is None else vars(getattr(state, name))
        arrays |= {f"{name}.{inner}": array for inner, array in held.items() if array is not None}
    np.savez(file, **arrays)


def read_state(part: Part, shape: tuple[int, int]) -> State:
    """Return the state after `part`, exactly as it was, on a grid of `shape`. Raises FileError, FileNotFoundError."""
    with damage_reported(part.state):
        require_regular(part.state)
        with part.state.open("rb") as file:
            state = _load_state(file, shape)
        require(state.summary.step == part.last, "row", "the increment that the name says")
        return state


def read_restart(reader: PartReader, shape: tuple[int, int]) -> State:
    """Return the last state of a failed result. Raises FileError."""
    with damage_reported(reader.path, RESTART):
        return _load_state(io.BytesIO(own_dataset(reader.file, RESTART)[:].tobytes()), shape)


def _load_state(file: IO[bytes], shape: tuple[int, int]) -> State:
    with np.load(file, allow_pickle=False) as stored:
        if stored.zip.testzip() is not None:
            raise ValueError("the checksum does not match")
        groups: dict[str, dict[str, Any]] = {name: {} for name in ("", *_ARRAYS)}
        for name in stored.files:
            group, _, inner = name.rpartition(".")
            groups[group][inner] = np.ascontiguousarray(stored[name])
    own = groups.pop("")
    row = own.pop("row")[0]
    for arrays in (own, *groups.values()):
        require(all(array.shape[-2:] == shape for array in arrays.values()), "a state", "fields on the grid of the run")
    inside = {name: _ARRAYS[name](**arrays) for name, arrays in groups.items() if arrays}
    return State(summary_of(row), errors=errors_of(row), **own, **inside)


def write_result(
    out: Path,
    folder: Path,
    header: RunHeader,
    sources: Sequence[Part],
    unsaved: Sequence[State],
    last_state: State | None,
    status: Literal["complete", "failed", "stopped"],
    failure: tuple[str, str] | None = None,
    *,
    exclusive: bool = True,
) -> None:
    """Write the result file `out` from the parts `sources`, and rename it into place from `folder`.

    unsaved: the states after the parts' states; last_state: the state of the last increment, None if there is none;
    status: unless it is complete, the result keeps what a restart needs; failure: why the run failed and the kind of
    failure; exclusive: whether `out` is to be new. Raises FileExistsError if it is not, OSError, FileError.
    """
    count = 0 if last_state is None else last_state.summary.step + 1
    steps = [step for step in range(count) if header.stores_fields(step)]
    if last_state is not None and last_state.summary.step not in steps:
        steps.append(last_state.summary.step)
    if last_state is not None and not unsaved:
        unsaved = [last_state]
    known = quantities_of(header.case)
    with atomic_files.new_hdf5(out, folder, exclusive=exclusive) as file:
        fields = file.create_group("fields")
        scales = [create_column(fields, *axis) for axis in ((STEP, steps), (X, header.x), (Y, header.y))]
        rows, written = _write_fields(fields, header, steps, sources, unsaved)
        for quantity, dataset in written:
            dataset.attrs.update(quantity.attributes)
            for axis, scale in enumerate(scales):
                dataset.dims[axis].attach_scale(scale)
        _write_columns(file.create_group("history"), [(known[name], rows[name]) for name in rows.dtype.names or ()])
        _write_cycles(file, header, rows, {step: place for place, step in enumerate(steps)}, ended=status == "complete")
        names = [quantity.name for quantity in header.stored_fields]
        write_sealed(file, header.attributes(status, failure), content_of(rows, header.x, header.y, steps, names))
        if status != "complete" and last_state is not None:
            memory = io.BytesIO()
            _save_state(memory, header, last_state)
            restart = file.create_dataset(RESTART, data=np.frombuffer(memory.getbuffer(), np.uint8))
            restart.attrs.update(described("1", "the last state, a file of NumPy arrays (npz), for --resume"))


def _write_columns(group: Any, columns: Sequence[tuple[Quantity, Any]]) -> None:
    """Store columns of one length, the first of which is the scale of the others."""
    scale = None
    for quantity, values in columns:
        column = create_column(group, quantity, values, scale)
        scale = scale or column


def _write_cycles(file: Any, header: RunHeader, rows: NDArray[Any], places: dict[int, int], *, ended: bool) -> None:
    """Write the table of cycles, if any, from the history `rows` and the fields in `file`; places: of their steps."""
    if not has_cycles(header.case):
        return
    from fretsolve.result.cycles.table import cycle_table  # takes 3 ms to load

    def slip(step: int) -> NDArray[Any] | None:
        if "slip_x" not in file["fields"] or step not in places:
            return None
        return np.array([file[f"fields/slip_{axis}"][places[step]] for axis in "xy"])

    history = {name: rows[name] for name in rows.dtype.names or ()}
    if (table := cycle_table(history, header.case, slip, ended=ended)) is not None:
        columns = [
            (Quantity(name, table.units[name], table.meanings[name], str(values.dtype)), values)
            for name, values in table.columns.items()
        ]
        _write_columns(file.create_group("cycles"), columns)


def _rows(header: RunHeader, states: Sequence[State]) -> NDArray[Any]:
    """Return the records of the history of states."""
    record = itemgetter(*header.row_type.names or ())
    return np.array([record(row_of(state)) for state in states], header.row_type)


def read_rows(header: RunHeader, sources: Sequence[Part]) -> NDArray[Any]:
    """Return the history in parts, a record per increment. Raises FileError."""
    tables = [_rows(header, [])]
    for source in sources:
        with PartReader(source.path) as reader:
            reader.require_part(header, source.first, source.last)
            tables.append(reader.rows)
    return np.concatenate(tables)


def _write_fields(
    group: Any, header: RunHeader, steps: Sequence[int], sources: Sequence[Part], states: Sequence[State]
) -> tuple[NDArray[Any], list[tuple[FieldQuantity, Any]]]:
    """Write the stored fields of `steps`, from `sources` and `states`, to the HDF5 `group`.

    Return the rows of the history of both, and the datasets. These are in the order of the increments, so that the file
    does not depend on where a run was stopped and resumed.
    """
    rank = {step: index for index, step in enumerate(steps)}
    targets = [(each, create_field(group, each, len(steps), header.shape)) for each in header.stored_fields]
    first = sources[0].first if sources else states[0].summary.step if states else 0
    after = sources[-1].last if sources else first - 1
    later = [state for state in states if state.summary.step > after]
    rows = np.empty(after + 1 + len(later) - first, header.row_type)
    for source in sources:
        with PartReader(source.path) as reader, damage_reported(source.path, "fields"):
            # checked when the run took it up, or its own
            rows[source.first - first : source.last + 1 - first] = reader.rows
            for index, step in enumerate(reader.field_steps):
                for quantity, target in targets if step in rank else ():
                    _copy_chunks(reader.file["fields"][quantity.name], index, target, rank[step])
    for state in states:
        for quantity, target in targets if state.summary.step in rank else ():
            target[rank[state.summary.step]] = component(state, quantity)
    rows[after + 1 - first :] = _rows(header, later)
    return rows, targets


def _copy_chunks(source: Any, source_step: int, target: Any, target_step: int) -> None:
    """Copy one increment of a field as it is compressed: both datasets have the same chunks and filters."""
    rows = source.chunks[1]
    for row in range(0, source.shape[1], rows):
        mask, data = source.id.read_direct_chunk((source_step, row, 0))
        target.id.write_direct_chunk((target_step, row, 0), data, mask)


def component(state: State, quantity: FieldQuantity) -> NDArray[Any]:
    """Return the array ``(nx, ny)`` of `state` that is stored as `quantity`."""
    array: NDArray[Any] = getattr(state.fields, quantity.array)
    return array if quantity.component is None else array[quantity.component]
