"""The columns of a history in the result file: HDF5 reads every number, and its checksums hold."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from fake_states import fake_header, fake_states
from hypothesis import given, settings
from hypothesis import strategies as st

from fretsolve.result.layout import ERRORS, HISTORY
from fretsolve.result.parts import write_result
from fretsolve.result.state import Summary, SummaryErrors

NUMBERS = st.floats(width=64) | st.just(0.0) | st.just(np.frombuffer(b"\xff" * 8)[0])


def summaries_of(values: list[float]) -> list[Summary]:
    (state,) = fake_states(1)
    whole = {quantity.name for quantity in HISTORY if quantity.dtype == "int64"} | {"step"}
    return [
        Summary(**{f.name: step if f.name in whole else value for f in fields(state.summary)})
        for step, value in enumerate(values)
    ]


@contextmanager
def result_of(summaries: list[Summary], errors: list[SummaryErrors] | None = None) -> Iterator[Path]:
    """Write a result that has no fields."""
    (state,) = fake_states(1)
    bars = errors or [None] * len(summaries)
    states = [replace(state, summary=row, errors=bar) for row, bar in zip(summaries, bars, strict=True)]
    header = fake_header(stored=(), every=len(summaries) + 1, errors=errors is not None)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.h5"
        write_result(out, Path(folder), header, [], states, states[-1] if states else None, "complete")
        yield out


@settings(deadline=None, max_examples=30)
@given(st.lists(NUMBERS, min_size=1, max_size=40))
def test_hdf5_reads_what_was_put_in(values: list[float]) -> None:
    summaries = summaries_of(values)
    errors = [SummaryErrors(*[value] * len(ERRORS)) for value in values]
    with result_of(summaries, errors) as out, h5py.File(out) as file:
        assert file["history/step"][:].tolist() == list(range(len(values)))
        for quantity in (*HISTORY, *ERRORS):
            dataset = file["history"][quantity.name]
            expected = np.arange(len(values)) if quantity.dtype == "int64" else np.array(values)
            np.testing.assert_array_equal(dataset[:], expected)
            assert dataset.attrs["units"] == quantity.units
            assert dataset.dims[0][0].name == "/history/step"


@pytest.mark.parametrize("increments", [0, 1, 20_000])
def test_any_number_of_increments(increments: int) -> None:
    with result_of(summaries_of([1.5] * increments)) as out, h5py.File(out) as file:
        assert list(file["history"]) == sorted(["step", *(quantity.name for quantity in HISTORY)])
        np.testing.assert_array_equal(file["history/P"][:], [1.5] * increments)


def test_columns_of_error_bars_are_there_before_the_first_increment() -> None:
    with result_of([], []) as out, h5py.File(out) as file:
        assert file["history/P_error"].shape == (0,)
