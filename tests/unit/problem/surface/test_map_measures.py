from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.problem.model.grid import cell_centers
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_measures import measures_of, point_warnings, spectrum

STEP = 1e-3


def wave(points: float, count: int = 500, lines: int = 20, amplitude: float = 1e-3) -> HeightMap:
    """Return a sine along x of so many points per wave."""
    x = cell_centers(count, 1.0, 0.0)[:, None]
    return HeightMap(amplitude * np.sin(2.0 * np.pi * x / points + 0.3) + np.zeros(lines), (STEP, STEP))


def noise(nx: int = 256, ny: int = 128, spacing: tuple[float, float] = (STEP, STEP)) -> HeightMap:
    return HeightMap(1e-4 * np.random.default_rng(5).normal(size=(nx, ny)), spacing)


class TestSizes:
    def test_of_a_small_map(self):
        values = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
        measures = measures_of(HeightMap(values, (0.5, 0.25)))
        assert (measures.points, measures.spacing, measures.span) == ((3, 3), (0.5, 0.25), (1.0, 0.5))
        assert measures.height_range == 1.0
        assert measures.sq == pytest.approx(math.sqrt(20.0) / 9.0)  # 4 of 5/9 and 5 of -4/9
        assert measures.sa == pytest.approx(40.0 / 81.0)
        assert measures.sdq == pytest.approx(math.sqrt(2.0**2 + 4.0**2))
        assert measures.tilts == pytest.approx((0.0, 0.0), abs=1e-15)

    def test_form(self):
        x, y = cell_centers(80, 5e-3, 0.0)[:, None], cell_centers(60, 5e-3, 0.0)
        measures = measures_of(HeightMap(0.01 * x - 0.003 * y - (x**2 + y**2) / 20.0, (5e-3, 5e-3)))
        assert measures.tilts == pytest.approx((0.01, -0.003), rel=1e-12)
        assert measures.radius == pytest.approx(-10.0, rel=1e-12)
        flat = measures_of(HeightMap(76.0 + 0.1 * x - 0.003 * y, (5e-3, 5e-3)))
        assert flat.radius == math.inf
        assert flat.sq < 1e-13

    def test_holes(self):
        height_map = noise()
        height_map.values[5:9, 5:9] = height_map.values[20, 30] = height_map.values[:3, 50:52] = np.nan
        measures = measures_of(height_map)
        assert (measures.lost_points, measures.holes_inside, measures.holes_at_rim) == (23, 2, 1)
        assert measures.sq == pytest.approx(1e-4, rel=0.01)

    @pytest.mark.parametrize("shape", [(2, 2), (2, 1), (3, 1)])
    def test_least_maps(self, shape):
        measures = measures_of(HeightMap(np.zeros(shape), (1.0, 1.0)))
        assert (measures.sq, measures.sdq, measures.radius, measures.shortest_wave) == (0.0, 0.0, math.inf, math.inf)


class TestRoughness:
    @pytest.mark.parametrize("points", [10.0, 25.0, 50.0])
    def test_of_a_sine(self, points):
        measures = measures_of(wave(points))
        assert measures.sq == pytest.approx(1e-3 / math.sqrt(2.0), rel=5e-3)
        assert measures.sa == pytest.approx(2e-3 / math.pi, rel=0.03)  # of few points
        by_differences = math.sin(math.pi / points) / (math.pi / points)
        slope = 2.0 * math.pi * 1e-3 / (points * STEP) / math.sqrt(2.0)
        assert measures.sdq == pytest.approx(slope * by_differences, rel=5e-3)

    def test_of_a_profile(self):
        one = measures_of(HeightMap(wave(25.0).values[:, :1], (STEP, STEP)))
        whole = measures_of(wave(25.0))
        assert (one.sq, one.sdq) == pytest.approx((whole.sq, whole.sdq), rel=1e-12)
        assert one.tilts == pytest.approx(whole.tilts[:1])
        assert len(one.shortest_waves) == 1


