"""Saved increments are never lost: what is damaged, missing or of another run is named."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import assert_same_result, refused
from fake_states import fake_header, fake_states, write_increments

from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, open_result
from fretsolve.result.parts import parts_folder


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("name", ["header.json", "000000-000000.h5"])
def test_saved_increments_are_not_removed(tmp_path: Path, name: str, resume: bool) -> None:
    out = tmp_path / "out.h5"
    write_increments(out, stop_after=3)
    (parts_folder(out) / name).rename(tmp_path / "moved")
    before = sorted(path.name for path in parts_folder(out).glob("*.h5"))
    with pytest.raises(FileError, match=r"holds saved increments, but .* is missing.*put it back, or start anew with"):
        write_increments(out, resume=resume)
    assert sorted(path.name for path in parts_folder(out).glob("*.h5")) == before
    (tmp_path / "moved").rename(parts_folder(out) / name)
    assert write_increments(out, resume=True) == []
    assert open_result(out).increments == 6
    out.unlink()
    write_increments(out, stop_after=3)
    (parts_folder(out) / name).unlink()
    write_increments(out, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["out.h5"]


def test_a_damaged_first_part_is_not_removed(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    write_increments(out, stop_after=3)
    (parts_folder(out) / "000000-000000.h5").write_bytes(b"damaged")
    with pytest.raises(FileError, match="there is no saved state before it: --overwrite starts anew"):
        write_increments(out, resume=True)
    assert len(list(parts_folder(out).glob("*.h5"))) == 3


def test_a_gap_in_the_parts_is_named(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    write_increments(out, stop_after=4)
    missing = tmp_path / "000001-000001.h5"
    (parts_folder(out) / missing.name).rename(missing)
    aside = tmp_path / "out.h5.parts.damaged-1"
    told = f"{parts_folder(out)}: increment 1 is missing; going on from increment 1. What follows was moved to"
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert (writer.notes, len(writer.summaries)) == ([f"{told} {aside.name}"], 1)
    for path in (missing, *aside.iterdir()):  # found again, and put back
        path.rename(parts_folder(out) / path.name)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert (writer.notes, len(writer.summaries)) == ([], 4)
    write_increments(out, resume=True)
    write_increments(tmp_path / "whole.h5")
    assert_same_result(out, tmp_path / "whole.h5")


@pytest.mark.parametrize(("states", "found"), [((4,), 4), ((4, 3, 1), 3), ((4, 3, 2, 1), 1)])
@pytest.mark.parametrize("kind", ["removed", "cut", "of another increment"])
def test_a_run_goes_on_from_the_newest_whole_state(
    tmp_path: Path, states: tuple[int, ...], found: int, kind: str
) -> None:
    out = tmp_path / "out.h5"
    write_increments(out, stop_after=5)
    for step in states:
        path = parts_folder(out) / f"{step:06d}.npz"
        if kind == "cut":
            path.write_bytes(path.read_bytes()[:-100])
        elif kind == "removed":
            path.unlink()
        else:
            shutil.copy(parts_folder(out) / "000000.npz", path)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == found
        (note,) = writer.notes
    assert note.startswith(f"{parts_folder(out)}/000004.npz: ")
    assert f"; going on from increment {found}. What follows was moved to out.h5.parts.damaged-1" in note
    write_increments(out, resume=True)
    write_increments(tmp_path / "whole.h5")
    assert_same_result(out, tmp_path / "whole.h5")


def test_parts_of_another_run(tmp_path: Path) -> None:
    header = fake_header(increments=4)
    other = replace(header, effective_case=header.effective_case.replace("400.0", "300.0"))
    assert other.effective_case != header.effective_case
    for name, one in {"out.h5": header, "other.h5": other}.items():
        with HistoryWriter.open(tmp_path / name, one) as writer:
            for state in fake_states(3):
                writer.append(state)
    out = tmp_path / "out.h5"
    foreign = parts_folder(out) / "000002-000002.h5"
    shutil.copy(parts_folder(tmp_path / "other.h5") / foreign.name, foreign)
    assert refused(4, "show", out) == f"{foreign}: is a part of another run\n"
    renamed = replace(header, case_yaml="# another comment\n", provenance='{"threads": 2}')
    with HistoryWriter.open(out, renamed, resume=True) as writer:
        assert len(writer.summaries) == 2
        assert writer.notes[0].startswith(f"{foreign}: is a part of another run; going on from increment 2.")
