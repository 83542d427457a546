"""The lock of a run, also on file systems without locks."""

from __future__ import annotations

import errno
import fcntl
import os
from pathlib import Path

import pytest
from fake_states import fake_header, fake_states

from fretsolve.errors import BusyError, FileError
from fretsolve.result import HistoryWriter, open_result


def without_locks(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", refuse)


def test_no_locks_available(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    without_locks(monkeypatch, errno.ENOLCK)
    with pytest.raises(FileError, match="cannot begin the result: No locks available"):
        HistoryWriter.open(out, fake_header())
    assert list(tmp_path.iterdir()) == []


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
