"""OUT itself, written once from the parts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fretsolve.result.columns import add_scale, add_text, attach, history_image
from fretsolve.result.header import RunHeader
from fretsolve.result.layout import RESTART, STEP, X, Y, create_field, describe
from fretsolve.result.parts import component, copy_fields, write_restart
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
    last_state: that of the last increment, None if there is none. failure: why the run failed and the kind of that,
    None for a complete one; a failed result keeps what a restart needs. Raises OSError, FileError.
    """
    steps = [summary.step for summary in summaries if header.stores_fields(summary.step)]
    copied = len(steps)
    if last_state is not None and not header.stores_fields(last_state.summary.step):
        steps.append(last_state.summary.step)
    kept = header.stored_fields
    with atomic_files.new_hdf5(out, folder, history_image(summaries, errors if header.errors else None)) as file:
        _write_attributes(file, header, failure)
        group = file.create_group("fields")
        scales = (add_scale(group, STEP, steps), add_scale(group, X, header.x), add_scale(group, Y, header.y))
        for quantity in kept:
            dataset = create_field(group, quantity, len(steps), header.shape)
            describe(dataset, quantity)
            attach(dataset.id, *scales)
        copy_fields(sources, steps[:copied], group, kept)
        for state in unsaved:
            if header.stores_fields(state.summary.step):
                for quantity in kept:
                    group[quantity.name][steps.index(state.summary.step)] = component(state, quantity.name)
        if last_state is not None and copied < len(steps):
            for quantity in kept:
                group[quantity.name][-1] = component(last_state, quantity.name)
        if failure is not None and last_state is not None:
            write_restart(file, last_state, kept)
            for quantity in RESTART:
                if quantity.name in file["restart"]:
                    describe(file["restart"][quantity.name], quantity)


def attributes(header: RunHeader, status: str, failure: tuple[str, str] | None = None) -> dict[str, Any]:
    """The root attributes of a result."""
    values: dict[str, Any] = {
        "fretsolve_version": header.version,
        "format_version": header.format_version,
        "status": status,
        "case_yaml": header.case_yaml,
        "effective_case": header.effective_case,
        "coupling": header.coupling,
        "model": header.model,
        "inputs": header.inputs,
        "provenance": header.provenance,
    }
    return values if failure is None else {**values, "failure": failure[0], "failure_kind": failure[1]}


def _write_attributes(file: Any, header: RunHeader, failure: tuple[str, str] | None) -> None:
    status = "complete" if failure is None else "failed"
    for name, value in attributes(header, status, failure).items():
        if isinstance(value, str):
            add_text(file.id, name, value)
        else:
            file.attrs[name] = value
