"""Saved increments are never lost: what is damaged, missing or of another run is named."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pytest
from command_line import assert_same_result, invoke, refused
from fake_states import fake_header, fake_states, write_fake, write_increments

from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, open_result, writer
from fretsolve.result.parts import parts_folder
from fretsolve.system import atomic_files


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
    with pytest.raises(FileError, match="there is no saved increment before it: --overwrite starts anew"):
        write_increments(out, resume=True)
    assert len(list(parts_folder(out).glob("*.h5"))) == 3


def merged_and_single(out: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stop a run so that a merged part of increments 0 to 3 lies beside its single parts, and return it."""
    with monkeypatch.context() as patch:
        patch.setattr(writer, "MERGE_EVERY", 4)
        patch.setattr(atomic_files, "remove", lambda *files: None)  # as if a kill came before they were removed
        write_increments(out, stop_after=5)
    merged = parts_folder(out) / "000000-000003.h5"
    assert merged.exists()
    assert len(list(parts_folder(out).glob("*.h5"))) == 6
    return merged


def test_single_parts_stand_in_for_a_damaged_merged_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    merged = merged_and_single(out, monkeypatch)
    merged.write_bytes(merged.read_bytes()[:-500])
    with HistoryWriter.open(out, fake_header(), resume=True) as resumed:
        assert len(resumed.summaries) == 5
        (note,) = resumed.notes
    assert note.startswith(f"{merged}: ")
    assert note.endswith("; its increments are taken from the parts that it was merged from")
    assert write_increments(out, resume=True) == []
    write_increments(tmp_path / "whole.h5")
    assert_same_result(out, tmp_path / "whole.h5")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.h5", "whole.h5"]


def test_some_single_parts_stand_in_for_a_damaged_merged_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    merged = merged_and_single(out, monkeypatch)
    merged.write_bytes(b"damaged")
    (parts_folder(out) / "000002-000002.h5").unlink()
    with HistoryWriter.open(out, fake_header(), resume=True) as resumed:
        assert len(resumed.summaries) == 2
        (note,) = resumed.notes
    assert note.startswith(f"{merged}: ")
    assert "; going on from increment 2. What follows was moved to out.h5.parts.damaged-1" in note
    aside = tmp_path / "out.h5.parts.damaged-1"
    assert sorted(path.name for path in aside.iterdir()) == [merged.name, "000003-000003.h5", "000004-000004.h5"]
    write_increments(out, resume=True)
    write_increments(tmp_path / "whole.h5")
    assert_same_result(out, tmp_path / "whole.h5")


def test_single_parts_stay_until_the_merged_one_is_verified(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, merge_parts = tmp_path / "out.h5", writer.merge_parts

    def damaging(folder: Path, *words: Any) -> Any:
        part = merge_parts(folder, *words)
        part.path.write_bytes(part.path.read_bytes()[:-500])
        return part

    with monkeypatch.context() as patch:
        patch.setattr(writer, "MERGE_EVERY", 4)
        patch.setattr(writer, "merge_parts", damaging)
        with pytest.raises(FileError, match=r"000000-000003\.h5"):
            write_increments(out)
    single = {f"{step:06d}-{step:06d}.h5" for step in range(4)}
    assert {path.name for path in parts_folder(out).glob("*.h5")} == {*single, "000000-000003.h5"}
    assert "are taken from the parts" in write_increments(out, resume=True)[0]
    assert open_result(out).increments == 6


def test_a_gap_in_the_parts_is_named(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    write_increments(out, stop_after=4)
    missing = tmp_path / "000001-000001.h5"
    (parts_folder(out) / missing.name).rename(missing)
    aside = tmp_path / "out.h5.parts.damaged-1"
    told = f"increment 1 is missing in {parts_folder(out)}; going on from increment 1. What follows was moved to"
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert (writer.notes, len(writer.summaries)) == ([f"{told} {aside.name}"], 1)
    for path in (missing, *aside.iterdir()):  # found again, and put back
        path.rename(parts_folder(out) / path.name)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert (writer.notes, len(writer.summaries)) == ([], 4)
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


def test_parts_that_do_not_say_of_which_run_they_are(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5", "stopped", increments=6)
    for path in parts_folder(out).glob("0*.h5"):
        with h5py.File(path, "r+") as file:
            del file["run"]
    assert invoke("show", out).exit_code == 0
    with HistoryWriter.open(out, fake_header(increments=6), resume=True) as writer:
        assert (len(writer.summaries), writer.notes) == (4, [])
