"""Heights in HDF5 files, as h5py, netCDF4 and MATLAB write them, and in files of NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.surface.files import array_map
from fretsolve.problem.surface.files.array_map import read_hdf5, read_numpy
from fretsolve.problem.surface.files.raw_map import RawMap
from fretsolve.problem.surface.load_map import load_height_map

KEY = ("surface", 0, "heights", "dataset")
VALUES = np.array([[0.0, 1.0, 2.0, 3.0], [10.0, 11.0, 12.0, 13.0], [20.0, 21.0, 22.0, 23.0]])
ROWS = VALUES.T
"""The same map in the order of netCDF: y first, upwards."""


@pytest.fixture(autouse=True)
def _files_are_whole(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare most tests the process that tries the attributes of a file, 0.3 s each."""
    if request.cls is not TestFaults:
        monkeypatch.setattr(array_map, "try_attributes", lambda file: None)


def write_hdf5(file: Path, attributes: dict[str, Any], values: Any = VALUES) -> Path:
    with h5py.File(file, "w") as stored:
        stored["scan/height"] = values
        stored["scan/height"].attrs.update(attributes)
        stored["other"] = np.zeros(3)
    return file


def read(file: Path, dataset: str | None = "scan/height") -> RawMap:
    return read_hdf5(file, dataset, KEY)


def with_scales(file: Path, names: str, y: Any, x: Any, units: dict[str, str], values: Any = ROWS) -> Path:
    with h5py.File(file, "w") as stored:
        stored["z"] = values
        for index, (name, places) in enumerate(zip(names, (y, x), strict=True)):
            stored[name] = np.asarray(places)
            stored[name].make_scale(name)
            if name in units:
                stored[name].attrs["units"] = units[name]
            stored["z"].dims[index].attach_scale(stored[name])
    return file


