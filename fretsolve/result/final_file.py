"""OUT itself, written once from the parts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fretsolve.result.header import RunHeader
from fretsolve.result.layout import (
    ERRORS,
    HISTORY,
    RESTART,
    STEP,
    Quantity,
    X,
    Y,
    create_column,
    describe,
    set_attributes,
)
from fretsolve.result.parts import write_fields, write_restart
from fretsolve.result.state import State, Summary, SummaryErrors
from fretsolve.system import atomic_files


def write_result(
    out: Path,
    folder: Path,
    header: RunHeader,
    summaries: Sequence[Summary],
    errors: Sequence[SummaryErrors],
    sources: Sequence[Path],
    unsaved: Sequence[State],
    last_state: State | None,
    failure: tuple[str, str] | None,
) -> None:
    """Write the result file `out` from the parts `sources` in `folder`, and rename it into place.

    summaries: of all increments; errors: their error bars, or none; unsaved: the states after those of the parts;
    last_state: that of the last increment, None if there is none. failure: why the run failed and the kind of failure,
    None if it is complete; a failed result keeps what a restart needs. Raises OSError, FileError.
    """
    steps = [summary.step for summary in summaries if header.stores_fields(summary.step)]
    if last_state is not None and not header.stores_fields(last_state.summary.step):
        steps.append(last_state.summary.step)
        unsaved = [last_state, *(state for state in unsaved if state is not last_state)]
    with atomic_files.new_hdf5(out, folder) as file:
        set_attributes(file, header.attributes("complete" if failure is None else "failed", failure))
        _write_history(file.create_group("history"), summaries, errors if header.errors else None)
        group = file.create_group("fields")
        scales = [create_column(group, *axis) for axis in ((STEP, steps), (X, header.x), (Y, header.y))]
        write_fields(group, header, steps, sources, unsaved)
        for quantity in header.stored_fields:
            describe(group[quantity.name], quantity)
            for axis, scale in enumerate(scales):
                group[quantity.name].dims[axis].attach_scale(scale)
        if failure is not None and last_state is not None:
            write_restart(file, last_state, header.stored_fields)
            for quantity in RESTART:
                if quantity.name in file["restart"]:
                    describe(file["restart"][quantity.name], quantity)


def _write_history(group: Any, summaries: Sequence[Summary], errors: Sequence[SummaryErrors] | None) -> None:
    """Write a column per quantity, also for no increments; errors: None if the result has no error bars."""

    def values(rows: Sequence[Summary] | Sequence[SummaryErrors], quantity: Quantity) -> list[float]:
        return [getattr(row, quantity.name) for row in rows]

    scale = create_column(group, STEP, values(summaries, STEP))
    for quantity in HISTORY:
        create_column(group, quantity, values(summaries, quantity), scale)
    for quantity in ERRORS if errors is not None else ():
        create_column(group, quantity, values(errors or (), quantity), scale)
