"""The writer refuses foreign files, resumes its own, and makes identical files of identical runs."""

from __future__ import annotations

import io
import itertools
import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import h5py
import pytest
from command_line import assert_same_result
from fake_states import assert_same_state, fake_header, fake_states

from fretsolve.errors import CaseError, FileError
from fretsolve.result import HistoryWriter, RunHeader, layout, open_result
from fretsolve.result.lock import RunLock
from fretsolve.result.parts import all_parts, contiguous_parts, parts_folder
from fretsolve.result.writer import MERGE_EVERY
from fretsolve.system import atomic_files


def write(out: Path, header: RunHeader, stop_after: int | None = None, count: int = 6, **options: bool) -> None:
    """A run of `count` increments, left without an end after `stop_after` of them."""
    with HistoryWriter.open(out, header, **options) as writer:
        for state in fake_states(count, writer.last_state, shape=header.shape, errors=header.errors):
            writer.append(state)
            if state.summary.step + 1 == stop_after:
                return
        writer.finish("complete")


def flip_in_pressure(data: bytes) -> bytes:
    with h5py.File(io.BytesIO(data)) as file:
        flipped = file["fields/pressure"].id.get_chunk_info(0).byte_offset + 5
    return data[:flipped] + bytes([data[flipped] ^ 255]) + data[flipped + 1 :]


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


def test_identical_runs_give_identical_files_and_leave_nothing_else(tmp_path: Path) -> None:
    for name in ("one.h5", "two.h5"):
        write(tmp_path / name, fake_header())
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "two.h5").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.h5", "two.h5"]


@pytest.mark.parametrize("every", [1, 2, 4, 7])
@pytest.mark.parametrize("stop_after", [1, 3, 5, 6])
def test_resumed_run_gives_the_file_of_an_uninterrupted_one(tmp_path: Path, every: int, stop_after: int) -> None:
    header = fake_header(every=every, stored=("shear", "zone"), errors=every < 3)
    write(tmp_path / "whole.h5", header)
    write(tmp_path / "halves.h5", header, stop_after=stop_after)
    write(tmp_path / "halves.h5", header, resume=True)
    assert (tmp_path / "whole.h5").read_bytes() == (tmp_path / "halves.h5").read_bytes()


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("stored", [("pressure", "shear", "slip", "gap"), ()])
def test_resume_finds_the_last_state_bit_for_bit(out: Path, dtype: str, stored: tuple[str, ...]) -> None:
    states = list(fake_states(3, dtype=dtype, errors=not stored))
    header = fake_header(stored=stored, errors=not stored)
    with HistoryWriter.open(out, header) as writer:
        for state in states:
            writer.append(state)
    with HistoryWriter.open(out, header, resume=True) as writer:
        assert writer.last_state is not None
        assert_same_state(writer.last_state, states[-1])
        assert writer.summaries == [state.summary for state in states]


def test_resume_without_anything_starts_anew(out: Path) -> None:
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert (writer.last_state, writer.summaries, writer.complete) == (None, [], False)
    assert not parts_folder(out).exists() or not contiguous_parts(parts_folder(out))


def test_resume_of_a_complete_result_has_nothing_to_do(out: Path) -> None:
    write(out, fake_header())
    before = out.stat()
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert writer.complete
        assert len(writer.summaries) == 6
    after = out.stat()
    assert (after.st_ino, after.st_size, after.st_mtime_ns) == (before.st_ino, before.st_size, before.st_mtime_ns)
    assert not parts_folder(out).exists()


def test_leftover_parts_of_a_complete_result_are_cleared(out: Path) -> None:
    write(out, fake_header(), stop_after=4)
    kept = {path.name: path.read_bytes() for path in parts_folder(out).iterdir()}
    write(out, fake_header(), resume=True)
    parts_folder(out).mkdir()
    for name, data in kept.items():
        (parts_folder(out) / name).write_bytes(data)
    (parts_folder(out) / "out.h5.0123abcd.tmp").write_bytes(b"half")
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert writer.complete
    assert not parts_folder(out).exists()