class TestAttributes:
    @pytest.mark.parametrize(
        "text",
        [
            "um",
            b"um",
            np.bytes_(b"um"),
            np.array([b"um"]),
            np.array([b"um"], dtype="S8"),
            np.array(["um"], dtype=h5py.string_dtype()),
            np.array(["um"], dtype=h5py.string_dtype("ascii")),
            np.array([["um"]], dtype=h5py.string_dtype("utf-8", 8)),
            " µm ",
            "micrometers",
            "Âµm",
            b"\xb5m",
            np.array([b"\xb5m"], dtype=object),
            "Micrometer",
            "um (micrometers)",
            "[um]",
        ],
    )
    def test_unit_of_any_string_type(self, tmp_path, text):
        assert read(write_hdf5(tmp_path / "map.h5", {"Units": text})).unit == pytest.approx(1e-3, rel=1e-15)

    @pytest.mark.parametrize("name", ["unit", "units", "UNIT", "z_unit"])
    def test_names_of_the_unit(self, tmp_path, name):
        assert read(write_hdf5(tmp_path / "map.h5", {name: "nm"})).unit == pytest.approx(1e-6, rel=1e-15)

    @pytest.mark.parametrize("text", ["counts", "V", "1", "mm^2"])
    def test_unit_that_is_no_length_is_told_and_not_used(self, tmp_path, text):
        raw = read(write_hdf5(tmp_path / "map.h5", {"units": text}))
        assert (raw.unit, raw.stated) == (None, text)
        assert raw.remarks == (f"its unit {text!r} is no unit of length and is not used",)

    @pytest.mark.parametrize(
        ("other", "agrees"), [("micrometers", True), ("0.001 mm", True), ("nm", False), ("V", False)]
    )
    def test_two_units(self, tmp_path, other, agrees):
        file = write_hdf5(tmp_path / "map.h5", {"unit": "um", "units": other})
        if agrees:
            assert read(file).unit == pytest.approx(1e-3, rel=1e-12)
            return
        with pytest.raises(ValueError, match=rf"^its attribute unit is 'um', units is '{other}'; remove the one that"):
            read(file)

    @pytest.mark.parametrize("attributes", [{}, {"units": ""}, {"units": h5py.Empty("S4")}])
    def test_no_unit(self, tmp_path, attributes):
        raw = read(write_hdf5(tmp_path / "map.h5", attributes))
        assert (raw.unit, raw.remarks) == (None, ())

    @pytest.mark.parametrize(("units", "stated"), [(3, "3"), (["um", "um"], "um, um"), ("counts", "counts")])
    def test_what_is_no_unit_is_kept_to_be_refused(self, tmp_path, units, stated):
        raw = read(write_hdf5(tmp_path / "map.h5", {"units": units}))
        assert (raw.unit, raw.stated) == (None, stated)

    @pytest.mark.parametrize(
        ("attributes", "spacing", "unit"),
        [
            ({"spacing": [0.1, 0.2]}, (0.1, 0.2), 1.0),
            ({"Spacing": 0.1}, (0.1,), 1.0),
            ({"dx": 0.1, "dy": 0.3}, (0.1, 0.3), 1.0),
            ({"dx": np.array([[0.1]]), "dy": np.array([[0.3]])}, (0.1, 0.3), 1.0),
            ({"spacing": "5 um"}, (5.0,), 1e-3),
            ({"spacing": np.array([b"5 um", b"0.01 mm"])}, (0.005, 0.01), 1.0),
            ({"spacing": [5, 10], "spacing_unit": b"um"}, (5.0, 10.0), 1e-3),
            ({"dx": 5.0, "dy": 10.0, "xy_unit": "um"}, (5.0, 10.0), 1e-3),
            ({"dx": 5.0, "dy": 10.0, "dx_unit": "nm"}, (5.0, 10.0), 1e-6),
            ({"pixel_size": "5 um"}, (5.0,), 1e-3),
            ({"pixel_size": [5.0, 6.0], "pixel_size_unit": "um"}, (5.0, 6.0), 1e-3),
        ],
    )
    def test_spacing(self, tmp_path, attributes, spacing, unit):
        raw = read(write_hdf5(tmp_path / "map.h5", attributes))
        assert raw.spacing == pytest.approx(spacing, rel=1e-14)
        assert raw.xy_unit == pytest.approx(unit, rel=1e-14)

    @pytest.mark.parametrize(
        ("attributes", "remark"),
        [
            ({"pixel_size": 5.0}, "its pixel_size has no unit and is not used"),
            (
                {"spacing": 5.0, "spacing_unit": "pixel"},
                "its spacing is not used: its unit 'pixel' is no unit of length and is not used",
            ),
        ],
    )
    def test_spacing_without_a_unit_of_length_is_told_and_not_used(self, tmp_path, attributes, remark):
        raw = read(write_hdf5(tmp_path / "map.h5", attributes))
        assert (raw.spacing, raw.remarks) == (None, (remark,))

    @pytest.mark.parametrize(
        ("spacing", "text"), [("5 N", "its spacing is '5 N', which is no length"), ("five", "'five' is not a number")]
    )
    def test_spacing_that_is_no_length(self, tmp_path, spacing, text):
        with pytest.raises(ValueError, match=text):
            read(write_hdf5(tmp_path / "map.h5", {"spacing": spacing}))

    def test_lost_points_scale_and_offset(self, tmp_path):
        stored = np.array([[-999, 0, 1], [2, -32768, 4]], dtype=np.int16)
        attributes = {
            "_FillValue": np.array([-999], np.int16),
            "missing_value": np.int16(-32768),
            "scale_factor": 0.5,
            "add_offset": np.array([10.0]),
        }
        values = read(write_hdf5(tmp_path / "map.h5", attributes, stored)).values
        np.testing.assert_array_equal(values, [[np.nan, 10.0, 10.5], [11.0, np.nan, 12.0]])

    def test_lost_points_in_single_precision(self, tmp_path):
        stored = np.array([[1e20, 0.5], [0.25, 1.0]], dtype=np.float32)
        values = read(write_hdf5(tmp_path / "map.h5", {"_FillValue": np.float32(1e20)}, stored)).values
        np.testing.assert_array_equal(values, [[np.nan, 0.5], [0.25, 1.0]])


