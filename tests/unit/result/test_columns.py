"""The columns of a history made as an image: HDF5 reads every number, and its checksums hold."""

from __future__ import annotations

import io
from dataclasses import fields

import h5py
import numpy as np
import pytest
from fake_states import fake_states
from hypothesis import given
from hypothesis import strategies as st

from fretsolve.result.columns import history_image
from fretsolve.result.layout import ERRORS, HISTORY
from fretsolve.result.state import Summary, SummaryErrors

NUMBERS = st.floats(width=64) | st.just(0.0) | st.just(np.frombuffer(b"\xff" * 8)[0])


def summaries_of(values: list[float]) -> list[Summary]:
    (state,) = fake_states(1)
    whole = {quantity.name for quantity in HISTORY if quantity.dtype == "int64"} | {"step"}
    return [
        Summary(**{f.name: step if f.name in whole else value for f in fields(state.summary)})
        for step, value in enumerate(values)
    ]


@given(st.lists(NUMBERS, min_size=1, max_size=40))
def test_hdf5_reads_what_was_put_in(values: list[float]) -> None:
    summaries = summaries_of(values)
    errors = [SummaryErrors(*[value] * len(ERRORS)) for value in values]
    with h5py.File(io.BytesIO(history_image(summaries, errors)), "r") as file:
        assert file["history/step"][:].tolist() == list(range(len(values)))
        for quantity in (*HISTORY, *ERRORS):
            dataset = file["history"][quantity.name]
            expected = np.arange(len(values)) if quantity.dtype == "int64" else np.array(values)
            assert dataset.fletcher32
            np.testing.assert_array_equal(dataset[:], expected)  # raises OSError where a checksum is wrong
            assert dataset.attrs["units"] == quantity.units


@pytest.mark.parametrize("increments", [0, 1, 20_000])
def test_any_number_of_increments(increments: int) -> None:
    summaries = summaries_of([1.5] * increments)
    with h5py.File(io.BytesIO(history_image(summaries, None)), "r") as file:
        assert list(file["history"]) == sorted(["step", *(quantity.name for quantity in HISTORY)])
        np.testing.assert_array_equal(file["history/P"][:], [1.5] * increments)


def test_columns_of_error_bars_are_there_before_the_first_increment() -> None:
    with h5py.File(io.BytesIO(history_image([], [])), "r") as file:
        assert file["history/P_error"].shape == (0,)


def test_a_flipped_bit_is_found() -> None:
    image = bytearray(history_image(summaries_of([1.25, 2.5, 3.75]), None))
    place = bytes(image).index(np.array([1.25, 2.5, 3.75]).tobytes())
    image[place] ^= 1
    with h5py.File(io.BytesIO(bytes(image)), "r") as file, pytest.raises(OSError, match="filter returned failure"):
        file["history/P"][:]
