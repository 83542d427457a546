"""Names of files after a failure: no new ones, of one file and of several that belong together."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from fretsolve.system import atomic_files
from fretsolve.system.files import TakenError


def write_both(folder: Path, second: str = "second", *, exclusive: bool = False) -> None:
    """Write a file in a folder, and one beside that."""
    with atomic_files.all_or_none() as making:
        with making(folder):
            folder.mkdir(exist_ok=True)
        with making(folder / "first"):
            atomic_files.write_text(folder / "first", "new")
        atomic_files.write_text(folder.parent / second, "new", exclusive=exclusive)


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_files_that_belong_together(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        write_both(tmp_path / "both", "none/second")
    assert names(tmp_path) == []
    write_both(tmp_path / "both")
    assert names(tmp_path) == ["both", "both/first", "second"]


def test_what_was_there_stays(tmp_path: Path) -> None:
    (tmp_path / "both").mkdir()
    (tmp_path / "both" / "old").touch()
    with pytest.raises(FileNotFoundError):
        write_both(tmp_path / "both", "none/second")
    assert names(tmp_path) == ["both", "both/old"]
    (tmp_path / "both" / "first").write_text("old")
    (tmp_path / "second").write_text("of another")
    with pytest.raises(TakenError):
        write_both(tmp_path / "both", exclusive=True)
    assert names(tmp_path) == ["both", "both/first", "both/old", "second"]
    assert (tmp_path / "both" / "first").read_text() == "new"  # replaced as a whole
    assert (tmp_path / "second").read_text() == "of another"


@pytest.mark.parametrize("exclusive", [False, True])
def test_a_name_that_cannot_be_synced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, exclusive: bool) -> None:
    def fail(folder: Path) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO), str(folder))

    monkeypatch.setattr(atomic_files, "sync_folder", fail)
    with pytest.raises(OSError, match="Input/output error"):
        atomic_files.write_text(tmp_path / "new", "new", exclusive=exclusive)
    assert names(tmp_path) == []
    (tmp_path / "old").write_text("old")
    with pytest.raises(OSError, match="Input/output error"):
        atomic_files.write_text(tmp_path / "old", "new")
    assert (names(tmp_path), (tmp_path / "old").read_text()) == (["old"], "new")