class TestWaves:
    @pytest.mark.parametrize("count", [128, 500, 501])
    @pytest.mark.parametrize("points", [10.0, 17.3, 50.0])
    def test_of_a_sine_within_two_lines_of_its_spectrum(self, count, points):
        shortest = measures_of(wave(points, count)).shortest_wave / STEP
        assert 0.0 < count / shortest - count / points < 2.0

    def test_of_noise_is_two_points(self):
        measures = measures_of(noise(spacing=(STEP, 2.0 * STEP)))
        assert measures.shortest_waves == pytest.approx((2.0 * STEP, 4.0 * STEP), rel=0.02)
        assert measures.shortest_wave == measures.shortest_waves[0]

    def test_along_the_lay_noise_does_not_count(self):
        ground = HeightMap(wave(20.0, lines=100).values + 1e-3 * noise(500, 100).values, (STEP, STEP))
        along_x, along_y = measures_of(ground).shortest_waves
        assert along_x == pytest.approx(20.0 * STEP, rel=0.1)
        assert along_y == math.inf

    def test_shortest_of_two_is_not_lost_in_the_longer(self):
        both = HeightMap(wave(100.0).values + wave(20.0, amplitude=5e-5).values, (STEP, STEP))
        assert measures_of(both).shortest_wave == pytest.approx(20.0 * STEP, rel=0.1)
        weak = HeightMap(wave(100.0).values + wave(20.0, amplitude=1e-5).values, (STEP, STEP))
        assert measures_of(weak).shortest_wave > 60.0 * STEP

    @pytest.mark.parametrize("step", [0.0, 1e-6])
    def test_ball_has_none_even_if_rounded(self, step):
        x = cell_centers(128, 5e-3, 0.0)
        ball = 10.0 - np.sqrt(100.0 - x[:, None] ** 2 - x**2)
        values = np.round(ball / step) * step if step else ball
        measures = measures_of(HeightMap(values, (5e-3, 5e-3)))
        assert measures.shortest_wave == math.inf
        assert point_warnings(measures) == ()

    def test_lines_with_lost_points_are_left_out(self):
        holed = noise()
        holed.values[10, :100] = np.nan
        assert measures_of(holed).shortest_waves == pytest.approx((2.0 * STEP, 2.0 * STEP), rel=0.05)
        holed.values[10, :] = np.nan
        along_x, along_y = measures_of(holed).shortest_waves
        assert math.isnan(along_x)
        assert along_y == measures_of(holed).shortest_wave
        holed.values[:, 10] = np.nan
        assert math.isnan(measures_of(holed).shortest_wave)
        assert point_warnings(measures_of(holed)) == ()

    def test_warning(self):
        measures = measures_of(HeightMap(wave(5.0).values, (5e-3, 5e-3)))
        (warning,) = point_warnings(measures)
        assert warning == "the shortest wave of the map, 25 um, has 5 points; ten are needed for its slope"
        assert point_warnings(measures_of(wave(11.0))) == ()


class TestSpectrum:
    @pytest.mark.parametrize("axis", [0, 1])
    @pytest.mark.parametrize("shape", [(256, 128), (255, 129)])
    def test_integral_is_the_mean_square_height(self, axis, shape):
        wavelengths, density = spectrum(noise(*shape, spacing=(STEP, 3.0 * STEP)), axis)
        numbers = 2.0 * np.pi / wavelengths
        assert np.sum(density) * numbers[0] / np.pi == pytest.approx(1e-8, rel=0.03)
        step = (STEP, 3.0 * STEP)[axis]
        np.testing.assert_allclose(np.median(density), 1e-8 * step, rtol=0.05)  # white: Sq^2 dx at all waves
        assert wavelengths[0] == pytest.approx(shape[axis] * step)
        assert wavelengths[-1] == pytest.approx(2.0 * step, rel=0.01)

    def test_peak_of_a_sine(self):
        wavelengths, density = spectrum(wave(25.0), 0)
        assert wavelengths[np.argmax(density)] == pytest.approx(25.0 * STEP, rel=1e-12)

    def test_without_a_whole_line(self):
        wavelengths, density = spectrum(HeightMap(np.array([[1.0], [np.nan], [2.0]]), (STEP, STEP)), 0)
        assert wavelengths.size == density.size == 0
