from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.model.grid import cell_centers
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.load_map import height_map_separation, load_height_map

KEY = ("surface", 0, "heights")
VALUES = np.array([[0.0, 1.0, 2.0, 3.0], [10.0, 11.0, 12.0, 13.0], [20.0, 21.0, 22.0, 23.0]])


def source(file: Path, **rest) -> HeightsSurface:
    return HeightsSurface(file=str(file), **{"spacing": (1.0, 1.0), **rest})


def without_spacing(file: Path, **rest) -> HeightsSurface:
    return HeightsSurface(file=str(file), **rest)


def write_hdf5(file: Path, attributes: dict, values=VALUES) -> Path:
    with h5py.File(file, "w") as stored:
        stored["scan/height"] = values
        stored["scan/height"].attrs.update(attributes)
        stored["other"] = np.zeros(3)
    return file


class TestSampling:
    def test_is_bilinear_in_between(self):
        sampled = HeightMap(VALUES, (1.0, 2.0)).sample(np.array([-0.5, 0.25]), np.array([-2.0, 0.0, 3.0]))
        np.testing.assert_allclose(sampled, [[5.5, 6.5, 8.0], [13.0, 14.0, 15.5]], rtol=1e-14)

    def test_no_material_off_the_map(self):
        x, y = np.array([-5.0, -1.0 - 1e-9, 1.0 + 1e-9, 1.01]), np.array([-1.6, 0.0, 1.5])
        sampled = HeightMap(VALUES, (1.0, 1.0)).sample(x, y)
        np.testing.assert_array_equal(np.isinf(sampled), [[1, 1, 1], [1, 0, 0], [1, 0, 0], [1, 1, 1]])
        np.testing.assert_allclose(sampled[1:3, 1:], [[1.5, 3.0], [21.5, 23.0]], atol=1e-5)

    def test_hole_takes_the_cells_that_it_touches_and_no_others(self):
        values = np.zeros((5, 5))
        values[2, 2] = np.nan
        height_map = HeightMap(values, (1.0, 1.0))
        own = cell_centers(5, 1.0, 0.0)
        assert np.argwhere(np.isinf(height_map.sample(own, own))).tolist() == [[2, 2]]
        finer = np.linspace(-2.0, 2.0, 17)
        touched = np.abs(finer) < 1.0
        np.testing.assert_array_equal(np.isinf(height_map.sample(finer, finer)), touched[:, None] & touched)


class TestFiles:
    @pytest.mark.parametrize(
        ("attributes", "spacing"),
        [({"spacing": [0.1, 0.2]}, (0.1, 0.2)), ({"spacing": 0.1}, (0.1, 0.1)), ({"dx": 0.1, "dy": 0.3}, (0.1, 0.3))],
    )
    def test_hdf5_with_its_spacing(self, tmp_path, attributes, spacing):
        file = write_hdf5(tmp_path / "map.h5", attributes)
        read = load_height_map(without_spacing(file, dataset="/scan/height"), KEY)
        assert read.spacing == spacing
        np.testing.assert_array_equal(read.values, VALUES)

    def test_spacing_of_the_case_comes_first(self, tmp_path):
        file = write_hdf5(tmp_path / "map.h5", {"spacing": 0.1})
        read = load_height_map(source(file, dataset="scan/height", spacing="2 um"), KEY)
        assert read.spacing == (0.002, 0.002)

    def test_npy(self, tmp_path):
        np.save(tmp_path / "map.npy", VALUES.astype(np.int16))
        np.testing.assert_array_equal(load_height_map(source(tmp_path / "map.npy"), KEY).values, VALUES)

    def test_npz_by_name_or_with_a_single_array(self, tmp_path):
        np.savez(tmp_path / "one.npz", height=VALUES)
        np.savez(tmp_path / "two.npz", height=VALUES, mask=VALUES > 3)
        for read in (source(tmp_path / "one.npz"), source(tmp_path / "two.npz", dataset="height")):
            np.testing.assert_array_equal(load_height_map(read, KEY).values, VALUES)

    def test_unit_and_inversion(self, tmp_path):
        np.save(tmp_path / "map.npy", VALUES)
        read = load_height_map(source(tmp_path / "map.npy", unit="um", invert=True), KEY)
        np.testing.assert_allclose(read.values, -1e-3 * VALUES, rtol=1e-15)


