"""Results as fretsolve, h5py and xarray read them, and the messages on files that cannot be read."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from fake_states import ALL_FIELDS, fake_header, fake_states, write_fake

from fretsolve import __version__, open_result
from fretsolve.case.history import EXTENTS
from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, RunHeader, reader
from fretsolve.result.layout import ERRORS, FIELDS, FORMAT_VERSION, FORMER_NAMES, HISTORY, QUANTITIES
from fretsolve.result.parts import component, parts_folder
from fretsolve.result.piece import Part
from fretsolve.result.state import State

COUNT = 4
SAMPLES = sorted((Path(__file__).parents[2] / "data").glob("result_v*.h5"))


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
        datasets = [node for group in file.values() for node in group.values()]
        assert all(node.attrs["units"] and node.attrs["long_name"] for node in datasets)
        assert file["fields/pressure"].compression == "gzip"  # whose checksum is compared on reading
        assert file["fields/pressure"].chunks == (1, 6, 5)
        assert file["history/P"].fletcher32


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


def test_field_of_several_chunks(tmp_path: Path) -> None:
    shape = (1100, 300)
    state = next(fake_states(1, shape=shape))
    with open_result(write_fake(tmp_path / "out.h5", "complete", count=1, shape=shape)) as result:
        for name in ("gap", "shear_y"):
            np.testing.assert_array_equal(result.field(name), component(state, QUANTITIES[name]))


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
    with h5py.File(path, "r+") as file:
        del file["header"]
        file.attrs["format_version"] = FORMAT_VERSION + 1
        file.attrs["fretsolve_version"] = "3.1.0"


def incomplete(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        del file["history/Qx"]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (truncate, "the file is truncated: it was not copied or written to its end"),
        (empty, "the file is empty"),
        (text, "not an HDF5 file"),
        (foreign, "an HDF5 file, but not a result of fretsolve"),
        (newer, f"has format {FORMAT_VERSION + 1}, written by fretsolve 3.1.0; this is {__version__}"),
        (incomplete, "cannot read history: "),
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


def test_flipped_bit_in_a_field_is_found(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5", "complete")
    with h5py.File(out) as file:
        offset = file["fields/pressure"].id.get_chunk_info(2).byte_offset
    data = bytearray(out.read_bytes())
    data[offset + 5] ^= 1
    out.write_bytes(data)
    with open_result(out) as result:
        result.field("pressure", 1)
        with pytest.raises(FileError, match="fields/pressure of increment 2 is damaged: the checksum"):
            result.field("pressure", 2)


def test_header_that_is_no_header(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5", "stopped")
    for content in ("{", "[]", '{"format_version": 1, "version": "0"}'):
        (parts_folder(out) / "header.json").write_text(content)
        with pytest.raises(FileError, match=r"header\.json: not the header of a run"):
            open_result(out)


def test_run_without_an_increment_yet(tmp_path: Path) -> None:
    with HistoryWriter.open(tmp_path / "out.h5", fake_header()), open_result(tmp_path / "out.h5") as result:
        assert (result.status, result.increments, result.steps) == ("running", 0, ())
        assert set(result.fields) == {quantity.name for quantity in FIELDS}
    parts_folder(tmp_path / "new.h5").mkdir()
    with pytest.raises(FileError, match="the run has not begun to save increments"):
        open_result(tmp_path / "new.h5")


def test_open_result_follows_a_run_that_merges_and_finishes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretsolve.result.writer.MERGE_EVERY", 3)
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


def test_field_that_a_growing_run_has_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretsolve.result.writer.MERGE_EVERY", 2)
    states = list(fake_states(2))
    with HistoryWriter.open(tmp_path / "out.h5", fake_header(every=5)) as writer:
        writer.append(states[0])
        result = open_result(tmp_path / "out.h5")
        assert result.steps == (0,)
        writer.append(states[1])
        with pytest.raises(FileError, match="the fields of increment 0 are not kept any more"):
            result.field("gap", 0)


def test_part_that_vanishes_while_the_parts_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = write_fake(tmp_path / "out.h5", "stopped")
    listed = reader.contiguous_parts
    answers = [[Part(parts_folder(out) / "000000-000099.h5", 0, 99)]]
    monkeypatch.setattr(reader, "contiguous_parts", lambda folder: answers.pop() if answers else listed(folder))
    assert open_result(out).increments == COUNT


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda path: path.stem)
def test_samples_of_released_formats_are_read(sample: Path) -> None:
    with open_result(sample) as result:
        assert (result.status, result.increments, result.steps) == ("complete", 4, (2, 3))
        assert result.attributes["format_version"] == int(sample.stem.removeprefix("result_v"))
        assert result.effective_case["output"] == {"fields": list(ALL_FIELDS), "every": 3}
        np.testing.assert_allclose(
            result.history["P"], [14.858431661659505, 12.83798235718027, 13.497911020882471, 11.93021690182056]
        )
        assert (result.x.size, result.y.size) == (6, 5)
        assert result.field("pressure", 2).sum() == pytest.approx(result.history["P"][2], rel=1e-14)
        assert np.isinf(result.field("gap", 3)[0, 0])
        assert set(np.unique(result.field("zone"))) == {0, 1, 2}
        assert result.units("work_total") == "mJ"
    assert SAMPLES


def test_both_components_at_once(tmp_path):
    with open_result(write_fake(tmp_path / "out.h5")) as result:
        shear = result.field("shear", 2)
        np.testing.assert_array_equal(shear, [result.field("shear_x", 2), result.field("shear_y", 2)])
        with pytest.raises(KeyError, match="no column 'nix' in the history, which has step, stage, "):
            result.history["nix"]
        with pytest.raises(KeyError, match="no field 'stress'"):
            result.field("stress")


def _require_error_bars(out: Path, header: RunHeader, states: list[State]) -> None:
    """Require the error bars of `states` in the history, and those of the last one in a resumed run."""
    with open_result(out) as result:
        for quantity in ERRORS:
            assert result.history[quantity.name].tolist() == [getattr(state.errors, quantity.name) for state in states]
    with HistoryWriter.open(out, header, resume=True) as writer:
        assert writer.last_state is not None and writer.last_state.errors == states[-1].errors


def test_names_of_earlier_versions_are_read(tmp_path: Path) -> None:
    """Error bars were columns `companion_*` and the key `error_estimate`."""
    header, states = fake_header(errors=True, error_bars=True), list(fake_states(2, errors=True))
    out = write_fake(tmp_path / "out.h5", "failed", 2, errors=True, error_bars=True)
    with h5py.File(out, "r+") as file:
        del file["header"]
        for name, former in FORMER_NAMES.items():
            file["history"].move(name, former)
        file.attrs["effective_case"] = file.attrs["effective_case"].replace("error_bars", "error_estimate")
    with open_result(out) as result:
        assert result.effective_case["solver"]["error_bars"] is True
    _require_error_bars(out, header, states)


def test_parts_of_earlier_versions_kept_the_error_bars_in_a_table_of_their_own(tmp_path: Path) -> None:
    header, states = fake_header(errors=True), list(fake_states(2, errors=True))
    out = write_fake(tmp_path / "out.h5", "stopped", 2, errors=True)
    for part in parts_folder(out).glob("*.h5"):
        with h5py.File(part, "r+") as file:
            rows = file["rows"][:]
            del file["rows"]
            errors = [quantity.name for quantity in ERRORS]
            file["rows"] = rows[[name for name in rows.dtype.names if name not in errors]].copy()
            former = rows[errors].copy()
            former.dtype.names = tuple(FORMER_NAMES.get(name, name) for name in errors)
            file["error_rows"] = former
    with open_result(out) as result:
        assert result.history["P"].tolist() == [state.summary.P for state in states]
    _require_error_bars(out, header, states)


def test_results_of_earlier_versions_lack_bars_of_half_widths(tmp_path: Path) -> None:
    header, states = fake_header(errors=True), list(fake_states(3, errors=True))
    out = write_fake(tmp_path / "out.h5", "failed", 2, errors=True)
    with h5py.File(out, "r+") as file:
        del file["header"]
        for name in EXTENTS:
            del file["history"][f"{name}_error"]
    with HistoryWriter.open(out, header, resume=True) as writer:
        writer.append(states[2])
        writer.finish("complete")
    with open_result(out) as result:
        column = result.history["stick_center_x_error"]
        assert np.isnan(column[:2]).all()
        assert column[2] == states[2].errors.stick_center_x_error


@pytest.mark.parametrize("end", ["complete", "failed", "stopped"])
def test_results_of_earlier_versions_lack_corrected_values(tmp_path: Path, end: str) -> None:
    """They open without these columns, and a run that goes on has them from there on."""
    header, states = fake_header(errors=True), list(fake_states(3, errors=True))
    out = write_fake(tmp_path / "out.h5", end, 2, errors=True)
    missing = [quantity.name for quantity in ERRORS if "_corrected" in quantity.name]
    for path in parts_folder(out).glob("*.h5") if end == "stopped" else [out]:
        with h5py.File(path, "r+") as file:
            if end == "stopped":
                rows = file["rows"][:]
                del file["rows"]
                file["rows"] = rows[[name for name in rows.dtype.names if name not in missing]].copy()
                continue
            del file["header"]
            for name in missing:
                del file["history"][name]
    with open_result(out) as result:
        assert all(np.isnan(result.history[name]).all() for name in missing if name in result.history)
        assert end == "stopped" or not set(missing) & set(result.history)
        assert result.history["delta_x_error"].tolist() == [state.errors.delta_x_error for state in states[:2]]
    if end == "complete":
        return
    with HistoryWriter.open(out, header, resume=True) as writer:
        assert writer.last_state is not None and writer.last_state.errors is not None
        assert writer.last_state.errors.delta_x_error == states[1].errors.delta_x_error
        assert math.isnan(writer.last_state.errors.delta_x_corrected)
        writer.append(states[2])
        writer.finish("complete")
    with open_result(out) as result:
        column = result.history["delta_x_corrected"]
        assert np.isnan(column[:2]).all()
        assert column[2] == states[2].errors.delta_x_corrected
