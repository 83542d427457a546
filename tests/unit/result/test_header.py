"""The header of a run as text: it comes back whole, and damage and other runs are told apart."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_states import fake_header

from fretsolve.errors import FileError
from fretsolve.result.header import CHECKSUM, RunHeader, require_same_run, sealed, unsealed


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


def test_files_that_the_case_names_count() -> None:
    one, other = fake_header(), replace(fake_header(), inputs=json.dumps({"map.npy": "0f"}))
    with pytest.raises(FileError, match=r'content of\.map\.npy is absent there, "0f" now'):
        require_same_run(Path("a.h5"), one.attributes("stopped"), other)
