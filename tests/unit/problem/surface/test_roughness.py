"""Roughness by its spectrum: certified values, spectra found again by Fourier transform, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_cases import CASE, case_error, write_case

from fretsolve.case.keys.body_specs import RoughnessSurface, SphereSurface
from fretsolve.case.line_case import LineRoughness
from fretsolve.case.loading import load_case
from fretsolve.errors import CaseError
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.problem.surface.roughness import waves_of
from fretsolve.problem.surface.separation import is_mirrored, separation
from fretsolve.simulation.problem_setup import set_up

KEYS = {"hurst": 0.8, "rms_height": "0.1 um", "rolloff": "0.1 mm", "cutoff": "10 um", "span": "0.5 mm"}
C0, SLOPE, SLOPE_BY_DIFFERENCES = 1.461074e-11, 0.012084, 0.011958
"""Certified for these keys: of the spectrum's integral (mm^4, 1), and by differences of 512 x 512 points of a surface
that another generator scales to the height exactly."""


def rough(**keys) -> RoughnessSurface:
    return RoughnessSurface.model_validate(KEYS | keys)


def rough_line(**keys) -> LineRoughness:
    return LineRoughness.model_validate(KEYS | keys)


def on_period(surface: RoughnessSurface, points: int) -> np.ndarray:
    """The heights on a grid of one period; of a line contact, a column."""
    grid = Grid.from_size((points, points), (0.5, 0.5))
    return separation([surface], grid.x, np.zeros(1) if surface.of_line else grid.y)


class TestSpectrum:
    @pytest.mark.parametrize("seed", [1, 2, 3])
    def test_waves_have_the_height_that_is_asked_and_the_slope_of_the_integral(self, seed):
        surface = rough(seed=seed)
        height, slope = waves_of(surface).rms()
        assert height == pytest.approx(1e-4, rel=1e-12)
        assert slope == pytest.approx(SLOPE, rel=0.01)
        heights, step = on_period(surface, 512), 0.5 / 512
        assert np.std(heights) == pytest.approx(1e-4, rel=1e-10)
        differences = [np.diff(heights, axis=axis, append=heights.take([0], axis)) / step for axis in (0, 1)]
        assert np.hypot(np.std(differences[0]), np.std(differences[1])) == pytest.approx(SLOPE_BY_DIFFERENCES, rel=1e-3)

    def test_slope_is_an_alternative_to_height(self):
        height, slope = waves_of(rough(rms_height=None, rms_slope=0.02)).rms()
        assert slope == pytest.approx(0.02, rel=1e-12)
        assert height == pytest.approx(1e-4 * 0.02 / SLOPE, rel=0.01)

    def test_transform_of_the_heights_is_the_spectrum(self):
        density = np.abs(np.fft.fft2(on_period(rough(), 128)) / 128**2) ** 2 * 0.5**2
        assert density[0, 0] < 1e-30
        for i, j, over in ((1, 0, 1), (0, -1, 1), (-3, 4, 1), (6, 8, 2**-3.6), (-50, 0, 10**-3.6), (30, -40, 10**-3.6)):
            assert density[i, j] == pytest.approx(density[1, 0] * over, rel=1e-6)
        assert density[1, 0] == pytest.approx(C0, rel=0.02)
        for i, j in ((51, 0), (0, 51), (40, -40)):
            assert density[i, j] < 1e-9 * C0

    def test_profile_has_the_spectrum_of_a_line(self):
        surface = rough_line()
        density = np.abs(np.fft.fft(on_period(surface, 128)[:, 0]) / 128) ** 2 * 0.5
        assert density[10] / density[5] == pytest.approx(2**-2.6) and density[-10] == pytest.approx(density[10])
        assert density[1] == pytest.approx(density[4])
        assert density[50] == pytest.approx(density[5] * 10**-2.6) and density[51] < 1e-9 * density[50]


class TestSurface:
    @pytest.mark.parametrize("make", [rough, rough_line])
    def test_every_grid_sees_the_same_surface(self, make):
        surface = make(seed=5)
        fine, coarse = on_period(surface, 192), on_period(surface, 64)  # a coarse centre is that of 3 x 3 fine cells
        np.testing.assert_allclose(coarse, fine[1::3, 1::3] if make is rough else fine[1::3], rtol=0, atol=1e-16)

    def test_period_is_the_span_about_the_centre(self):
        x, y = np.array([0.03, 0.1]), np.array([-0.2, 0.0, 0.07])
        here = separation([rough()], x, y)
        np.testing.assert_allclose(separation([rough()], x + 0.5, y - 1.0), here, rtol=0, atol=1e-15)
        np.testing.assert_allclose(separation([rough(center=[1.0, 2.0])], x + 1, y + 2), here, rtol=0, atol=1e-15)

    def test_seeds_are_independent_surfaces(self):
        one, other = on_period(rough(seed=1), 128), on_period(rough(seed=2), 128)
        assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.3
        np.testing.assert_array_equal(one, on_period(rough(seed=1), 128))

    @pytest.mark.parametrize("make", [rough, rough_line])
    def test_shorter_cutoff_keeps_the_longer_waves(self, make):
        long, all_waves = (np.fft.fft2(on_period(make(cutoff=cutoff), 256)) for cutoff in ("20 um", "5 um"))
        there = np.abs(long) > 1e-9 * np.abs(long).max()
        ratio = all_waves[there] / long[there]
        assert there.sum() > 40
        np.testing.assert_allclose(ratio, ratio[0].real, rtol=1e-6)

    def test_surface_is_no_mirror_image_of_itself(self):
        grid = Grid.from_size((64, 64), (0.5, 0.5))
        assert not is_mirrored(grid, on_period(rough(), 64))

    def test_surface_adds_up_with_others(self):
        ball = [SphereSurface(radius=10.0)]
        x = y = np.linspace(-0.2, 0.2, 5)
        np.testing.assert_allclose(
            separation([*ball, rough()], x, y), separation(ball, x, y) + separation([rough()], x, y), atol=1e-17
        )


GRID = "grid: {points: 16}"
SPANLESS = "{hurst: 0.8, rms_height: 0.1 um, rolloff: 0.1 mm, cutoff: 20 um}"


def case_text(roughness: str, grid: str = "{points: 64, size: 0.5 mm}", more: str = "") -> str:
    surface = f"[{{sphere: {{radius: 10 mm}}}}, {{roughness: {roughness}}}]"
    text = CASE[: CASE.index("expect")].replace("{sphere: {radius: 10 mm}}", surface)
    return text.replace(GRID, f"grid: {grid}") + more


class TestSpan:
    @pytest.mark.parametrize(("size", "span"), [("0.5 mm", 0.5), ("[300 um, 0.4]", 0.4)])
    def test_longer_side_of_the_grid_is_the_default(self, size: str, span: float, tmp_path: Path):
        path = write_case(tmp_path, case_text(SPANLESS, f"{{points: 64, size: {size}}}"))
        case = load_case(path)
        assert case.surface[1].span == span
        assert case.effective()["surface"][1]["roughness"]["span"] == span
        assert load_case(path, ["grid.size=0.6 mm"]).surface[1].span == 0.6

    def test_given_span_stays(self, tmp_path: Path):
        path = write_case(tmp_path, case_text(SPANLESS.replace("}", ", span: 1 mm}")))
        assert load_case(path).surface[1].span == 1.0

    @pytest.mark.parametrize("grid", ["{points: 64}", "{points: 64, size: auto}"])
    def test_automatic_size_gives_none(self, grid: str, tmp_path: Path):
        error = case_error(write_case(tmp_path, case_text(SPANLESS, grid)))
        assert error.message == "span is missing, and grid.size is auto; give the period, such as 0.5 mm"

    def test_wrong_size_is_refused_by_itself(self, tmp_path: Path):
        error = case_error(write_case(tmp_path, case_text(SPANLESS, "{points: 64, size: 5 N}")))
        assert "grid.size" in str(error) and "span" not in str(error)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("hurst: 0.8", "hurst: 1"), "roughness.hurst: 1 is out of range; a number > 0 and < 1 is needed"),
        (("hurst: 0.8", "hurst: 0"), "roughness.hurst: 0 is out of range; a number > 0 and < 1 is needed"),
        (("rms_height", "rms_slope: 0.1, rms_height"), "either rms_height or rms_slope is needed; both are given"),
        (("rms_height: 0.1 um, ", ""), "either rms_height or rms_slope is needed; neither is given"),
        (("0.1 mm", "0.6 mm"), "roughness.rolloff: 0.6 mm is longer than the span (0.5 mm); a shorter one is needed"),
        (("20 um", "0.1 mm"), "roughness.cutoff: 0.1 mm is not shorter than the rolloff (0.1 mm); a shorter"),
        (("rolloff: 0.1 mm, cutoff: 20 um", "cutoff: 1"), "cutoff: 1 mm is not shorter than the span (0.5 mm)"),
        (("20 um", "0.1 um"), "5000 of the shortest waves fit into the span (0.5 mm), at most 4096 are possible"),
        (("rms_height", "Sq"), "unknown key 'Sq'; the root mean square height is 'rms_height'"),
        (("hurst", "seed: 1.5, hurst"), "roughness.seed: 1.5 is not allowed; a whole number such as 10 is needed"),
    ],
)
def test_wrong_keys_are_refused(change: tuple[str, str], says: str, tmp_path: Path):
    error = case_error(write_case(tmp_path, case_text(SPANLESS.replace(*change))))
    assert says in str(error) and error.exit_code == 2


class TestGrid:
    def setup(self, tmp_path: Path, *overrides: str):
        return set_up(load_case(write_case(tmp_path, case_text(SPANLESS)), overrides))

    def test_cutoff_under_two_cells_is_refused(self, tmp_path: Path):
        with pytest.raises(CaseError) as caught:
            self.setup(tmp_path, "grid.points=[64, 48]")
        assert caught.value.key == ("surface", 1, "roughness", "cutoff")
        wanted = "0.02 mm is under two cells of the grid (0.0104 mm each); 0.0208 mm or more is needed, or more points"
        assert caught.value.message == wanted
        self.setup(tmp_path, "grid.points=50")

    @pytest.mark.parametrize(("points", "missed"), [(249, True), (250, False)])
    def test_fewer_than_ten_cells_per_shortest_wave_warn(self, points: int, missed: bool, tmp_path: Path):
        told = [text for text in case_warnings(self.setup(tmp_path, f"grid.points={points}")) if "waves" in text]
        assert len(told) == missed
        if missed:
            assert told[0].startswith("grid.points: 249 x 249 cells miss waves of the roughness that take ")
            assert told[0].endswith(" MPa to flatten; 250 x 250 points would resolve them")

    def test_waves_that_flatten_under_hardly_any_pressure_do_not_matter(self, tmp_path: Path):
        setup = self.setup(tmp_path, "surface.1.roughness.rms_height=0.1 nm")
        assert not any("waves" in text for text in case_warnings(setup))

    def test_first_round_of_an_accuracy_has_two_cells_per_wave(self, tmp_path: Path):
        text = case_text(SPANLESS, "{size: 0.5 mm}", "solver: {accuracy: 20 %}\n")
        setup = set_up(load_case(write_case(tmp_path, text)))
        assert min(setup.grid.shape) == 54  # of 10 um, rounded up to a multiple of 6
        assert not any("waves" in text for text in case_warnings(setup))

    def test_rough_flat_alone_has_no_automatic_size(self, tmp_path: Path):
        flat = SPANLESS.replace("}", ", span: 1 mm}")
        text = case_text(flat, "{points: 64}").replace("{sphere: {radius: 10 mm}}, ", "")
        with pytest.raises(CaseError, match=r"grid\.size: a rough flat does not end, so that no size"):
            set_up(load_case(write_case(tmp_path, text)))
