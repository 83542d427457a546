"""What may be written over what, and how the system's refusals are told."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from fretsolve.errors import CaseError, FileError
from fretsolve.system.files import (
    TakenError,
    make_folder,
    reported,
    require_ending,
    require_free,
    require_other,
    writing,
)


def test_a_system_error_names_file_and_reason() -> None:
    with pytest.raises(FileError) as caught, reported("cannot be read", Path("a.h5"), "; give another"):
        raise PermissionError(errno.EACCES, "denied", "other name")
    assert str(caught.value) == "a.h5: cannot be read: Permission denied; give another"


def test_an_error_without_a_number_keeps_its_words() -> None:
    with pytest.raises(FileError, match=r"^a.h5: cannot be written: truncated$"), writing("a.h5"):
        raise OSError("truncated")


def test_a_name_taken_meanwhile() -> None:
    with pytest.raises(FileError, match=r"^a.h5: another file has taken this name meanwhile"), writing("a.h5"):
        raise TakenError(errno.EEXIST, "exists")


def test_folders(tmp_path: Path) -> None:
    make_folder(tmp_path / "a" / "b")
    make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="cannot be made a folder"):
        make_folder(tmp_path / "file" / "c")


def test_files_that_exist_are_kept(tmp_path: Path) -> None:
    there, new = tmp_path / "a.h5", tmp_path / "b.h5"
    there.touch()
    require_free(new)
    require_free(new, there, overwrite=True)
    with pytest.raises(CaseError, match=r"a\.h5: exists: --overwrite replaces it, or give another name with -o$"):
        require_free(new, there)
    with pytest.raises(CaseError, match="is a folder; the name of a file is needed"):
        require_free(tmp_path, overwrite=True)


def test_an_input_is_not_replaced_by_any_of_its_names(tmp_path: Path) -> None:
    source, link, hard = tmp_path / "case.yaml", tmp_path / "link.yaml", tmp_path / "hard.yaml"
    source.touch()
    link.symlink_to(source)
    hard.hardlink_to(source)
    require_other(tmp_path / "other.yaml", source, "the case")
    for name in (source, tmp_path / "." / "case.yaml", link, hard):
        with pytest.raises(CaseError, match="would replace the case; give another name with -o"):
            require_other(name, source, "the case")


def test_endings() -> None:
    require_ending(Path("a.CSV"), "a table", ".csv", ".parquet")
    with pytest.raises(CaseError, match=r"a\.txt: the name of a table must end in \.csv or \.parquet$"):
        require_ending(Path("a.txt"), "a table", ".csv", ".parquet")