def beside_parts(out: Path, stop_after: int, end: str, increments: int) -> dict[str, bytes]:
    """Write parts of `stop_after` increments, and beside them a result of `increments`; return the parts."""
    write(out, fake_header(), stop_after=stop_after)
    kept = {path.name: path.read_bytes() for path in parts_folder(out).iterdir()}
    shutil.rmtree(parts_folder(out))
    with HistoryWriter.open(out, fake_header()) as writer:
        for state in fake_states(increments):
            writer.append(state)
        writer.finish("complete" if end == "complete" else "failed")
    parts_folder(out).mkdir()
    for name, data in kept.items():
        (parts_folder(out) / name).write_bytes(data)
    return kept


def overwrite_chunk(out: Path, name: str) -> None:
    """Damage the first chunk of a dataset, as a bad disk does."""
    with h5py.File(out) as file:
        chunk = file[name].id.get_chunk_info(0)
    data = bytearray(out.read_bytes())
    data[chunk.byte_offset : chunk.byte_offset + chunk.size] = b"\xa5" * chunk.size
    out.write_bytes(data)


@pytest.mark.parametrize(
    ("end", "increments", "damaged"),
    [("complete", 6, "fields/pressure"), ("failed", 4, "restart/displacement_x"), ("failed", 4, "history/P")],
)
def test_a_damaged_result_removes_no_saved_increments(tmp_path: Path, end: str, increments: int, damaged: str) -> None:
    write(tmp_path / "whole.h5", fake_header())
    out = tmp_path / "out.h5"
    beside_parts(out, 4, end, increments)
    overwrite_chunk(out, damaged)
    wrong = out.read_bytes()
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 4
        assert not writer.complete
        assert writer.notes[-1].endswith("going on from out.h5.parts. The file was moved to out.h5.damaged-1")
    assert (tmp_path / "out.h5.damaged-1").read_bytes() == wrong
    write(out, fake_header(), resume=True)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_a_result_without_a_header_removes_no_saved_increments(out: Path) -> None:
    kept = beside_parts(out, 4, "complete", 6)
    overwrite_chunk(out, "header/json")
    with pytest.raises(FileError, match=r"stay: move this file away, and --resume goes on"):
        HistoryWriter.open(out, fake_header(), resume=True)
    assert {path.name: path.read_bytes() for path in parts_folder(out).iterdir()} | kept == kept


def test_a_damaged_result_beside_parts_without_a_header_is_refused(out: Path) -> None:
    beside_parts(out, 4, "failed", 4)
    overwrite_chunk(out, "fields/pressure")
    (parts_folder(out) / "header.json").unlink()
    with pytest.raises(FileError, match=r"cannot be used instead: header\.json or the first of them is missing"):
        HistoryWriter.open(out, fake_header(), resume=True)
    assert len(all_parts(parts_folder(out))) == 4


def test_parts_of_another_run_beside_a_result_stay(out: Path) -> None:
    beside_parts(out, 4, "complete", 6)
    other = fake_header(max_iterations=2, tolerance=1e-7).to_json()
    (parts_folder(out) / "header.json").write_text(other)
    with pytest.raises(FileError, match=r"holds a run of another case: solver\.tolerance"):
        HistoryWriter.open(out, fake_header(), resume=True)
    assert len(all_parts(parts_folder(out))) == 4


@pytest.mark.parametrize(("saved", "failed", "found"), [(4, 2, 4), (4, 4, 4), (3, 5, 5)])
def test_of_a_failed_result_and_its_parts_the_longer_is_taken(
    tmp_path: Path, saved: int, failed: int, found: int
) -> None:
    write(tmp_path / "whole.h5", fake_header())
    out = tmp_path / "out.h5"
    beside_parts(out, saved, "failed", failed)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == found
        assert len(writer.notes) == (saved > failed)
    write(out, fake_header(), resume=True)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_a_failed_result_wins_over_damaged_parts(out: Path) -> None:
    beside_parts(out, 4, "failed", 3)
    overwrite_chunk(parts_folder(out) / "000001-000001.h5", "fields/pressure")
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 3


def test_a_file_may_be_written_twice_at_the_same_time(tmp_path: Path) -> None:
    target, stale = tmp_path / "table.csv", tmp_path / "table.csv.0123abcd.tmp"
    stale.touch()
    os.utime(stale, (0.0, 0.0))
    with atomic_files.new_file(target) as first:
        first.write(b"first")
        with atomic_files.new_file(target) as second:
            second.write(b"second")
        assert target.read_bytes() == b"second"
    assert target.read_bytes() == b"first"
    assert list(tmp_path.iterdir()) == [target]