class TestFaults:
    def refused(self, surface: HeightsSurface) -> CaseError:
        with pytest.raises(CaseError) as caught:
            load_height_map(surface, KEY)
        assert "\n" not in str(caught.value)
        return caught.value

    def test_missing_dataset_lists_those_there_are(self, tmp_path):
        file = write_hdf5(tmp_path / "map.h5", {})
        error = self.refused(source(file, dataset="heights"))
        assert error.key == (*KEY, "dataset")
        assert error.message == "there is no dataset 'heights' in 'map.h5'; 'map.h5' has other, scan/height"

    def test_several_arrays_need_a_choice(self, tmp_path):
        np.savez(tmp_path / "two.npz", height=VALUES, mask=VALUES > 3)
        error = self.refused(source(tmp_path / "two.npz"))
        assert error.message == "dataset is missing; 'two.npz' has height, mask"

    @pytest.mark.parametrize("attributes", [{}, {"spacing": [0.1, -0.1]}, {"spacing": [1.0, 1.0, 1.0]}])
    def test_spacing_that_is_missing_or_wrong(self, tmp_path, attributes):
        file = write_hdf5(tmp_path / "map.h5", attributes)
        error = self.refused(without_spacing(file, dataset="scan/height"))
        assert error.key == (*KEY, "spacing")
        assert "such as [1 um, 1 um]" in error.message

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
        np.save(tmp_path / "map.npy", values)
        error = self.refused(source(tmp_path / "map.npy"))
        assert text in error.message
        assert error.key == (*KEY, "file")

    def test_unknown_kind_of_file(self, tmp_path):
        file = tmp_path / "map.png"
        file.write_bytes(b"x")
        error = self.refused(source(file))
        assert error.key == (*KEY, "file")
        assert ".npy" in error.message

    def test_grid_off_the_map(self, tmp_path):
        np.save(tmp_path / "map.npy", VALUES)
        away = np.linspace(5.0, 6.0, 4)
        with pytest.raises(CaseError, match=r"no cell of the grid lies on the map .* of 2 x 3 mm") as caught:
            height_map_separation(source(tmp_path / "map.npy"), away, away, KEY)
        assert caught.value.key == KEY

    @pytest.mark.parametrize(
        ("name", "content", "text"),
        [
            ("map.h5", b"no HDF5", "cannot be read"),
            ("map.npy", b"no array", "it is not a NumPy file of numbers, or it is cut short or damaged$"),
            ("map.npy", b"", "cannot be read"),
            ("map.npz", b"PK\x03\x04 cut", "cannot be read"),
        ],
    )
    def test_unreadable_file(self, tmp_path, name, content, text):
        file = tmp_path / name
        file.write_bytes(content)
        with pytest.raises(FileError, match=text) as caught:
            load_height_map(source(file, dataset="a" if name == "map.h5" else None), KEY)
        assert caught.value.file == file
        assert "\n" not in str(caught.value)

    @pytest.mark.parametrize("name", ["none.npy", "none.h5", "none.txt"])
    def test_missing_file(self, tmp_path, name):
        with pytest.raises(FileError, match=r"cannot be read: No such file or directory$"):
            load_height_map(source(tmp_path / name, dataset="a"), KEY)

    def test_folder(self, tmp_path):
        (tmp_path / "map.npy").mkdir()
        with pytest.raises(FileError, match="is a folder"):
            load_height_map(source(tmp_path / "map.npy"), KEY)
