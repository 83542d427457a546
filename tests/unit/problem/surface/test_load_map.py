"""A map's way from its file into mm: what the file says, what the case says, and whether they agree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface, MapKeys
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.load_map import height_map_separation, load_height_map, load_value_map

KEY = ("surface", 0, "heights")
VALUES = 1e-3 * np.array([[0.0, 1.0, 2.0, 3.0], [10.0, 11.0, 12.0, 13.0], [20.0, 21.0, 22.0, 23.0]])


def saved(file: Path, values: Any = VALUES) -> Path:
    np.save(file, values)
    return file


def stated(file: Path, values: Any = 1e3 * VALUES, **attributes: Any) -> Path:
    """Write a map whose file says all of itself: heights in um, points 100 um and 200 um apart."""
    with h5py.File(file, "w") as stored:
        stored["z"] = values
        stored["z"].attrs.update({"unit": "um", "spacing": [100.0, 200.0], "spacing_unit": "um", **attributes})
    return file


def load(file: Path, **keys: Any) -> HeightMap:
    return load_height_map(HeightsSurface(file=str(file), **keys), KEY)


def refused(file: Path, **keys: Any) -> CaseError:
    with pytest.raises(CaseError) as caught:
        load(file, **keys)
    assert "\n" not in str(caught.value)
    return caught.value


class TestAgreement:
    def test_file_that_says_all_of_itself(self, tmp_path):
        read = load(stated(tmp_path / "map.h5"), dataset="z")
        np.testing.assert_allclose(read.values, VALUES, rtol=1e-14)
        assert read.spacing == pytest.approx((0.1, 0.2), rel=1e-14)

    def test_case_that_says_the_same_within_one_percent(self, tmp_path):
        keys = {"unit": "0.001 mm", "xy_unit": "um", "spacing": ["100.9 um", "0.2 mm"]}
        read = load(stated(tmp_path / "map.h5"), dataset="z", **keys)
        np.testing.assert_allclose(read.values, VALUES, rtol=1e-14)
        assert read.spacing == pytest.approx((0.1, 0.2), rel=1e-14)

    @pytest.mark.parametrize(
        ("keys", "place", "said"),
        [
            ({"unit": "mm"}, "unit", "the unit of its values is 1 um by the file, 1 mm by the case"),
            ({"xy_unit": "nm"}, "xy_unit", "the unit of x and y is 1 um by the file, 1 nm by the case"),
            (
                {"spacing": ["102 um", "200 um"]},
                "spacing",
                "its spacing along x is 0.1 mm by the file, 0.102 mm by the case",
            ),
            ({"spacing": "0.1 mm"}, "spacing", "its spacing along y is 0.2 mm by the file, 0.1 mm by the case"),
        ],
    )
    def test_contradiction(self, tmp_path, keys, place, said):
        error = refused(stated(tmp_path / "map.h5"), dataset="z", **keys)
        assert error.key == (*KEY, place)
        assert error.message == (f"{said}; remove the key, or add override: true if the file is wrong")

    def test_override_lets_the_case_win(self, tmp_path):
        keys = {"unit": "nm", "spacing": ["1 um", "2 um"], "override": True}
        read = load(stated(tmp_path / "map.h5"), dataset="z", **keys)
        np.testing.assert_allclose(read.values, 1e-3 * VALUES, rtol=1e-14)
        assert read.spacing == pytest.approx((1e-3, 2e-3), rel=1e-14)

    def test_override_of_the_unit_leaves_the_spacing_of_the_file(self, tmp_path):
        read = load(stated(tmp_path / "map.h5"), dataset="z", unit="nm", override=True)
        assert read.spacing == pytest.approx((0.1, 0.2), rel=1e-14)

    def test_case_fills_in_what_the_file_does_not_say(self, tmp_path):
        read = load(saved(tmp_path / "map.npy", 1e6 * VALUES), unit="nm", spacing="0.5 mm")
        np.testing.assert_allclose(read.values, VALUES, rtol=1e-14)
        assert read.spacing == (0.5, 0.5)

    @pytest.mark.parametrize(("keys", "spacing"), [({"unit": "um"}, 0.1), ({"unit": "um", "xy_unit": "nm"}, 1e-4)])
    def test_coordinates_without_a_unit_are_in_that_of_the_values(self, tmp_path, keys, spacing):
        with h5py.File(tmp_path / "map.h5", "w") as stored:
            stored["z"] = VALUES  # nm, as it were
            for axis, name in enumerate("xy"):
                stored[name] = 100.0 * np.arange(VALUES.shape[axis])
                stored[name].make_scale(name)
                stored["z"].dims[axis].attach_scale(stored[name])
        assert load(tmp_path / "map.h5", dataset="z", **keys).spacing == pytest.approx((spacing, spacing), rel=1e-14)

    @pytest.mark.parametrize("attributes", [{"spacing": [0.1, -0.1]}, {"spacing": [1.0, 1.0, 1.0]}])
    def test_spacing_in_the_file_that_is_none(self, tmp_path, attributes):
        file = stated(tmp_path / "map.h5", **attributes)
        error = refused(file, dataset="z", spacing="1 mm")
        assert error.key == (*KEY, "spacing")
        assert error.message.startswith(f"the spacing in 'map.h5' is {attributes['spacing']}; give that of the map's")
        assert load(file, dataset="z", spacing="1 mm", override=True).spacing == (1.0, 1.0)

    def test_unit_that_is_no_length_needs_one_of_the_case(self, tmp_path):
        file = stated(tmp_path / "map.h5", unit="counts")
        error = refused(file, dataset="z")
        assert error.key == (*KEY, "unit")
        assert error.message == "the file states its heights in 'counts', which is no length; give unit"
        np.testing.assert_allclose(load(file, dataset="z", unit="nm").values, 1e-3 * VALUES, rtol=1e-14)

    def test_unit_of_coordinates_that_is_no_length_needs_one_of_the_case(self, tmp_path):
        with h5py.File(tmp_path / "map.h5", "w") as file:
            file["z"] = VALUES
            for axis, name in enumerate("xy"):
                file[name] = 100.0 * np.arange(VALUES.shape[axis])
                file[name].attrs["units"] = "s"
                file[name].make_scale(name)
                file["z"].dims[axis].attach_scale(file[name])
        error = refused(tmp_path / "map.h5", dataset="z", unit="um")
        assert error.key == (*KEY, "xy_unit")
        assert error.message == "the file states its x and y in 's', which is no length; give xy_unit"
        assert load(tmp_path / "map.h5", dataset="z", xy_unit="um").spacing == pytest.approx((0.1, 0.1), rel=1e-14)
        keys = {"spacing": "0.3 mm", "override": True}
        assert load(tmp_path / "map.h5", dataset="z", **keys).spacing == (0.3, 0.3)

    def test_coefficients_have_no_unit(self, tmp_path):
        file = stated(tmp_path / "map.h5")
        with pytest.raises(CaseError) as caught:
            load_value_map(file, MapKeys(dataset="z"), ("friction",), line=False)
        assert caught.value.key == ("friction", "map")
        assert caught.value.message == (
            "the file states lengths (in units of 1 um), coefficients have no unit; give a file of coefficients, or add"
            " override: true if it is one"
        )
        read = load_value_map(file, MapKeys(dataset="z", override=True), ("friction",), line=False)
        np.testing.assert_array_equal(read.values, 1e3 * VALUES)
        for unit in ("1", ""):
            file = stated(tmp_path / "map.h5", unit=unit)
            assert load_value_map(file, MapKeys(dataset="z"), ("friction",), line=False).values.max() == 23.0

    def test_missing_spacing(self, tmp_path):
        error = refused(saved(tmp_path / "map.npy"))
        assert error.key == (*KEY, "spacing")
        assert error.message == (
            "spacing is missing, and 'map.npy' has none; give that of the map's points, such as [1 um, 1 um]"
        )


class TestPlausibility:
    def test_heights_in_mm_that_are_in_um(self, tmp_path):
        error = refused(saved(tmp_path / "map.npy", 1e3 * VALUES), spacing="1 mm")
        assert error.key == (*KEY, "unit")
        assert error.message == (
            "the heights in 'map.npy' range over 23 mm on a map of 3 mm; give their unit, or lost where lost"
            " points stand as numbers, or override: true if that is so"
        )
        assert load(tmp_path / "map.npy", spacing="1 mm", override=True).values.max() == 23.0

    def test_range_that_the_case_states(self, tmp_path):
        file = saved(tmp_path / "map.npy", 1e3 * VALUES)
        assert load(file, unit="um", spacing="1 mm", height_range="23.2 um").values.max() == pytest.approx(0.023)
        error = refused(file, unit="nm", spacing="1 mm", height_range="23 um")
        assert error.key == (*KEY, "height_range")
        assert error.message == (
            "the heights in 'map.npy' range over 23 nm, not over 23 um; check unit, and lost points that stand as"
            " numbers"
        )

    def test_points_further_apart_than_a_contact_is_wide(self, tmp_path):
        file = stated(tmp_path / "map.h5", spacing=312.5, spacing_unit="mm")
        error = refused(file, dataset="z")
        assert error.key == (*KEY, "spacing")
        assert error.message == (
            "the points in 'map.h5' are 312.5 mm apart by what it says, more than 1 mm; check its units, and give that"
            " of the map's points, such as [1 um, 1 um] with override: true"
        )
        assert load(file, dataset="z", spacing="0.1 mm", override=True).spacing == (0.1, 0.1)

    def test_height_beyond_all_bounds(self, tmp_path):
        error = refused(saved(tmp_path / "map.npy", np.where(VALUES > 0.02, -1e300, VALUES)), spacing="1 mm")
        assert error.message == (
            "'map.npy' holds a height of 1e+300 mm, at most 1e+40 mm is possible; write nan for missing points"
        )

    def test_what_is_not_finite_is_a_hole(self, tmp_path):
        file = saved(tmp_path / "map.npy", [[0.0, np.nan, 0.2], [-np.inf, 0.4, np.inf]])
        np.testing.assert_array_equal(load(file, spacing=1).values, [[0, np.nan, 0.2], [np.nan, 0.4, np.nan]])


class TestDirections:
    def test_inversion(self, tmp_path):
        read = load(saved(tmp_path / "map.npy"), spacing=1, invert=True)
        np.testing.assert_array_equal(read.values, -VALUES)

    @pytest.mark.parametrize(
        ("keys", "corner", "spacing"),
        [
            ({}, [[0, 1], [10, 11]], (0.1, 0.2)),
            ({"flip": "x"}, [[20, 21], [10, 11]], (0.1, 0.2)),
            ({"flip": "y"}, [[3, 2], [13, 12]], (0.1, 0.2)),
            ({"flip": ["x", "y"]}, [[23, 22], [13, 12]], (0.1, 0.2)),
            ({"transpose": True}, [[0, 10], [1, 11]], (0.2, 0.1)),
            ({"transpose": True, "flip": "x"}, [[3, 13], [2, 12]], (0.2, 0.1)),
        ],
    )
    def test_transpose_then_flip(self, tmp_path, keys, corner, spacing):
        read = load(stated(tmp_path / "map.h5"), dataset="z", **keys)
        np.testing.assert_allclose(1e3 * read.values[:2, :2], corner, rtol=1e-13)
        assert read.spacing == pytest.approx(spacing, rel=1e-14)

    def test_map_of_friction(self, tmp_path):
        file = stated(tmp_path / "mu.h5", values=0.5 + VALUES, unit="1")
        read = load_value_map(file, MapKeys(dataset="z", flip="x"), ("friction",), line=False)
        np.testing.assert_array_equal(read.values, (0.5 + VALUES)[::-1])
        assert read.spacing == pytest.approx((0.1, 0.2), rel=1e-14)


class TestFaults:
    @pytest.mark.parametrize(
        ("values", "text"),
        [
            (np.zeros((2, 3, 4)), "holds a 2 x 3 x 4 array; at least 2 x 2 heights"),
            (np.zeros((1, 9)), "holds a 1 x 9 array"),
            (np.zeros(5), "holds 5 values in a row; at least 2 x 2 heights"),
            (np.array(1.0), "holds a scalar array"),
            (np.full((3, 3), np.nan), "holds no finite height"),
            (np.ones((3, 3), dtype=complex), "values of type complex128; real numbers"),
            (np.full((3, 3), "a"), "values of type <U1; real numbers"),
        ],
    )
    def test_arrays_that_are_no_map(self, tmp_path, values, text):
        error = refused(saved(tmp_path / "map.npy", values), spacing=1)
        assert text in error.message
        assert error.key == (*KEY, "file")

    def test_grid_off_the_map(self, tmp_path):
        away, source = np.linspace(5.0, 6.0, 4), HeightsSurface(file=str(saved(tmp_path / "map.npy")), spacing=1)
        with pytest.raises(CaseError, match=r"no cell of the grid lies on the map .* of 2 x 3 mm") as caught:
            height_map_separation(source, away, away, KEY)
        assert caught.value.key == KEY

    @pytest.mark.parametrize("name", ["none.npy", "none.h5", "none.txt", "none.nc"])
    def test_missing_file(self, tmp_path, name):
        with pytest.raises(FileError, match=r"cannot be read: No such file or directory$"):
            load(tmp_path / name, spacing=1, dataset="a")

    def test_folder(self, tmp_path):
        (tmp_path / "map.npy").mkdir()
        with pytest.raises(FileError, match="is a folder"):
            load(tmp_path / "map.npy", spacing=1)


class TestLost:
    def test_a_number_that_stands_for_lost_points(self, tmp_path):
        values = np.array([[0.0, 1.0, -32768.0], [1.0, 2.0, 0.0], [1.0, 1.0, 1.0]])
        found = load(saved(tmp_path / "map.npy", values), spacing="1 mm", unit="um", lost=-32768)
        assert np.argwhere(np.isnan(found.values)).tolist() == [[0, 2]]
        assert found.doubts == ()

    def test_the_unit_that_nobody_states_is_doubted(self, tmp_path):
        found = load(saved(tmp_path / "map.npy", VALUES), spacing="1 mm")
        assert found.doubts == ("the values count as mm, since neither the file nor the case gives their unit",)
