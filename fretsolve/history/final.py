"""OUT itself, written once from the parts."""

from __future__ import annotations

import functools
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5d, h5ds, h5p, h5s, h5t

from fretsolve.history import durable
from fretsolve.history.header import RunHeader
from fretsolve.history.layout import (
    ERRORS,
    HISTORY,
    LIBRARY_VERSIONS,
    RESTART,
    STEP,
    Quantity,
    X,
    Y,
    create_field,
    describe,
)
from fretsolve.history.parts import component, copy_fields, write_restart
from fretsolve.state import State, Summary, SummaryErrors

TEXT = h5py.string_dtype()


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
    with durable.new_hdf5(out, folder, _empty_history(len(summaries), header.errors)) as file:
        _write_attributes(file, header, failure)
        _fill_history(file["history"], summaries, errors)
        group = file.create_group("fields")
        scales = (_scale(group, STEP, steps), _scale(group, X, header.x), _scale(group, Y, header.y))
        for quantity in kept:
            dataset = create_field(group, quantity, len(steps), header.shape)
            describe(dataset, quantity)
            _attach(dataset.id, *scales)
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
        file.attrs[name] = value


@functools.lru_cache(maxsize=2)
def _empty_history(increments: int, with_errors: bool) -> bytes:
    """An HDF5 file with the columns of a history that are still to be filled.

    To make them takes several times as long as to fill them, which counts where a sweep has thousands of small cases.
    """
    memory = io.BytesIO()  # the image of an open file would not do: HDF5 1.14 leaves a wrong checksum in it
    with h5py.File(memory, "w", libver=LIBRARY_VERSIONS) as file:
        group = file.create_group("history")
        scale = _scale(group, STEP, np.arange(increments))
        for quantity in HISTORY + (ERRORS if with_errors else ()):
            _attach(_column(group, quantity, np.zeros(increments)), scale)
    return memory.getvalue()


def _fill_history(group: Any, summaries: Sequence[Summary], errors: Sequence[SummaryErrors]) -> None:
    """Put the numbers into the columns of `_empty_history`."""
    for quantities, rows in (((STEP, *HISTORY), summaries), (ERRORS, errors)):
        for quantity in quantities if rows else ():
            values = np.array([getattr(row, quantity.name) for row in rows], quantity.dtype)
            h5d.open(group.id, quantity.name.encode()).write(h5s.ALL, h5s.ALL, values)


def _scale(group: Any, quantity: Quantity, values: Any) -> h5d.DatasetID:
    scale = _column(group, quantity, values)
    h5ds.set_scale(scale, quantity.name.encode())
    return scale


def _column(group: Any, quantity: Quantity, values: Any) -> h5d.DatasetID:
    """A dataset of some numbers, by HDF5's own calls: the objects of h5py would take three times as long."""
    data = np.asarray(values, quantity.dtype)
    layout = h5p.create(h5p.DATASET_CREATE)
    layout.set_obj_track_times(False)
    if data.size:
        layout.set_chunk(data.shape)
        layout.set_fletcher32()
    kind, space = h5t.py_create(data.dtype, logical=True), h5s.create_simple(data.shape)
    dataset = h5d.create(group.id, quantity.name.encode(), kind, space, layout)
    dataset.write(h5s.ALL, h5s.ALL, data)
    text = h5t.py_create(TEXT, logical=True)
    for name, value in ((b"units", quantity.units), (b"long_name", quantity.long_name)):
        h5a.create(dataset, name, text, h5s.create(h5s.SCALAR)).write(np.array(value, TEXT))
    return dataset


def _attach(dataset: h5d.DatasetID, *scales: h5d.DatasetID) -> None:
    for axis, scale in enumerate(scales):
        h5ds.attach_scale(dataset, scale, axis)
