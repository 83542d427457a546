"""A stopped, failed or damaged run is gone on from without a loss."""

from __future__ import annotations

import io
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import pytest
from fake_states import assert_same_state, fake_header, fake_states, write_increments

from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, open_result
from fretsolve.result.parts import all_parts, parts_folder


def flip_in_pressure(data: bytes) -> bytes:
    with h5py.File(io.BytesIO(data)) as file:
        flipped = file["fields/pressure"].id.get_chunk_info(0).byte_offset + 5
    return data[:flipped] + bytes([data[flipped] ^ 255]) + data[flipped + 1 :]


@pytest.fixture()
def out(tmp_path: Path) -> Path:
    return tmp_path / "out.h5"


@pytest.mark.parametrize(("every", "stop_after"), [(1, 1), (1, 6), (2, 3), (4, 5), (7, 3)])
def test_resumed_run_gives_the_file_of_an_uninterrupted_one(tmp_path: Path, every: int, stop_after: int) -> None:
    header = fake_header(every=every, stored=("shear", "zone"), errors=every < 3)
    write_increments(tmp_path / "whole.h5", header)
    write_increments(tmp_path / "halves.h5", header, stop_after=stop_after)
    write_increments(tmp_path / "halves.h5", header, resume=True)
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


def test_resume_of_a_complete_result_has_nothing_to_do(out: Path) -> None:
    write_increments(out, fake_header())
    before = out.stat()
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert writer.complete
        assert len(writer.summaries) == 6
    after = out.stat()
    assert (after.st_ino, after.st_size, after.st_mtime_ns) == (before.st_ino, before.st_size, before.st_mtime_ns)
    assert not parts_folder(out).exists()


def test_leftover_parts_of_a_complete_result_are_cleared(out: Path) -> None:
    write_increments(out, fake_header(), stop_after=4)
    kept = {path.name: path.read_bytes() for path in parts_folder(out).iterdir()}
    write_increments(out, fake_header(), resume=True)
    parts_folder(out).mkdir()
    for name, data in kept.items():
        (parts_folder(out) / name).write_bytes(data)
    (parts_folder(out) / "out.h5.0123456789abcdef.tmp").write_bytes(b"half")
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert writer.complete
    assert not parts_folder(out).exists()


def beside_parts(out: Path, stop_after: int, end: str, increments: int) -> dict[str, bytes]:
    """Write parts of `stop_after` increments, and beside them a result of `increments`; return the parts."""
    write_increments(out, fake_header(), stop_after=stop_after)
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


def overwrite(out: Path, name: str) -> None:
    """Damage the first values of a dataset, as a bad disk does."""
    data = bytearray(out.read_bytes())
    with h5py.File(out) as file:
        if file[name].chunks is None:  # a short column
            values = file[name][:].tobytes()
            place, size = data.index(values), len(values)
        else:
            chunk = file[name].id.get_chunk_info(0)
            place, size = chunk.byte_offset, chunk.size
    data[place : place + size] = b"\xa5" * size
    out.write_bytes(data)


@pytest.mark.parametrize(
    ("end", "increments", "damaged"),
    [("complete", 6, "fields/pressure"), ("failed", 4, "restart"), ("failed", 4, "history/P")],
)
def test_a_damaged_result_removes_no_saved_increments(tmp_path: Path, end: str, increments: int, damaged: str) -> None:
    write_increments(tmp_path / "whole.h5", fake_header())
    out = tmp_path / "out.h5"
    beside_parts(out, 4, end, increments)
    overwrite(out, damaged)
    wrong = out.read_bytes()
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 4
        assert not writer.complete
        assert writer.notes[-1].endswith("going on from out.h5.parts. The file was moved to out.h5.damaged-1")
    assert (tmp_path / "out.h5.damaged-1").read_bytes() == wrong
    write_increments(out, fake_header(), resume=True)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_a_result_without_a_header_removes_no_saved_increments(out: Path) -> None:
    kept = beside_parts(out, 4, "complete", 6)
    overwrite(out, "header/json")
    with pytest.raises(FileError, match=r"stay: move this file away, and --resume goes on"):
        HistoryWriter.open(out, fake_header(), resume=True)
    assert {path.name: path.read_bytes() for path in parts_folder(out).iterdir()} | kept == kept


def test_a_damaged_result_beside_parts_without_a_header_is_refused(out: Path) -> None:
    beside_parts(out, 4, "failed", 4)
    overwrite(out, "fields/pressure")
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
    write_increments(tmp_path / "whole.h5", fake_header())
    out = tmp_path / "out.h5"
    beside_parts(out, saved, "failed", failed)
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == found
        assert len(writer.notes) == (saved > failed)
    write_increments(out, fake_header(), resume=True)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


@pytest.mark.parametrize("stop_after", [2, None])
def test_resume_of_another_case_names_what_differs(out: Path, stop_after: int | None) -> None:
    write_increments(out, fake_header(), stop_after=stop_after)
    other = fake_header(increments=9, tolerance=1e-8)
    with pytest.raises(FileError) as caught:
        HistoryWriter.open(out, other, resume=True)
    message = str(caught.value)
    assert "stage.1.increments is 6 there, 9 now; solver.tolerance is 1e-06 there, 1e-08 now" in message
    assert "\n" not in message


def test_resume_may_change_what_has_no_effect_on_numbers(out: Path) -> None:
    write_increments(out, fake_header(), stop_after=2)
    other = fake_header(title="better title", max_iterations=9000)
    write_increments(out, other, resume=True)
    with open_result(out) as result:
        assert result.case_yaml == "title: better title\n"
        assert result.effective_case["solver"]["max_iterations"] == 9000


def test_resume_of_another_version_is_refused(out: Path) -> None:
    write_increments(out, replace(fake_header(), version="0.0.9"), stop_after=2)
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
    write_increments(tmp_path / "whole.h5", header)
    assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_run_that_fails_at_its_first_increment(out: Path) -> None:
    with HistoryWriter.open(out, fake_header()) as writer:
        writer.finish("failed", "contact lost")
    with open_result(out) as result:
        assert (result.status, result.increments, result.steps) == ("failed", 0, ())
    write_increments(out, fake_header(), resume=True)
    assert open_result(out).status == "complete"


def test_damaged_part_is_set_aside_with_a_note_and_computed_again(tmp_path: Path) -> None:
    write_increments(tmp_path / "whole.h5", fake_header())
    out = tmp_path / "out.h5"
    for number, damage in enumerate((lambda data: data[: len(data) // 2], flip_in_pressure, lambda data: b""), 1):
        write_increments(out, fake_header(), stop_after=5, overwrite=True)
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
        write_increments(out, fake_header(), resume=True)
        assert out.read_bytes() == (tmp_path / "whole.h5").read_bytes()
        out.unlink()
