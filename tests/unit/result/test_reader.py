"""Results as fretsolve, h5py and xarray read them, and the messages on files that cannot be read."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from fake_states import fake_header, fake_states, write_fake

from fretsolve import __version__, open_result
from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, part_reader, reader
from fretsolve.result.header import read_sealed, write_sealed
from fretsolve.result.layout import FIELDS, FORMAT_VERSION, HISTORY
from fretsolve.result.part_reader import Steps
from fretsolve.result.parts import Part, component, parts_folder

COUNT = 4


@pytest.mark.parametrize("end", ["complete", "failed", "stopped"])
@pytest.mark.parametrize("every", [1, 3])
def test_all_that_was_written_is_read(tmp_path: Path, end: str, every: int) -> None:
    states = list(fake_states(COUNT))
    with open_result(write_fake(tmp_path / "out.h5", end, every=every)) as result:
        assert repr(result) == f"<Result {tmp_path / 'out.h5'} {end}, 4 increments>"
        assert (result.status, result.coupling, result.case_yaml) == (end, "tangential", "title: made up\n")
        assert result.effective_case["load_path"] == [{"P": 400.0, "increments": 6}]
        assert (result.x.tolist(), result.y.shape) == (fake_header().x.tolist(), (5,))
        assert result.steps == ((0, 1, 2, 3) if every == 1 else (2, 3))
        for quantity in HISTORY:
            expected = [getattr(state.summary, quantity.name) for state in states]
            assert result.history[quantity.name].tolist() == expected
            assert result.history[quantity.name].dtype == quantity.dtype
        for quantity in FIELDS:
            for step in result.steps:
                np.testing.assert_array_equal(
                    result.field(quantity.name, step), component(states[step], quantity), strict=True
                )
            np.testing.assert_array_equal(result.field(quantity.name), component(states[-1], quantity), strict=True)
        assert result.units("Mz") == "N mm"
        assert result.units("shear_x") == "MPa"


def test_steps_are_found_as_in_a_tuple() -> None:
    steps = Steps([3, 5, 9, 5])
    assert (5 in steps, 4 in steps, "5" in steps) == (True, False, False)
    assert (steps, steps[1:3], steps.index(5), steps.index(5, 2)) == ((3, 5, 9, 5), (5, 9), 1, 3)
    with pytest.raises(ValueError, match="not in tuple"):
        steps.index(4)


@pytest.mark.parametrize("count", [4, 12])
def test_a_field_of_many_increments_is_measured_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    measured = []
    own_dataset = part_reader.own_dataset
    with open_result(write_fake(tmp_path / "out.h5", count=count)) as result:
        monkeypatch.setattr(part_reader, "own_dataset", lambda *key: measured.append(key[1]) or own_dataset(*key))
        planes = [result.field("pressure", step) for step in result.steps]
    assert measured == ["fields/pressure"]
    assert len(planes) == count
    np.testing.assert_array_equal(planes[-1], list(fake_states(count))[-1].fields.pressure)


def test_parts_folder_can_be_named(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5", "stopped")
    assert open_result(parts_folder(out)).increments == COUNT
    assert open_result(str(out)).increments == COUNT


def test_what_is_not_stored_is_a_key_error(tmp_path: Path) -> None:
    with open_result(write_fake(tmp_path / "out.h5", "complete", every=2, stored=("zone",))) as result:
        with pytest.raises(KeyError, match="no field 'pressure' in the result, which has zone"):
            result.field("pressure")
        with pytest.raises(KeyError, match="no fields of increment 0"):
            result.field("zone", 0)
        with pytest.raises(KeyError, match="no column, field or axis 'foo' in a result, which has step, stage, "):
            result.units("foo")
        result.steps = tuple(range(1, 80, 2))
        with pytest.raises(
            KeyError, match=r"no fields of increment 999 in the result, which has those of 1, 3, \.\.\., 79'"
        ):
            result.field("zone", 999)


def test_h5py_sees_the_documented_attributes(tmp_path: Path) -> None:
    with h5py.File(write_fake(tmp_path / "out.h5", "failed")) as file:
        assert set(file) == {"header", "history", "fields", "restart"}
        assert file.attrs["status"] == "failed"
        assert file.attrs["failure"] == "sliding"
        assert file.attrs["format_version"] == FORMAT_VERSION
        assert json.loads(file.attrs["effective_case"])["title"] == "made up"
        assert json.loads(file.attrs["provenance"]) == {"threads": 1}
        assert {"fretsolve_version", "case_yaml", "coupling"} <= set(file.attrs)
        groups = file["header"], file["history"], file["fields"]
        datasets = [file["restart"], *(node for group in groups for node in group.values())]
        assert all(node.attrs["units"] and node.attrs["long_name"] for node in datasets)
        assert file["fields/pressure"].compression == "gzip"  # whose checksum is compared on reading
        assert file["fields/pressure"].chunks == (1, 6, 5)


def test_xarray_opens_each_group_with_coordinates_and_units(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5", "complete")
    with xarray.open_dataset(out, engine="h5netcdf", group="history") as history:
        assert history.P.dims == ("step",)
        assert history.P.attrs["units"] == "N"
        assert history.wall_time.dtype == np.float64
        assert history.step.values.tolist() == [0, 1, 2, 3]
    with xarray.open_dataset(out, engine="h5netcdf", group="fields") as fields:
        assert fields.pressure.dims == ("step", "x", "y")
        np.testing.assert_array_equal(fields.x.values, fake_header().x)
        assert fields.x.attrs == {"units": "mm", "long_name": "x of the cell centres"}
        assert fields.zone.attrs["flag_meanings"] == "open stick slip"
        nearest = fields.pressure.sel(step=3, x=0.06, method="nearest").values
        np.testing.assert_array_equal(nearest, list(fake_states(COUNT))[3].fields.pressure[3])


def test_large_case_files_are_kept(tmp_path: Path) -> None:
    title = "x" * 200_000
    assert open_result(write_fake(tmp_path / "out.h5", "complete", title=title)).case_yaml == f"title: {title}\n"


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1000])


def empty(path: Path) -> None:
    path.write_bytes(b"")


def text(path: Path) -> None:
    path.write_text("title: a case file\n" * 100)


def foreign(path: Path) -> None:
    path.unlink()
    with h5py.File(path, "w") as file:
        file["data"] = 1.0


def newer(path: Path) -> None:
    with h5py.File(path) as file:
        attributes, content = read_sealed(file)
    with h5py.File(path, "w") as file:
        write_sealed(file, attributes | {"format_version": FORMAT_VERSION + 1, "fretsolve_version": "3.1.0"}, content)


def incomplete(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        del file["history/Qx"]


def headless(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        del file["header"]


def unmarked(path: Path) -> None:
    """Leave the names of attributes, but no header."""
    path.unlink()
    with h5py.File(path, "w") as file:
        file.attrs["format_version"], file.attrs["fretsolve_version"] = FORMAT_VERSION, __version__


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (truncate, "the file is truncated: it was not copied or written to its end"),
        (empty, "the file is empty"),
        (text, "not an HDF5 file"),
        (foreign, "an HDF5 file, but not a result of fretsolve"),
        (newer, f"has format {FORMAT_VERSION + 1}, written by fretsolve 3.1.0; this is {__version__}"),
        (incomplete, "cannot read history: Qx is missing"),
        (headless, "an HDF5 file, but not a result of fretsolve: it has no header"),
        (unmarked, "an HDF5 file, but not a result of fretsolve: it has no header"),
        (Path.unlink, "no such file, nor parts of a run in out.h5.parts"),
    ],
)
def test_files_that_cannot_be_read(tmp_path: Path, damage: Callable[[Path], None], message: str) -> None:
    out = write_fake(tmp_path / "out.h5", "complete")
    damage(out)
    with pytest.raises(FileError) as caught:
        open_result(out)
    assert str(caught.value).startswith(f"{out}: {message}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("end", ["complete", "stopped"])
@pytest.mark.parametrize("name", ["Qx", "stick_center_x_error"])
def test_a_missing_column_is_damage(tmp_path: Path, name: str, end: str) -> None:
    out = write_fake(tmp_path / "out.h5", end, errors=True)
    for path in [out] if end == "complete" else parts_folder(out).glob("*.h5"):
        with h5py.File(path, "r+") as file:
            if end == "complete":
                del file["history"][name]
                continue
            rows = file["rows"][:]
            del file["rows"]
            file["rows"] = rows[[one for one in rows.dtype.names if one != name]].copy()
    message = (
        f"cannot read history: {name} is missing" if end == "complete" else "does not have the columns of this run"
    )
    with pytest.raises(FileError, match=message):
        open_result(out)


def test_run_without_an_increment_yet(tmp_path: Path) -> None:
    with HistoryWriter.open(tmp_path / "out.h5", fake_header()), open_result(tmp_path / "out.h5") as result:
        assert (result.status, result.increments, result.steps) == ("running", 0, ())
        assert set(result.fields) == {quantity.name for quantity in FIELDS}
    parts_folder(tmp_path / "new.h5").mkdir()
    with pytest.raises(FileError, match="the run has not begun to save increments"):
        open_result(tmp_path / "new.h5")


def test_open_result_follows_a_run_that_finishes(tmp_path: Path) -> None:
    states = list(fake_states(5))
    out = tmp_path / "out.h5"
    with HistoryWriter.open(out, fake_header(every=2)) as writer:
        for state in states[:2]:
            writer.append(state)
        before = open_result(out)
        only_restart = open_result(out)
        for state in states[2:]:
            writer.append(state)
        np.testing.assert_array_equal(before.field("gap", 1), states[1].fields.gap)
        third = open_result(out)
        writer.finish("complete")
    np.testing.assert_array_equal(third.field("gap", 3), states[3].fields.gap)
    np.testing.assert_array_equal(only_restart.field("gap", 1), states[1].fields.gap)
    for result in (before, only_restart, third):
        result.close()


def test_part_that_vanishes_while_the_parts_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = write_fake(tmp_path / "out.h5", "stopped")
    listed = reader.contiguous_parts
    answers = [[Part.named(parts_folder(out), 0, 99)]]
    monkeypatch.setattr(reader, "contiguous_parts", lambda folder: answers.pop() if answers else listed(folder))
    assert open_result(out).increments == COUNT


def test_both_components_at_once(tmp_path):
    with open_result(write_fake(tmp_path / "out.h5")) as result:
        shear = result.field("shear", 2)
        np.testing.assert_array_equal(shear, [result.field("shear_x", 2), result.field("shear_y", 2)])
        with pytest.raises(KeyError, match="no column 'nix' in the history, which has step, stage, "):
            result.history["nix"]
        with pytest.raises(KeyError, match="no field 'stress'"):
            result.field("stress")
