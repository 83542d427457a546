"""OUT itself, written once from the parts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from h5py import h5ds

from fretsolve.result.header import RunHeader
from fretsolve.result.layout import QUANTITIES, STEP, X, Y, create_column, set_attributes
from fretsolve.result.parts import read_rows, write_fields, write_restart
from fretsolve.result.state import State
from fretsolve.system import atomic_files


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
    needs. Raises OSError, FileError.
    """
    rows = read_rows(header, sources, unsaved)
    steps = [step for step in rows["step"].tolist() if header.stores_fields(step)]
    if last_state is not None and last_state.summary.step not in steps:
        steps.append(last_state.summary.step)
        unsaved = [last_state, *(state for state in unsaved if state is not last_state)]
    with atomic_files.new_hdf5(out, folder) as file:
        set_attributes(file.id, header.attributes("complete" if failure is None else "failed", failure))
        history, fields = file.create_group("history"), file.create_group("fields")
        scale = None
        for name in rows.dtype.names or ():  # the step first
            column = create_column(history, QUANTITIES[name], rows[name], scale)
            scale = scale or column
        scales = [create_column(fields, *axis) for axis in ((STEP, steps), (X, header.x), (Y, header.y))]
        for quantity, dataset in write_fields(fields, header, steps, sources, unsaved):
            set_attributes(dataset.id, quantity.attributes)
            for axis, scale in enumerate(scales):
                h5ds.attach_scale(dataset.id, scale, axis)
        if failure is not None and last_state is not None:
            for name, dataset in write_restart(file, last_state, header.stored_fields).items():
                set_attributes(dataset.id, QUANTITIES[name].attributes)
