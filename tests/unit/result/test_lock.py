"""The lock of a run, also on file systems without locks."""

from __future__ import annotations

import errno
import fcntl
import os
from pathlib import Path

import pytest
from command_line import invoke
from fake_states import fake_header, fake_states
from small_cases import write_case

from fretsolve.errors import BusyError, FileError
from fretsolve.result import HistoryWriter, open_result
from fretsolve.result.lock import WITHOUT_LOCK


def without_locks(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", refuse)


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP])
def test_a_run_goes_on_without_a_lock_and_warns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    out = tmp_path / "out.h5"
    without_locks(monkeypatch, number)
    with HistoryWriter.open(out, fake_header()) as writer:
        assert writer.notes == [f"{WITHOUT_LOCK} ({os.strerror(number)}): start one at a time"]
    assert list(tmp_path.iterdir()) == []
    with HistoryWriter.open(out, fake_header()) as writer:
        for state in fake_states(2):
            writer.append(state)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 2
        writer.finish("complete")
    assert [path.name for path in tmp_path.iterdir()] == ["out.h5"]
    assert open_result(out).increments == 2


def test_another_error_of_the_lock_is_one_of_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without_locks(monkeypatch, errno.EIO)
    with pytest.raises(FileError, match="cannot begin the result: Input/output error"):
        HistoryWriter.open(tmp_path / "out.h5", fake_header())


@pytest.mark.parametrize("options", [["run", "-q"], ["study", "-q", "--vary", "grid.points=8,12", "--quantity", "P"]])
def test_commands_say_once_that_there_is_no_lock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str]
) -> None:
    without_locks(monkeypatch, errno.EOPNOTSUPP)
    case = write_case(tmp_path)
    done = invoke(*options, case)
    assert done.exit_code == 0
    assert done.stderr.count(WITHOUT_LOCK) == 1
    assert not list(tmp_path.rglob("*.parts"))


def test_a_file_stands_in_where_there_are_no_locks_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    without_locks(monkeypatch, errno.ENOSYS)
    with HistoryWriter.open(out, fake_header()) as writer:
        for state in fake_states(2):
            writer.append(state)
        with pytest.raises(BusyError, match="another run is writing this output"):
            HistoryWriter.open(out, fake_header(), resume=True)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 2
        writer.finish("complete")
    assert [path.name for path in tmp_path.iterdir()] == ["out.h5"]
    assert open_result(out).increments == 2


@pytest.mark.parametrize("kind", ["file", "pipe", "folder"])
def test_what_stands_in_the_way(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "out.h5.parts"
    if kind == "file":
        folder.write_text("mine")
    else:
        folder.mkdir()
        (os.mkfifo if kind == "pipe" else os.mkdir)(folder / "lock")
    with pytest.raises(FileError, match="is in the way of a run's own: remove it, or give another name with -o"):
        HistoryWriter.open(tmp_path / "out.h5", fake_header())
    assert len(list(tmp_path.rglob("*"))) == (1 if kind == "file" else 2)
