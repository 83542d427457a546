"""The writer refuses foreign files, and makes identical files of identical runs."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from fake_states import fake_header, fake_states, write_increments

from fretsolve.errors import CaseError, FileError
from fretsolve.result import HistoryWriter, open_result
from fretsolve.result.lock import RunLock
from fretsolve.result.parts import all_parts, all_states, parts_folder
from fretsolve.result.writer import STATES_KEPT
from fretsolve.system.hdf5_files import dataset_names


@pytest.fixture()
def out(tmp_path: Path) -> Path:
    return tmp_path / "out.h5"


@pytest.mark.parametrize("status", ["complete", "failed"])
def test_a_result_that_another_process_finishes_meanwhile_stays(
    out: Path, monkeypatch: pytest.MonkeyPatch, status: str
) -> None:
    """As that of a case of a sweep which two processes have chosen."""
    acquire = RunLock.acquire

    def after_the_other(folder: Path) -> RunLock:
        monkeypatch.setattr(RunLock, "acquire", acquire)
        with HistoryWriter.open(out, fake_header()) as faster:
            for state in fake_states(2 if status == "failed" else 6):
                faster.append(state)
            faster.finish(status, *(["slides", "sliding"] if status == "failed" else []))
        return acquire(folder)

    monkeypatch.setattr(RunLock, "acquire", after_the_other)
    with HistoryWriter.open(out, fake_header(), resume=True, retry=False) as writer:
        before = out.read_bytes()
        assert writer.complete
        assert len(writer.summaries) == (2 if status == "failed" else 6)
    assert out.read_bytes() == before
    assert not parts_folder(out).exists()
    with HistoryWriter.open(out, fake_header(), resume=True, retry=False) as writer:
        assert writer.complete
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert writer.complete == (status == "complete")


def test_existing_result_is_not_touched_without_an_option(out: Path) -> None:
    write_increments(out, fake_header())
    before = out.read_bytes()
    with pytest.raises(CaseError, match=r"out\.h5: exists: --overwrite replaces it, --resume"):
        HistoryWriter.open(out, fake_header())
    assert out.read_bytes() == before
    write_increments(out, fake_header(increments=3), overwrite=True, count=3)
    assert open_result(out).increments == 3


def test_stopped_run_is_not_touched_without_an_option(out: Path) -> None:
    write_increments(out, fake_header(), stop_after=2)
    with pytest.raises(CaseError, match="a stopped run is there: --resume goes on with it, --overwrite"):
        HistoryWriter.open(out, fake_header())
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", 2)
    write_increments(out, fake_header(), overwrite=True, stop_after=1)
    assert open_result(out).increments == 1


def test_run_killed_before_its_first_increment_needs_no_option(out: Path) -> None:
    killed = HistoryWriter.open(out, fake_header())
    header = (parts_folder(out) / "header.json").read_bytes()
    killed.stop()
    parts_folder(out).mkdir()
    (parts_folder(out) / "header.json").write_bytes(header)
    write_increments(out, fake_header(title="another"))
    assert open_result(out).increments == 6


def test_folder_in_the_way(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="is a folder"):
        HistoryWriter.open(tmp_path, fake_header(), overwrite=True)


def test_few_states_are_kept(out: Path) -> None:
    count = 2 * STATES_KEPT + 4
    header = fake_header(every=5, stored=("pressure",), increments=count)
    write_increments(out, header, stop_after=count, count=count + 1)
    kept = [STATES_KEPT - 1, *range(count - STATES_KEPT, count)]
    assert [path.name for path in all_states(parts_folder(out))] == [f"{step:06d}.npz" for step in kept]
    with open_result(out) as result:
        assert result.steps == (*range(4, count, 5), count - 1)
        for step, state in enumerate(fake_states(count)):
            if step in result.steps:
                assert (result.field("pressure", step) == state.fields.pressure).all()


def test_increments_of_a_pause_share_a_part(out: Path) -> None:
    header, states = fake_header(increments=8), list(fake_states(8))
    with HistoryWriter.open(out, header, pause=1000.0) as writer:
        for state in states[:-1]:
            writer.append(state)
            if state.summary.step in (2, 3, 6):
                assert not writer.is_saved(state.summary.step)
                writer.save()
                assert writer.is_saved(state.summary.step)
    names = [part.path.name for part in all_parts(parts_folder(out))]
    assert names == ["000000-000002.h5", "000003-000003.h5", "000004-000006.h5"]
    with HistoryWriter.open(out, header, resume=True) as writer:
        writer.append(states[-1])
        writer.finish("complete")
    write_increments(out.with_name("whole.h5"), header, count=8)
    assert out.read_bytes() == out.with_name("whole.h5").read_bytes()


def test_increments_must_follow_each_other(out: Path) -> None:
    states = list(fake_states(2))
    with HistoryWriter.open(out, fake_header()) as writer, pytest.raises(ValueError, match="increment 1"):
        writer.append(states[1])


def test_resume_and_overwrite_exclude_each_other(out: Path) -> None:
    with pytest.raises(ValueError, match="exclude"):
        HistoryWriter.open(out, fake_header(), resume=True, overwrite=True)


def test_overwrite_leaves_files_alone_that_are_no_results(out: Path) -> None:
    out.write_text("title: another case\n")
    with pytest.raises(FileError, match="is not an HDF5 file"):
        HistoryWriter.open(out, fake_header(), overwrite=True)
    assert out.read_text() == "title: another case\n"


def test_folder_that_cannot_be_written() -> None:
    rights = os.geteuid()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o555)
        if rights == 0:  # root could write it all the same
            os.seteuid(65534)
        try:
            with pytest.raises(FileError, match="cannot begin the result: Permission denied"):
                HistoryWriter.open(folder / "out.h5", fake_header())
        finally:
            os.seteuid(rights)
        assert list(folder.iterdir()) == []


def test_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot begin the result: No such file or directory"):
        HistoryWriter.open(tmp_path / "nowhere" / "out.h5", fake_header())


@pytest.mark.parametrize("every", [1, 3])
def test_a_pause_changes_no_number_of_the_result(tmp_path: Path, every: int) -> None:
    """Increments that wait to be saved keep the fields that are stored, and the last one all of it."""
    header = fake_header(stored=("pressure", "slip", "zone"), every=every)
    for name, pause in (("at_once.h5", 0.0), ("paused.h5", 1e6)):
        with HistoryWriter.open(tmp_path / name, header, pause=pause) as writer:
            for state in fake_states(4):
                writer.append(state)
            assert len(all_parts(parts_folder(tmp_path / name))) == (0 if pause else 4)
            writer.finish("failed", "slides", "sliding")
    with h5py.File(tmp_path / "paused.h5") as paused, h5py.File(tmp_path / "at_once.h5") as at_once:
        names = dataset_names(paused)
        assert names == dataset_names(at_once)
        assert {"fields/slip_x", "restart"} < set(names)
        for name in names:
            np.testing.assert_array_equal(paused[name][()], at_once[name][()], err_msg=name)
