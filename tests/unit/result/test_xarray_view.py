"""A result as datasets of xarray: what is in them, and when it is read."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from fake_states import write_fake

from fretsolve import open_result
from fretsolve.result import Result


@pytest.fixture(params=["complete", "failed", "stopped"])
def out(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    return write_fake(tmp_path / "out.h5", request.param, 5, every=2)


def test_fields_with_axes_units_and_meaning(out: Path) -> None:
    with open_result(out) as result:
        fields = result.to_xarray()
        assert fields.pressure.dims == ("step", "x", "y")
        assert fields.step.values.tolist() == [1, 3, 4]
        np.testing.assert_array_equal(fields.x, result.x)
        assert fields.x.attrs["units"] == "mm"
        assert fields.shear_x.attrs == {"units": "MPa", "long_name": "shear traction on body 2 along x"}
        assert fields.zone.attrs["flag_meanings"] == "open stick slip"
        assert fields.zone.dtype == np.uint8
        assert fields.attrs["status"] == result.status
        assert set(fields.data_vars) == set(result.fields)
        for name in result.fields:
            stored = [result.field(name, step) for step in result.steps]
            np.testing.assert_array_equal(fields[name].values, stored, strict=True)


def test_parts_of_fields(out: Path) -> None:
    with open_result(out) as result:
        pressure, whole = result.to_xarray("fields").pressure, result.field("pressure", 3)
        np.testing.assert_array_equal(pressure.sel(step=3).values, whole)
        np.testing.assert_array_equal(pressure.sel(step=3, x=0.06, method="nearest").values, whole[3])
        part = pressure.sel(step=3).isel(x=slice(1, 6, 2), y=[0, 3])
        np.testing.assert_array_equal(part.values, whole[1:6:2][:, [0, 3]])
        at_a_point = [result.field("pressure", step)[1, 2] for step in (4, 1)]
        np.testing.assert_array_equal(pressure.isel(step=[2, 0], x=1, y=2).values, at_a_point)
        assert pressure.isel(step=[]).values.shape == (0, 6, 5)
        assert pressure.isel(step=slice(0, 0), x=2).values.shape == (0, 5)
        assert float(pressure.max()) == max(result.field("pressure", step).max() for step in result.steps)


def test_history(out: Path) -> None:
    with open_result(out) as result:
        history = result.to_xarray("history")
        assert history.P.dims == ("step",)
        assert history.P.attrs == {"units": "N", "long_name": "normal force"}
        assert history.step.values.tolist() == [0, 1, 2, 3, 4]
        for name, column in result.history.items():
            np.testing.assert_array_equal(history[name].values, column, strict=True)
        with pytest.raises(ValueError, match="history and fields, not 'restart'"):
            result.to_xarray("restart")


def test_fields_are_read_when_they_are_asked_for(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[int] = []
    whole = Result.field

    def watched(self: Result, name: str, step: int = -1) -> np.ndarray:
        read.append(step)
        return whole(self, name, step)

    monkeypatch.setattr(Result, "field", watched)
    with open_result(out) as result:
        fields = result.to_xarray()
        later = fields.gap.isel(step=1)
        assert read == []
    np.testing.assert_array_equal(later.values, whole(result, "gap", 3))  # the file opens again
    assert read == [3]
    result.close()


def test_dataset_can_be_saved_as_netcdf(out: Path, tmp_path: Path) -> None:
    with open_result(out) as result:
        result.to_xarray().to_netcdf(tmp_path / "copy.nc", engine="h5netcdf")
        with xarray.open_dataset(tmp_path / "copy.nc", engine="h5netcdf") as copy:
            np.testing.assert_array_equal(copy.pressure.values, result.to_xarray().pressure.values)


def test_without_xarray_it_is_said_how_to_get_it(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    monkeypatch.delitem(sys.modules, "fretsolve.result.xarray_view", raising=False)
    with open_result(out) as result:
        with pytest.raises(ImportError, match=r"datasets need xarray .* pip install '\.\[xarray\]' in a clone"):
            result.to_xarray()
        assert result.field("pressure").shape == (6, 5)
