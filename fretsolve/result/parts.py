"""The files of a run: OUT, and until then its parts, one small file per increment, merged now and then.

A part ``FIRST-LAST.h5`` holds the increments FIRST to LAST: the rows of the history, the fields that the case
stores, and of the newest increment whatever else a restart needs. Parts are committed by a rename and never
modified. A merged part makes those it was merged from superfluous, which may stay behind after a kill.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError
from fretsolve.result.checks import content_of, row_type
from fretsolve.result.empty_histories import EmptyHistories
from fretsolve.result.header import RunHeader, write_sealed
from fretsolve.result.layout import (
    DERIVED_FIELDS,
    DISPLACEMENT,
    RESTART,
    STEP,
    WEAR,
    FieldQuantity,
    Quantity,
    X,
    Y,
    has_cycles,
    quantities_of,
)
from fretsolve.result.piece import RUN, Part, Piece, damage_reported, part_of
from fretsolve.result.planes import write_planes
from fretsolve.result.state import State
from fretsolve.result.storage import (
    COLUMN_FILTERS,
    PLAIN_FILTERS,
    chunk_shape,
    copy_chunks,
    create_column,
    create_columns,
    create_field,
    fill_columns,
)
from fretsolve.system import atomic_files

HEADER_NAME = "header.json"


def parts_folder(out: Path) -> Path:
    """Return the folder of the parts of the result file `out`."""
    return out.with_name(out.name + ".parts")


def all_parts(folder: Path) -> list[Part]:
    """Return every committed part, superfluous ones included, in order, merged ones first. Raises OSError."""
    parts = filter(None, map(part_of, folder.iterdir()))
    return sorted(parts, key=lambda part: (part.first, -part.last))


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


def set_result_aside(out: Path) -> Path:
    """Give a damaged result another name, and return that. Raises OSError."""
    names = (out.with_name(f"{out.name}.damaged-{number}") for number in itertools.count(1))
    aside = next(name for name in names if not os.path.lexists(name))
    atomic_files.rename(out, aside)
    return aside


def write_part(folder: Path, header: RunHeader, states: Sequence[State]) -> Part:
    """Commit a part of `states`. Raises OSError."""
    first, last = states[0].summary.step, states[-1].summary.step
    part = Part(folder / part_name(first, last), first, last)
    write_increments(part.path, header, [], states, states[-1], digest=header.digest)
    return part


def merge_parts(folder: Path, header: RunHeader, sources: Sequence[Path], last_state: State) -> Part:
    """Commit a part of all increments of the files `sources` up to `last_state`. Raises OSError, FileError."""
    with Piece(sources[0]) as piece:
        first = int(piece.rows()["step"][0])
    part = Part(folder / part_name(first, last_state.summary.step), first, last_state.summary.step)
    write_increments(part.path, header, sources, [], last_state, digest=header.digest)
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
    empty: EmptyHistories | None = None,
) -> None:
    """Write the result file `out` from the parts `sources` in `folder`, and rename it into place.

    unsaved: the states after those of the parts; last_state: that of the last increment, None if there is none.
    failure: why the run failed and the kind of failure, None if it is complete; a failed result keeps what a restart
    needs. empty: histories to begin with, for results of many cases. Raises FileExistsError if `out` exists, OSError,
    FileError.
    """
    rows = read_rows(header, sources, unsaved)
    steps = [step for step in rows["step"].tolist() if header.stores_fields(step)]
    if last_state is not None and last_state.summary.step not in steps:
        steps.append(last_state.summary.step)
        unsaved = [last_state, *(state for state in unsaved if state is not last_state)]
    known = quantities_of(header.case)
    columns = [(known[name], rows[name]) for name in rows.dtype.names or ()]  # the step first
    beginning = b"" if empty is None else empty.file([quantity for quantity, _ in columns], len(rows))
    with atomic_files.new_hdf5(out, folder, exclusive=True, beginning=beginning) as file:
        if beginning:
            fill_columns(file["history"], columns)
        else:
            create_columns(file.create_group("history"), columns)
        names = [quantity.name for quantity in header.stored_fields]
        content = content_of(rows, header.x, header.y, steps, names)
        write_sealed(file, header.attributes("complete" if failure is None else "failed", failure), content)
        fields = file.create_group("fields")
        scales = [create_column(fields, *axis) for axis in ((STEP, steps), (X, header.x), (Y, header.y))]
        written = _write_fields(fields, header, steps, sources, unsaved)
        _write_cycles(file, header, rows, steps, ended=failure is None)
        for quantity, dataset in written:
            dataset.attrs.update(quantity.attributes)
            for axis, scale in enumerate(scales):
                dataset.dims[axis].attach_scale(scale)
        if failure is not None and last_state is not None:
            kept = {quantity.name: quantity for quantity in RESTART + DERIVED_FIELDS + WEAR}
            for name, dataset in _write_restart(file, last_state, header.stored_fields).items():
                dataset.attrs.update(kept[name].attributes)


def _write_cycles(file: Any, header: RunHeader, rows: NDArray[Any], steps: Sequence[int], *, ended: bool) -> None:
    """Write the table of cycles, if there is any, from the history `rows` and the fields of `steps` in `file`."""
    if not has_cycles(header.case):
        return
    from fretsolve.result.cycles.steps import stages_of  # few results need them
    from fretsolve.result.cycles.table import cycle_table

    def slip(step: int) -> NDArray[Any] | None:
        if "slip_x" not in file["fields"] or step not in steps:
            return None
        return np.array([file[f"fields/slip_{axis}"][steps.index(step)] for axis in "xy"])

    history = {name: rows[name] for name in rows.dtype.names or ()}
    line = header.case.get("plane") == "strain"
    table = cycle_table(history, stages_of(header.case), slip, ended=ended, line=line)
    if table is None:
        return
    columns = [
        (Quantity(name, table.units[name], table.meanings[name], str(values.dtype)), values)
        for name, values in table.columns.items()
    ]
    create_columns(file.create_group("cycles"), columns)


def read_rows(header: RunHeader, sources: Sequence[Path], states: Sequence[State]) -> NDArray[Any]:
    """Return the history of the files `sources` and then of `states`, a record per increment. Raises FileError."""
    kind = row_type(header.errors, header.optional_columns)
    record = itemgetter(*kind.names or ())
    rows = [record(vars(state.summary) | ({} if state.errors is None else vars(state.errors))) for state in states]
    tables = []
    for source in sources:
        with Piece(source) as piece:
            tables.append(piece.rows())
            piece.require_run(header)
            piece.require_steps(header.stores_fields)
    return np.concatenate([*tables, np.array(rows, kind)])


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
            piece.require_fields(header.shape)
            for index, step in enumerate(piece.field_steps):
                missing.discard(step)
                for quantity, target in targets if step in rank else ():
                    copy_chunks(piece.file["fields"][quantity.name], index, target, rank[step])
    stored = sorted((state for state in states if state.summary.step in rank), key=lambda state: state.summary.step)
    if stored:
        for quantity, target in targets:
            # They follow each other.
            write_planes(target, rank[stored[0].summary.step], (component(state, quantity) for state in stored))
    missing -= {state.summary.step for state in states}
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
    derived = [quantity for quantity in DERIVED_FIELDS if getattr(state.fields, quantity.array) is not None]
    for quantity in (*derived, *(WEAR if state.wear is not None else ())):
        if quantity in stored:
            continue
        values = component(state, quantity)
        group.create_dataset(quantity.name, data=values, chunks=chunk_shape(*values.shape), **PLAIN_FILTERS)
    return group


def component(state: State, quantity: FieldQuantity) -> NDArray[Any]:
    """Return the array ``(nx, ny)`` of `state` that is stored as `quantity`."""
    owner = state.wear if quantity in WEAR else state if quantity in DISPLACEMENT else state.fields
    array: NDArray[Any] = getattr(owner, quantity.array)
    return array if quantity.component is None else array[quantity.component]
