from __future__ import annotations

import numpy as np
import pytest

from fretsolve.problem.model.grid import cell_centers
from fretsolve.problem.surface.height_map import HeightMap

VALUES = np.array([[0.0, 1.0, 2.0, 3.0], [10.0, 11.0, 12.0, 13.0], [20.0, 21.0, 22.0, 23.0]])


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

    def test_hole_of_a_map_that_lies_far_off_leaves_its_neighbours_alone(self):
        values = np.full((5, 5), 76.0)
        values[2, 2] = np.nan
        sampled = HeightMap(values, (1.0, 1.0)).sample(np.array([-1.0 + 1e-7, 0.0]), np.array([0.0]))
        np.testing.assert_allclose(sampled, [[76.0], [np.inf]], rtol=1e-15)


class TestMeans:
    """Means of cells over the bilinear surface."""

    def test_are_those_of_many_points(self):
        values = np.random.default_rng(3).normal(size=(9, 11))
        x, y = cell_centers(3, 2.3, 0.2), cell_centers(4, 0.45, -0.3)  # cells of several facets, and within a facet
        means = HeightMap(values, (1.0, 1.0), mean=True).sample(x, y)
        offsets = (np.arange(400) + 0.5) / 400 - 0.5
        for i, j in np.ndindex(3, 4):
            points = HeightMap(values, (1.0, 1.0)).sample(x[i] + 2.3 * offsets, y[j] + 0.45 * offsets)
            assert means[i, j] == pytest.approx(points.mean(), abs=3e-6)

    def test_wave_as_long_as_the_cell_vanishes(self):
        x = cell_centers(101, 0.1, 0.0)
        wave = HeightMap(np.sin(2.0 * np.pi * x)[:, None] + np.zeros(20), (0.1, 0.1), mean=True)
        np.testing.assert_allclose(wave.sample(cell_centers(8, 1.0, 0.033), cell_centers(3, 0.5, 0.0)), 0.0, atol=1e-15)

    @pytest.mark.parametrize("side", [1e-4, 0.3, 1.0, 3.7])
    def test_plane_and_offset_stay(self, side):
        x, y = cell_centers(30, 1.0, 0.0), cell_centers(40, 1.0, 0.0)
        plane = HeightMap(76.0 + 0.3 * x[:, None] - 0.2 * y, (1.0, 1.0), mean=True)
        cells = cell_centers(4, side, 0.17)
        np.testing.assert_allclose(plane.sample(cells, cells), 76.0 + 0.3 * cells[:, None] - 0.2 * cells, rtol=1e-13)

    def test_cells_that_are_not_wholly_on_the_map_have_no_material(self):
        height_map = HeightMap(VALUES, (1.0, 1.0), mean=True)
        x, y = cell_centers(4, 1.0, 0.0), cell_centers(3, 1.0, 0.0)
        sampled = height_map.sample(x, y)
        assert np.isfinite(sampled).tolist() == [[False] * 3, [True] * 3, [True] * 3, [False] * 3]
        assert height_map.border(x, y)[1:3].tolist() == [[True] * 3] * 2

    def test_hole_takes_the_cells_that_its_facets_reach(self):
        values = np.zeros((9, 9))
        values[4, 4] = np.nan
        cells = cell_centers(8, 1.0, 0.0)  # cells are facets
        taken = np.isinf(HeightMap(values, (1.0, 1.0), mean=True).sample(cells, cells))
        assert np.argwhere(taken).tolist() == [[3, 3], [3, 4], [4, 3], [4, 4]]

    def test_single_line_of_cells_takes_means_along_x_alone(self):
        profile = HeightMap(np.array([0.0, 1.0, 0.0, 3.0, 0.0])[:, None], (1.0, 1.0), mean=True)
        np.testing.assert_allclose(profile.sample(np.array([-1.0, 1.0]), np.zeros(1)), [[0.5], [1.5]], rtol=1e-15)

    def test_slope_of_cells_that_are_coarser_than_the_waves(self):
        """Heights at points keep most of the slope of waves that the cells cannot hold; means take it off."""
        step, cutoff = 5e-4, 0.01
        values, slope = self_affine(512, 512 * step, 0.1, cutoff)

        def seen(side: float, mean: bool) -> float:
            x = cell_centers(int(0.25 / side), side, 0.0)
            heights = HeightMap(values, (step, step), mean).sample(x, x)
            return np.sqrt(sum(np.mean(np.diff(heights, axis=axis) ** 2) for axis in (0, 1))) / side / slope

        assert (seen(cutoff / 1.3, False), seen(cutoff / 1.3, True)) == pytest.approx((0.85, 0.74), abs=0.04)
        assert (seen(cutoff / 5, False), seen(cutoff / 5, True)) == pytest.approx((0.98, 0.97), abs=0.02)


def self_affine(count: int, span: float, rolloff: float, cutoff: float) -> tuple[np.ndarray, float]:
    """Return a surface of Hurst exponent 0.8 with random phases, and its root mean square slope by its modes."""
    numbers = 2.0 * np.pi / span * np.fft.fftfreq(count, 1.0 / count)
    q = np.hypot(numbers[:, None], numbers)
    ends = 2.0 * np.pi / rolloff, 2.0 * np.pi / cutoff
    amplitudes = np.where((q > 0) & (q <= ends[1]), np.maximum(q / ends[0], 1.0) ** -1.8, 0.0)
    noise = np.fft.fft2(np.random.default_rng(1).normal(size=(count, count)))
    modes = 1e-3 * amplitudes * noise / np.abs(noise)
    return count**2 * np.fft.ifft2(modes).real, float(np.sqrt(np.sum(np.abs(q * modes) ** 2)))
