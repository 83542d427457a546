from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import FileError
from fretsolve.problem.model.grid import cell_centers
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.load_map import load_height_map

KEY = ("surface", 0, "heights")
VALUES = np.array([[0.0, 1.0, 2.0, 3.0], [10.0, 11.0, 12.0, 13.0], [20.0, 21.0, 22.0, 23.0]])


def source(file: Path, **rest) -> HeightsSurface:
    return HeightsSurface(file=str(file), **{"spacing": (1.0, 1.0), **rest})


def without_spacing(file: Path, **rest) -> HeightsSurface:
    return HeightsSurface(file=str(file), **rest)


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
        "text",
        [
            "0 1 2 3\n10 11 12 13\n20 21 22 23\n",
            "# scan, 2 um\n\n0, 1, 2, 3\n10, 11, 12, 13\n20, 21, 22, 23",
            "\ufeff0;1;2;3\r\n10;11;12;13\r\n20;21;22;23\r\n",
            "0\t1\t2\t3 # row along y\n10\t11\t12\t13\n20\t21\t22\t23\n",
        ],
    )
    def test_text_matrix_has_its_rows_along_x(self, tmp_path, text):
        file = tmp_path / "map.csv"
        file.write_text(text, encoding="utf-8")
        np.testing.assert_array_equal(load_height_map(source(file), KEY).values, VALUES)

    def test_text_of_points_of_a_grid_in_any_order(self, tmp_path):
        points = [(i * 2.0 + 5.0, j * 3.0 - 1.0, VALUES[i, j]) for i in range(3) for j in range(4)]
        np.random.default_rng(4).shuffle(points)
        np.savetxt(tmp_path / "map.xyz", points)
        read = load_height_map(without_spacing(tmp_path / "map.xyz", unit="um"), KEY)
        assert read.spacing == pytest.approx((0.002, 0.003), rel=1e-12)
        np.testing.assert_allclose(read.values, VALUES * 1e-3, rtol=1e-12)

    @pytest.mark.parametrize(
        "rows", [np.arange(12.0).reshape(4, 3), np.zeros((4, 3)), [[0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 0, 2]]]
    )
    def test_three_columns_that_list_no_grid_are_a_matrix(self, tmp_path, rows):
        np.savetxt(tmp_path / "map.txt", rows)
        np.testing.assert_array_equal(load_height_map(source(tmp_path / "map.txt"), KEY).values, rows)


class TestFaults:
    @pytest.mark.parametrize(
        ("name", "content", "text"),
        [
            ("map.txt", b"", "it holds no numbers"),
            ("map.txt", b"# only a comment\n", "it holds no numbers"),
            ("map.txt", b"height\n1 2\n", "could not convert string 'height'"),
            ("map.txt", b"1 2\n3\n", "cannot be read"),
            ("map.txt", b"\xff\xfe\x00", "cannot be read"),
        ],
    )
    def test_unreadable_file(self, tmp_path, name, content, text):
        file = tmp_path / name
        file.write_bytes(content)
        with pytest.raises(FileError, match=text) as caught:
            load_height_map(source(file), KEY)
        assert caught.value.file == file
        assert "\n" not in str(caught.value)
