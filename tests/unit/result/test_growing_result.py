"""A run goes on between the opening of its result and the reading of the fields, of which it keeps few."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke
from fake_states import ALL_FIELDS, fake_header, fake_states

from fretsolve.cli.commands import output, plot
from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, Result, open_result
from fretsolve.result.parts import contiguous_parts, parts_folder
from fretsolve.result.state import State

EVERY, SAVED, GOES_ON = 4, 6, 40
"""Increments between stored ones, increments when the result is opened, and those that follow before it is read."""

Opened = Callable[[str | Path], Result]


@pytest.fixture(scope="module")
def states() -> list[State]:
    return list(fake_states(SAVED + GOES_ON))


@pytest.fixture(params=["goes on", "finishes"])
def opened(request: pytest.FixtureRequest, tmp_path: Path, states: list[State]) -> Iterator[Opened]:
    """Return a function like `open_result`, after which the run adds increments, and may finish."""
    with HistoryWriter.open(tmp_path / "out.h5", fake_header(every=EVERY, increments=len(states))) as writer:
        for state in states[:SAVED]:
            writer.append(state)

        def opened_before_more(path: str | Path) -> Result:
            result = open_result(path)
            for state in states[SAVED:]:
                writer.append(state)
            if request.param == "finishes":
                writer.finish("complete")
            return result

        yield opened_before_more


def test_fields_of_the_newest_increment_stay(tmp_path: Path, opened: Opened, states: list[State]) -> None:
    with opened(tmp_path / "out.h5") as result:
        assert (result.status, result.increments, result.steps) == ("running", SAVED, (3, 5))
        for name in ALL_FIELDS:
            np.testing.assert_array_equal(result.field(name), getattr(states[5].fields, name), strict=True)
            np.testing.assert_array_equal(result.field(name, 3), getattr(states[3].fields, name), strict=True)
        result.field("pressure")[:] = -1.0
        values: Any = result.to_xarray().pressure.sel(step=5).values
    np.testing.assert_array_equal(values, states[5].fields.pressure)
    np.testing.assert_array_equal(result.field("pressure"), states[5].fields.pressure)  # also after it is closed


def test_a_growing_result_is_exported(
    tmp_path: Path, opened: Opened, states: list[State], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(output, "open_result", opened)
    done = invoke("export", tmp_path / "out.h5", "--to", "npz")
    assert (done.exit_code, done.stderr) == (0, "")
    with np.load(tmp_path / "out.npz") as arrays:
        assert (arrays["field_steps"].tolist(), len(arrays["P"])) == ([3, 5], SAVED)
        np.testing.assert_array_equal(arrays["gap"], [states[3].fields.gap, states[5].fields.gap])


@pytest.mark.slow
def test_a_growing_result_is_drawn(tmp_path: Path, opened: Opened, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plot, "open_result", opened)
    done = invoke("plot", tmp_path / "out.h5", "map", "--dpi", 20, "-o", tmp_path / "p.png")
    assert (done.exit_code, done.stdout, done.stderr) == (0, f"{tmp_path}/p.png\n", "")


def test_states_that_cannot_be_read_are_named_with_their_fields(tmp_path: Path, states: list[State]) -> None:
    out = tmp_path / "out.h5"
    with HistoryWriter.open(out, fake_header(every=EVERY)) as writer:
        for state in states[:SAVED]:
            writer.append(state)
    newest = contiguous_parts(parts_folder(out))[-1].state
    content = newest.read_bytes()
    newest.write_bytes(content[:-200])
    with open_result(out) as result:
        assert (result.increments, result.field("gap", 3).shape) == (SAVED, (6, 5))
        with pytest.raises(FileError, match=f"{newest.name}: cannot read the file: .*not a zip file"):
            result.field("gap")
        newest.unlink()
        with pytest.raises(FileError, match="the fields of increment 5 are not kept any more"):
            result.field("gap")
        newest.write_bytes(content)
        np.testing.assert_array_equal(result.field("gap"), states[5].fields.gap)