class TestScales:
    def test_spacing_and_its_unit(self, tmp_path):
        file = with_scales(tmp_path / "map.h5", "xy", [0, 5, 10], [0, 2, 4, 6], {"x": "um", "y": "um"}, VALUES)
        raw = read(file, "z")
        assert (raw.spacing, raw.xy_unit, raw.remarks) == ((5.0, 2.0), pytest.approx(1e-3), ())
        np.testing.assert_array_equal(raw.values, VALUES)

    def test_order_of_netcdf_is_turned(self, tmp_path):
        raw = read(with_scales(tmp_path / "map.h5", "yx", [0, 2, 4, 6], [0, 5, 10], {}), "z")
        np.testing.assert_array_equal(raw.values, VALUES)
        assert (raw.spacing, raw.xy_unit) == ((5.0, 2.0), None)
        assert raw.remarks == ("its dimensions are y, x: transposed to x, y",)

    def test_descending_y_is_mirrored(self, tmp_path):
        raw = read(with_scales(tmp_path / "map.h5", "yx", [6, 4, 2, 0], [0, 5, 10], {}, ROWS[::-1]), "z")
        np.testing.assert_array_equal(raw.values, VALUES)
        assert raw.spacing == (5.0, 2.0)
        assert raw.remarks[1] == "its y descends: mirrored in y"

    def test_units_that_differ(self, tmp_path):
        raw = read(with_scales(tmp_path / "map.h5", "yx", [0, 2, 4, 6], [0, 5, 10], {"x": "um", "y": "nm"}), "z")
        assert raw.spacing == pytest.approx((5e-3, 2e-6), rel=1e-14)
        assert raw.xy_unit == 1.0

    def test_unit_of_one_direction_alone(self, tmp_path):
        file = with_scales(tmp_path / "map.h5", "yx", [0, 2, 4, 6], [0, 5, 10], {"x": "um"})
        with pytest.raises(ValueError, match="the unit of one of its directions and not of the other"):
            read(file, "z")

    @pytest.mark.parametrize("y", [[0, 1, 2, 4], [0, 1, np.nan, 3], [1, 1, 1, 1]])
    def test_uneven_coordinates(self, tmp_path, y):
        file = with_scales(tmp_path / "map.h5", "yx", y, [0, 5, 10], {})
        with pytest.raises(ValueError, match=r"its coordinates 'y' are not evenly spaced, with steps from .* to "):
            read(file, "z")

    def test_other_number_of_coordinates(self, tmp_path):
        with pytest.raises(ValueError, match="its scale 'y' does not hold 4 coordinates"):
            read(with_scales(tmp_path / "map.h5", "yx", [0, 2, 4], [0, 5, 10], {}), "z")

    def test_labels_name_the_dimensions_as_scales_do(self, tmp_path):
        with h5py.File(tmp_path / "map.h5", "w") as stored:
            stored["z"] = ROWS
            stored["z"].dims[0].label, stored["z"].dims[1].label = "Y", "X"
        raw = read(tmp_path / "map.h5", "z")
        np.testing.assert_array_equal(raw.values, VALUES)
        assert (raw.spacing, raw.remarks) == (None, ("its dimensions are y, x: transposed to x, y",))

    def test_unit_of_coordinates_that_is_no_length(self, tmp_path):
        file = with_scales(tmp_path / "map.h5", "xy", [0, 5, 10], [0, 2, 4, 6], {"x": "s"}, VALUES)
        raw = read(file, "z")
        assert (raw.spacing, raw.xy_unit, raw.xy_stated) == ((5.0, 2.0), None, "s")
        assert raw.remarks == ("x: its unit 's' is no unit of length and is not used",)

    def test_coordinates_in_single_precision(self, tmp_path):
        y = (50.0 + 1e-3 * np.arange(4)).astype(np.float32)  # neighbours are 4e-6 apart
        raw = read(with_scales(tmp_path / "map.h5", "yx", y, [0, 5, 10], {}), "z")
        assert raw.spacing == (5.0, pytest.approx(1e-3, rel=1e-2))

    def test_only_dataset_beside_its_scales_needs_no_name(self, tmp_path):
        raw = read(with_scales(tmp_path / "map.h5", "yx", [0, 2, 4, 6], [0, 5, 10], {}), None)
        np.testing.assert_array_equal(raw.values, VALUES)

    def test_attribute_that_contradicts_the_coordinates(self, tmp_path):
        file = with_scales(tmp_path / "map.h5", "xy", [0, 5, 10], [0, 2, 4, 6], {"x": "um", "y": "um"}, VALUES)
        for spacing in ([0.005, 0.00201], [0.005, 0.0021]):
            with h5py.File(file, "a") as stored:
                stored["z"].attrs["spacing"] = spacing
            if spacing[1] < 0.0021:  # within 1 %
                assert (read(file, "z").spacing, read(file, "z").xy_unit) == ((0.005, 0.00201), 1.0)
        message = "the spacing along y is 2.1 um, its coordinates that it is 2 um; remove what is wrong$"
        with pytest.raises(ValueError, match=rf"^its attributes say that {message}"):
            read(file, "z")

    def test_attribute_counts_before_coordinates_without_a_unit(self, tmp_path):
        file = with_scales(tmp_path / "map.h5", "xy", [0, 5, 10], [0, 2, 4, 6], {}, VALUES)
        with h5py.File(file, "a") as stored:
            stored["z"].attrs["spacing"] = [0.25, 0.5]
        raw = read(file, "z")
        assert (raw.spacing, raw.xy_unit) == ((0.25, 0.5), 1.0)
        assert raw.remarks == ("its attributes give the spacing, not its coordinates, which have no unit",)

    @pytest.mark.parametrize("coordinates", [True, False])
    def test_file_of_netcdf4(self, tmp_path, coordinates):
        netcdf4 = pytest.importorskip("netCDF4")
        with netcdf4.Dataset(tmp_path / "map.nc", "w") as stored:
            for name, places in (("y", [0.0, 0.2, 0.4, 0.6]), ("x", [0.0, 0.5, 1.0])):
                stored.createDimension(name, len(places))
                if coordinates:
                    stored.createVariable(name, "f8", (name,))[:] = places
                    stored[name].units = "mm"
            height = stored.createVariable("height", "i2", ("y", "x"), fill_value=-1)
            height.units, height.scale_factor = "um", 0.1
            height[:] = np.ma.masked_where(ROWS == 23.0, 0.1 * ROWS)
        source = HeightsSurface(file=str(tmp_path / "map.nc"), spacing=None if coordinates else (0.5, 0.2))
        loaded = load_height_map(source, KEY[:-1])
        expected = np.where(VALUES == 23.0, np.nan, 1e-4 * VALUES)
        np.testing.assert_allclose(loaded.values, expected, rtol=1e-12)
        assert loaded.spacing == pytest.approx((0.5, 0.2), rel=1e-12)
        assert loaded.remarks == ("its dimensions are y, x: transposed to x, y",)

    def test_file_of_matlab(self, tmp_path):
        file = tmp_path / "map.h5"
        with h5py.File(file, "w", userblock_size=512) as stored:
            stored["height"] = VALUES
            text = np.frombuffer(b"double", dtype="S6")
            stored["height"].attrs.update({"MATLAB_class": text, "unit": np.array([b"nm"]), "dx": [[0.5]], "dy": [[1]]})
        raw = read(file, "height")
        assert (raw.unit, raw.spacing, raw.xy_unit) == (pytest.approx(1e-6), (0.5, 1.0), 1.0)


