"""Results of earlier versions: names and columns that have changed since."""

from __future__ import annotations

import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from fake_states import ALL_FIELDS, fake_header, fake_states, write_fake

from fretsolve import open_result
from fretsolve.case.history import EXTENTS
from fretsolve.result import HistoryWriter, RunHeader
from fretsolve.result.layout import ERRORS, FORMER_NAMES
from fretsolve.result.parts import parts_folder
from fretsolve.result.state import State

SAMPLES = sorted((Path(__file__).parents[2] / "data").glob("result_v*.h5"))


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