def test_existing_result_is_not_touched_without_an_option(out: Path) -> None:
    write(out, fake_header())
    before = out.read_bytes()
    with pytest.raises(CaseError, match=r"out\.h5: exists: --overwrite replaces it, --resume"):
        HistoryWriter.open(out, fake_header())
    assert out.read_bytes() == before
    write(out, fake_header(increments=3), overwrite=True, count=3)
    assert open_result(out).increments == 3


def test_stopped_run_is_not_touched_without_an_option(out: Path) -> None:
    write(out, fake_header(), stop_after=2)
    with pytest.raises(CaseError, match="a stopped run is there: --resume goes on with it, --overwrite"):
        HistoryWriter.open(out, fake_header())
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", 2)
    write(out, fake_header(), overwrite=True, stop_after=1)
    assert open_result(out).increments == 1


def test_run_killed_before_its_first_increment_needs_no_option(out: Path) -> None:
    killed = HistoryWriter.open(out, fake_header())
    header = (parts_folder(out) / "header.json").read_bytes()
    killed.stop()
    parts_folder(out).mkdir()
    (parts_folder(out) / "header.json").write_bytes(header)
    write(out, fake_header(title="another"))
    assert open_result(out).increments == 6


def test_folder_in_the_way(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="is a folder"):
        HistoryWriter.open(tmp_path, fake_header(), overwrite=True)


@pytest.mark.parametrize("stop_after", [2, None])
def test_resume_of_another_case_names_what_differs(out: Path, stop_after: int | None) -> None:
    write(out, fake_header(), stop_after=stop_after)
    other = fake_header(increments=9, tolerance=1e-8)
    with pytest.raises(FileError) as caught:
        HistoryWriter.open(out, other, resume=True)
    message = str(caught.value)
    assert "load_path.0.increments is 6 there, 9 now; solver.tolerance is 1e-06 there, 1e-08 now" in message
    assert "\n" not in message


def test_resume_may_change_what_has_no_effect_on_numbers(out: Path) -> None:
    write(out, fake_header(), stop_after=2)
    other = fake_header(title="better title", max_iterations=9000)
    write(out, other, resume=True)
    with open_result(out) as result:
        assert result.case_yaml == "title: better title\n"
        assert result.effective_case["solver"]["max_iterations"] == 9000


def test_resume_of_another_version_is_refused(out: Path) -> None:
    write(out, replace(fake_header(), version="0.0.9"), stop_after=2)
    with pytest.raises(FileError, match=r"begun by fretsolve 0\.0\.9, this is .*finish it with that version"):
        HistoryWriter.open(out, fake_header(), resume=True)


def test_failed_run_keeps_its_increments_and_is_tried_again(tmp_path: Path) -> None:
    header = fake_header(every=4, stored=("slip",), errors=True)
    out = tmp_path / "out.h5"
    states = list(fake_states(6, errors=True))
    with HistoryWriter.open(out, header) as writer:
        for state in states[:3]:
            writer.append(state)
        writer.finish("failed", "load_path.0: sliding")
    with open_result(out) as result:
        assert (result.status, result.increments, result.steps) == ("failed", 3, (2,))
        assert result.attributes["failure"] == "load_path.0: sliding"
    with HistoryWriter.open(out, header, resume=True) as writer:
        assert not out.exists()
        assert writer.last_state is not None
        assert_same_state(writer.last_state, states[2])
        for state in states[3:]:
            writer.append(state)
        writer.finish("complete")
    write(tmp_path / "whole.h5", header)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_run_that_fails_at_its_first_increment(out: Path) -> None:
    with HistoryWriter.open(out, fake_header()) as writer:
        writer.finish("failed", "contact lost")
    with open_result(out) as result:
        assert (result.status, result.increments, result.steps) == ("failed", 0, ())
    write(out, fake_header(), resume=True)
    assert open_result(out).status == "complete"


