"""The header of a run as text: it comes back whole, and damage and other runs are told apart."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_states import fake_header

from fretsolve.errors import FileError
from fretsolve.result.header import CHECKSUM, RunHeader, is_same_run, require_same_run, sealed, unsealed


def test_text_and_back() -> None:
    header = fake_header(errors=True)
    again = RunHeader.from_json(header.to_json())
    assert again.to_json() == header.to_json()
    assert (again.fields, again.every, again.errors, again.shape) == (header.fields, 1, True, (6, 5))
    assert np.array_equal(again.x, header.x)
    assert again.digest == header.digest


def test_a_changed_text_is_damage() -> None:
    text = sealed({"a": 1, "b": [2.5]})
    assert unsealed(text) == {"a": 1, "b": [2.5]}
    for other in (text.replace("2.5", "2.6"), text.replace(CHECKSUM, "md5"), '{"a": 1}', "[1]"):
        with pytest.raises(ValueError, match="the checksum does not match"):
            unsealed(other)


def test_which_increments_keep_their_fields() -> None:
    header = fake_header(every=3)
    assert [step for step in range(7) if header.stores_fields(step)] == [2, 5]


def test_what_changes_no_number_may_change() -> None:
    """Title, expected values and the most iterations of a run that goes on."""
    one, other = (fake_header(**more).attributes("running") for more in ({}, {"title": "b", "max_iterations": 5}))
    assert is_same_run(one, other)
    require_same_run(Path("a.h5"), one, fake_header(title="c", max_iterations=7))


def test_another_case_is_named_by_its_keys() -> None:
    header = fake_header(increments=7, tolerance=1e-5)
    with pytest.raises(FileError) as caught:
        require_same_run(Path("a.h5"), fake_header().attributes("stopped"), header)
    assert "a.h5: holds a run of another case: stage.1.increments is 6 there, 7 now" in str(caught.value)
    assert "solver.tolerance is 1e-06 there, 1e-05 now; give another -o" in str(caught.value)
    assert not is_same_run(fake_header().attributes("stopped"), header.attributes("running"))


def test_error_bars_have_to_be_asked_for_again() -> None:
    there = fake_header(error_bars=True).attributes("stopped")
    require_same_run(Path("a.h5"), there, fake_header(error_bars=True))
    with pytest.raises(FileError, match="holds a run with error bars; add --error-bars, or start anew"):
        require_same_run(Path("a.h5"), there, fake_header(error_bars=False))
    with pytest.raises(FileError, match=r"solver\.error_bars is true there, false now; give another -o"):
        require_same_run(Path("a.h5"), there, fake_header(increments=7, error_bars=False))
    with pytest.raises(FileError, match=r"solver\.error_bars is false there, true now; give another -o"):
        require_same_run(
            Path("a.h5"), fake_header(error_bars=False).attributes("stopped"), fake_header(error_bars=True)
        )


def test_another_version_may_have_other_numbers() -> None:
    with pytest.raises(FileError, match=r"was begun by fretsolve 0\.0\.1, this is .*: finish it with that version"):
        require_same_run(Path("a.h5"), replace(fake_header(), version="0.0.1").attributes("stopped"), fake_header())


def test_files_that_the_case_names_count() -> None:
    one, other = fake_header(), replace(fake_header(), inputs=json.dumps({"map.npy": "0f"}))
    with pytest.raises(FileError, match=r'content of\.map\.npy is absent there, "0f" now'):
        require_same_run(Path("a.h5"), one.attributes("stopped"), other)