class TestNumpy:
    def test_npy(self, tmp_path):
        np.save(tmp_path / "map.npy", VALUES.astype(np.int16))
        raw = read_numpy(tmp_path / "map.npy", None, KEY)
        np.testing.assert_array_equal(raw.values, VALUES)
        assert (raw.spacing, raw.unit) == (None, None)

    def test_npz_by_name_or_with_a_single_array(self, tmp_path):
        np.savez(tmp_path / "one.npz", height=VALUES)
        np.savez(tmp_path / "two.npz", height=VALUES, mask=VALUES > 3)
        for name, dataset in (("one.npz", None), ("two.npz", "height")):
            np.testing.assert_array_equal(read_numpy(tmp_path / name, dataset, KEY).values, VALUES)

    def test_npy_has_no_datasets(self, tmp_path):
        np.save(tmp_path / "map.npy", VALUES)
        with pytest.raises(CaseError, match=r"'map.npy' holds one array and no datasets; leave 'z' out"):
            read_numpy(tmp_path / "map.npy", "z", KEY)


class TestFaults:
    def test_missing_dataset_lists_those_there_are(self, tmp_path):
        with pytest.raises(CaseError) as caught:
            read(write_hdf5(tmp_path / "map.h5", {}), "heights")
        assert caught.value.key == KEY
        assert caught.value.message == "there is no dataset 'heights' in 'map.h5'; 'map.h5' has other, scan/height"

    def test_several_arrays_need_a_choice(self, tmp_path):
        np.savez(tmp_path / "two.npz", height=VALUES, mask=VALUES > 3)
        with pytest.raises(CaseError) as caught:
            read_numpy(tmp_path / "two.npz", None, KEY)
        assert caught.value.message == "dataset is missing; 'two.npz' has height, mask"

    def test_coordinates_in_another_file_are_not_followed(self, tmp_path):
        file = with_scales(tmp_path / "map.h5", "yx", [0, 2, 4, 6], [0, 5, 10], {})
        with h5py.File(file, "a") as stored:
            outside = stored.create_dataset("far", (4,), "f8", external=[(str(tmp_path / "far.bin"), 0, 32)])
            outside.make_scale("far")
            stored["z"].dims[0].detach_scale(stored["y"])
            stored["z"].dims[0].attach_scale(outside)
        with pytest.raises(ValueError, match="the values of far lie in other files, which are not read"):
            read(file, "z")

    @pytest.mark.parametrize(
        ("name", "content", "text"),
        [
            ("map.h5", b"no HDF5", "cannot be read"),
            ("map.npy", b"no array", "it is not a NumPy file of numbers, or it is cut short or damaged$"),
            ("map.npy", b"", "cannot be read"),
            ("map.npz", b"PK\x03\x04 cut", "cannot be read"),
            ("map.nc", b"\x89HDF\r\n\x1a\n cut", "cannot be read"),
        ],
    )
    def test_unreadable_file(self, tmp_path, name, content, text):
        file = tmp_path / name
        file.write_bytes(content)
        surface = HeightsSurface(file=str(file), spacing=(1.0, 1.0), dataset="a" if name[-2:] in ("h5", "nc") else None)
        with pytest.raises(FileError, match=text) as caught:
            load_height_map(surface, KEY[:-1])
        assert caught.value.file == file
        assert "\n" not in str(caught.value)