def test_parts_are_merged_and_keep_one_restart(out: Path) -> None:
    count = 2 * MERGE_EVERY + 3
    header = fake_header(every=5, stored=("pressure",), increments=count)
    write(out, header, stop_after=count, count=count + 1)
    names = [part.path.name for part in all_parts(parts_folder(out))]
    assert names[:2] == ["000000-000031.h5", "000032-000063.h5"]
    assert len(names) == 2 + 3
    with open_result(out) as result:
        assert result.steps == (*range(4, count, 5), count - 1)
        for step, state in enumerate(fake_states(count)):
            if step in result.steps:
                assert (result.field("pressure", step) == state.fields.pressure).all()


def test_damaged_part_is_set_aside_with_a_note_and_computed_again(tmp_path: Path) -> None:
    write(tmp_path / "whole.h5", fake_header())
    out = tmp_path / "out.h5"
    for number, damage in enumerate((lambda data: data[: len(data) // 2], flip_in_pressure, lambda data: b""), 1):
        write(out, fake_header(), stop_after=5, overwrite=True)
        part = parts_folder(out) / "000003-000003.h5"
        part.write_bytes(damage(part.read_bytes()))
        with pytest.raises(FileError, match=r"000003-000003\.h5: "):
            open_result(out).field("pressure", 3)
        with HistoryWriter.open(out, fake_header(), resume=True) as writer:
            assert len(writer.summaries) == 3
            assert len(writer.notes) == 1
            moved = f"What follows was moved to out.h5.parts.damaged-{number}"
            assert writer.notes[0].endswith(f"; going on from increment 3. {moved}")
        aside = tmp_path / f"out.h5.parts.damaged-{number}"
        assert sorted(path.name for path in aside.iterdir()) == ["000003-000003.h5", "000004-000004.h5"]
        write(out, fake_header(), resume=True)
        assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()
        out.unlink()


def test_parts_with_the_checksums_of_earlier_versions_are_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out.h5"
    with monkeypatch.context() as earlier:
        earlier.setitem(layout.FIELD_FILTERS, "fletcher32", True)
        write(out, fake_header(), stop_after=3)
    write(out, fake_header(), resume=True)
    write(tmp_path / "whole.h5", fake_header())
    assert_same_result(out, tmp_path / "whole.h5")


def test_a_clock_that_jumps_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    jumps = itertools.cycle([4e9, 0.0, 1e9, -1e9])
    monkeypatch.setattr("time.time", lambda: next(jumps))
    write(out, fake_header(), stop_after=3)
    for path, when in zip(sorted(parts_folder(out).iterdir()), jumps, strict=False):
        os.utime(path, (when, when))
    write(out, fake_header(), resume=True)
    monkeypatch.undo()
    write(tmp_path / "whole.h5", fake_header())
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_missing_part_ends_what_is_taken_up(out: Path) -> None:
    write(out, fake_header(), stop_after=5)
    (parts_folder(out) / "000002-000002.h5").unlink()
    assert open_result(out).increments == 2
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 2


def test_second_writer_is_refused_until_the_first_ends(out: Path) -> None:
    first = HistoryWriter.open(out, fake_header())
    first.append(next(fake_states(1)))
    for options in ({}, {"resume": True}, {"overwrite": True}):
        with pytest.raises(FileError, match=rf"another run is writing this output \(process {os.getpid()} on "):
            HistoryWriter.open(out, fake_header(), **options)
    assert open_result(out).status == "running"
    first.stop()
    with HistoryWriter.open(out, fake_header(), resume=True) as second:
        assert len(second.summaries) == 1


def test_lock_on_a_removed_folder_is_not_mistaken_for_one_held(tmp_path: Path) -> None:
    lock = RunLock.acquire(tmp_path / "parts")
    lock.release()
    assert not (tmp_path / "parts").exists()
    RunLock.acquire(tmp_path / "parts").release()


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


def test_writes_after_a_failed_one_are_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = atomic_files.WriteThroughFile(tmp_path / "file")
    file.write(b"abc")
    full = Mock(write=Mock(side_effect=OSError(28, "full")))
    monkeypatch.setattr(atomic_files, "os", full)
    file.write(b"def")
    monkeypatch.undo()
    file.write(b"ghi")
    with pytest.raises(OSError, match="full"):
        file.check()
    file.close()
    assert (tmp_path / "file").read_bytes() == b"abc"
