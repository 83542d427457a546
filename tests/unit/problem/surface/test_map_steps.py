from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.line_case import LineHeights
from fretsolve.errors import CaseError
from fretsolve.problem.model.grid import cell_centers
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_steps import prepared

KEY = ("surface", 0, "heights")


def done(height_map: HeightMap, **asked) -> HeightMap:
    """Return a map, or a profile, after the steps that a case asks for."""
    if height_map.values.shape[1] == 1:
        return prepared(height_map, LineHeights(file="map.npy", **asked), KEY)
    return prepared(height_map, HeightsSurface(file="map.npy", **asked), KEY)


def refused(height_map: HeightMap, name: str, **asked) -> str:
    with pytest.raises(CaseError) as caught:
        done(height_map, **asked)
    assert caught.value.key == (*KEY, name)
    assert "\n" not in caught.value.message
    return caught.value.message


def places(nx: int, ny: int, dx: float, dy: float) -> tuple[np.ndarray, np.ndarray]:
    return cell_centers(nx, dx, 0.0)[:, None], cell_centers(ny, dy, 0.0)[None, :]


def plane(nx: int = 60, ny: int = 40) -> HeightMap:
    x, y = places(nx, ny, 1e-3, 2e-3)
    return HeightMap(0.3 * x - 0.02 * y, (1e-3, 2e-3))


def with_holes(height_map: HeightMap, *parts: tuple[slice, slice]) -> HeightMap:
    values = height_map.values.copy()
    for part in parts:
        values[part] = np.nan
    return HeightMap(values, height_map.spacing)


class TestAll:
    def test_nothing_asked_is_nothing_done(self):
        height_map = plane()
        assert done(height_map) is height_map
        assert done(height_map, level="none") is height_map

    def test_in_order_with_a_remark_of_each(self):
        x, y = places(121, 121, 0.01, 0.01)
        values = (x**2 + y**2) / 20.0 + 0.01 * x
        values[60, 60] += 0.5
        values[20, 80:83] = np.nan
        values[0, 0] = np.nan
        raw = HeightMap(values, (0.01, 0.01), remarks=("read",))
        asked = {"crop": ["0.1 mm", "0 mm", "1.1 mm", "1.2 mm"], "spikes": 8, "fill": "1 %", "level": "plane"}
        result = done(raw, **asked, short_cutoff="50 um", long_cutoff="0.5 mm")
        assert [remark.split(":")[0] for remark in result.remarks] == ["read", *asked, "filter", "filter"]
        assert result.remarks[1] == "crop: 101 x 121 points kept"
        assert result.remarks[2].startswith("spikes: 1 point counted as lost")
        assert result.remarks[3] == "fill: 4 points in 2 holes filled"
        assert result.remarks[5:] == (
            "filter: waves shorter than 50 um taken off",
            "filter: waves longer than 0.5 mm taken off",
        )
        assert np.isfinite(result.values).all()


class TestCrop:
    def test_keeps_the_points_within_and_their_ends(self):
        values = np.arange(60.0).reshape(6, 10)
        result = done(HeightMap(values, (0.1, 0.2)), crop=["0.1 mm", "0.3 mm", "0.3 mm", "1.2 mm"])
        np.testing.assert_array_equal(result.values, values[1:4, 2:7])

    def test_whole_map(self):
        values = np.arange(60.0).reshape(6, 10)
        result = done(HeightMap(values, (0.1, 0.1)), crop=["0 mm", "0 mm", "0.5 mm", "0.9 mm"])
        np.testing.assert_array_equal(result.values, values)

    def test_profile(self):
        result = done(HeightMap(np.arange(10.0)[:, None], (0.1, 0.1)), crop=["0.3 mm", "0.55 mm"])
        assert result.values.tolist() == [[3.0], [4.0], [5.0]]
        assert result.remarks == ("crop: 3 points kept",)

    def test_faults(self):
        flat = HeightMap(np.zeros((6, 10)), (0.1, 0.2))
        off = "the part [0.0, 0.0, 0.7, 1.0] mm is not all on the map, which spans 0.5 x 1.8 mm"
        assert refused(flat, "crop", crop=["0 mm", "0 mm", "0.7 mm", "1 mm"]) == off
        few = refused(flat, "crop", crop=["0.11 mm", "0 mm", "0.29 mm", "1 mm"])
        assert few.endswith("mm holds 1 x 6 points, 0.1 mm x 0.2 mm apart; at least 2 x 2 are needed")
        lost = with_holes(flat, (slice(0, 3), slice(None)))
        message = refused(lost, "crop", crop=["0 mm", "0 mm", "0.2 mm", "1 mm"])
        assert message.startswith("all 3 x 6 points of the part")


class TestSpikes:
    def test_in_noise_on_a_tilt(self):
        rng = np.random.default_rng(2)
        tilted = HeightMap(plane(200, 200).values + 1e-3 * rng.normal(size=(200, 200)), (1e-3, 2e-3))
        tilted = with_holes(tilted, (slice(50, 70), slice(50, 70)), (slice(0, 5), slice(0, 30)))
        spikes = ([30, 71, 120, 199], [30, 60, 0, 120])
        tilted.values[spikes] += [0.02, -0.02, 0.02, 0.05]
        result = done(tilted, spikes=7)
        found = np.isnan(result.values) & np.isfinite(tilted.values)
        np.testing.assert_array_equal(np.argwhere(found), np.transpose(spikes))
        assert result.remarks == ("spikes: 4 points counted as lost",)

    def test_standard_deviation_is_that_of_noise(self):
        noise = HeightMap(np.random.default_rng(1).normal(size=(400, 400)), (1.0, 1.0))
        share = np.isnan(done(noise, spikes=2).values).mean()
        assert share == pytest.approx(math.erfc(2.0 / math.sqrt(2.0)), rel=0.1)

    @pytest.mark.parametrize("step", [0.0, 1e-5, 1e-3])
    def test_form_without_noise_has_none_even_if_rounded(self, step):
        x, y = places(150, 150, 5e-3, 5e-3)
        ball = (x**2 + y**2) / 20.0 + 0.01 * x + 0.003 * y
        values = np.round(ball / step) * step if step else ball
        smooth = with_holes(HeightMap(values, (5e-3, 5e-3)), (slice(60, 80), slice(70, 90)), (slice(0, 9), slice(0, 4)))
        np.testing.assert_array_equal(done(smooth, spikes=5).values, smooth.values)
        spiked = HeightMap(smooth.values.copy(), smooth.spacing)
        spiked.values[100, 40] += 0.05
        result = done(spiked, spikes=5)
        assert np.argwhere(np.isnan(result.values) & np.isfinite(smooth.values)).tolist() == [[100, 40]]
        assert result.remarks[0].endswith("by the steps between neighbours, as most equal the median around them")

    def test_steep_plane_and_flat_map(self):
        for values in (plane().values * 1e4, np.full((9, 9), 76.0)):
            assert np.isfinite(done(HeightMap(values, (1.0, 1.0)), spikes=3).values).all()

    def test_profile(self):
        heights = 0.1 * np.arange(50.0) + 1e-3 * np.random.default_rng(1).normal(size=50)
        heights[20] += 1.0
        result = done(HeightMap(heights[:, None], (1.0, 1.0)), spikes=5)
        assert np.flatnonzero(np.isnan(result.values)).tolist() == [20]


class TestFill:
    def test_plane_exactly_and_not_at_the_rim(self):
        whole = plane()
        holes = with_holes(whole, (slice(20, 33), slice(9, 22)), (slice(50, 51), slice(30, 33)), (slice(0, 4), 3))
        result = done(holes, fill="20 %")
        assert result.remarks == ("fill: 172 points in 2 holes filled, 4 points at the rim left",)
        assert np.isnan(result.values[:4, 3]).all()
        known = np.isfinite(result.values)
        assert known.sum() == known.size - 4
        np.testing.assert_allclose(result.values[known], whole.values[known], atol=1e-16)

    def test_plane_that_lies_far_off(self):
        far = HeightMap(plane().values + 76.0, (1e-3, 2e-3))
        result = done(with_holes(far, (slice(20, 33), slice(9, 22))), fill=0.2)
        np.testing.assert_allclose(result.values, far.values, rtol=4e-16)

    @pytest.mark.parametrize(("radius", "too_flat"), [(0.02, 0.02e-3), (0.05, 0.125e-3), (0.1, 0.5e-3)])
    def test_ball_of_10_mm_by_radius_of_the_hole(self, radius, too_flat):
        x, y = places(121, 121, 2e-3, 2e-3)
        ball = (x**2 + y**2) / 20.0
        result = done(HeightMap(np.where(np.hypot(x, y) < radius, np.nan, ball), (2e-3, 2e-3)), fill=1.0)
        assert np.max(np.abs(result.values - ball)) == pytest.approx(too_flat, rel=3e-3 / radius / 2)

    def test_hole_that_meets_the_rim_at_a_corner_only(self):
        holes = with_holes(plane(), (0, 0), (1, 1))
        result = done(holes, fill=0.5)
        assert np.argwhere(np.isnan(result.values)).tolist() == [[0, 0]]

    def test_profile_by_straight_lines(self):
        heights = np.array([np.nan, 1.0, np.nan, np.nan, 4.0, 0.0])[:, None]
        result = done(HeightMap(heights, (0.1, 0.1)), fill=0.5)
        np.testing.assert_allclose(result.values[:, 0], [np.nan, 1.0, 2.0, 3.0, 4.0, 0.0], rtol=1e-15)
        assert result.remarks == ("fill: 2 points in 1 hole filled, 1 point at the rim left",)

    def test_more_than_its_share(self):
        holes = with_holes(plane(), (slice(20, 30), slice(10, 22)))
        message = refused(holes, "fill", fill="4 %")
        assert message == (
            "5 % of the map's points are lost in its holes, more than 4 %; crop the map, or give a larger share"
        )
        assert "filled" in done(holes, fill="5 %").remarks[0]

    def test_nothing_to_fill(self):
        whole = plane()
        result = done(whole, fill="2 %")
        assert result.remarks == ("fill: 0 points in 0 holes filled",)
        np.testing.assert_array_equal(result.values, whole.values)


class TestLevel:
    def ball(self) -> tuple[HeightMap, np.ndarray]:
        """Return a ball of 10 mm with its apex at 0.08 mm, tilted by 0.01, and the places along x."""
        x, y = places(101, 81, 5e-3, 7e-3)
        return HeightMap(((x - 0.08) ** 2 + y**2) / 20.0 + 0.01 * x, (5e-3, 7e-3)), x

    def test_plane_on_a_ball_moves_the_apex_to_the_middle(self):
        ball, x = self.ball()
        result = done(ball, level="plane")
        assert result.remarks == ("level: plane taken off, tilts 0.002 and 0",)
        apex = np.unravel_index(np.argmin(result.values), result.values.shape)
        assert x[apex[0], 0] == 0.0

    @pytest.mark.parametrize(
        ("form", "said"),
        [("sphere", "radius 10 mm"), ("quadratic", "radii 10 and 10 mm"), ("quadratic", "0.002 and 0")],
    )
    def test_curved_forms_take_off_a_ball(self, form, said):
        ball, _ = self.ball()
        holes = with_holes(ball, (slice(20, 70), slice(0, 33)), (90, slice(None)))
        result = done(holes, level=form)
        assert said in result.remarks[0]
        assert np.nanmax(np.abs(result.values)) < 1e-16

    def test_principal_radii_of_a_turned_saddle(self):
        x, y = places(50, 60, 0.02, 0.01)
        along, across = 0.6 * x + 0.8 * y, 0.8 * x - 0.6 * y
        saddle = HeightMap(along**2 / 40.0 - across**2 / 10.0 + 0.5, (0.02, 0.01))
        assert "radii 20 and -5 mm" in done(saddle, level="quadratic").remarks[0]

    def test_offset(self):
        result = done(HeightMap(np.array([[1.0, 3.0], [np.nan, 5.0]]) + 76.0, (1.0, 1.0)), level="offset")
        np.testing.assert_array_equal(result.values, [[-2.0, 0.0], [np.nan, 2.0]])
        assert result.remarks == ("level: offset of 79 mm taken off",)

    def test_what_is_left_has_no_part_of_the_form(self):
        rng = np.random.default_rng(3)
        x, y = places(30, 40, 0.1, 0.2)
        rough = HeightMap(np.where(rng.random((30, 40)) < 0.3, np.nan, rng.normal(size=(30, 40))), (0.1, 0.2))
        left = done(rough, level="quadratic").values
        for term in (1.0, x, y, x**2, x * y, y**2):
            assert abs(np.nansum(left * term)) < 1e-11

    def test_profile(self):
        x = cell_centers(41, 0.01, 0.0)[:, None]
        profile = HeightMap((x - 0.08) ** 2 / 20.0 + 0.01 * x, (0.01, 0.01))
        for form, said in (
            ("sphere", "radius 10 mm of the paraboloid"),
            ("quadratic", "radius 10 mm of the paraboloid"),
        ):
            result = done(profile, level=form)
            assert result.remarks == (f"level: {form} taken off, tilt 0.002, {said}",)
            assert np.max(np.abs(result.values)) < 1e-16
        assert done(profile, level="plane").remarks == ("level: plane taken off, tilt 0.002",)

    def test_too_few_points(self):
        values = np.full((5, 5), np.nan)
        values[[0, 1, 2, 3], [0, 1, 2, 3]] = 1.0
        message = refused(HeightMap(values, (1.0, 1.0)), "level", level="plane")
        assert message == "the 4 known points of the map allow more than one plane; a simpler form is needed"
        assert "offset" in done(HeightMap(values, (1.0, 1.0)), level="offset").remarks[0]


class TestFilter:
    @pytest.mark.parametrize(("ratio", "kept"), [(0.5, 2.0**-4), (1.0, 0.5), (2.0, 2.0**-0.25)])
    @pytest.mark.parametrize("lines", [1, 30])
    def test_transmission_of_sines(self, ratio, kept, lines):
        cutoff, step = 0.08, 2e-3
        x = cell_centers(400, step, 0.0)[:, None]
        wave = np.sin(2.0 * np.pi * x / (ratio * cutoff)) + np.zeros(lines)
        short, long = (
            done(HeightMap(wave, (step, step)), **{name: f"{cutoff} mm"}).values
            for name in ("short_cutoff", "long_cutoff")
        )
        inner = slice(100, -100)
        np.testing.assert_allclose(short[inner], kept * wave[inner], atol=1e-9)
        np.testing.assert_allclose(short + long, wave, atol=1e-15)

    def test_oblique_wave_by_its_own_length(self):
        x, y = places(300, 320, 1e-3, 2e-3)
        wave = np.cos(2.0 * np.pi * (0.6 * x + 0.8 * y) / 0.05)
        result = done(HeightMap(wave, (1e-3, 2e-3)), short_cutoff="50 um").values
        np.testing.assert_allclose(result[80:-80, 80:-80], 0.5 * wave[80:-80, 80:-80], atol=1e-9)

    def test_constant_up_to_rims_and_holes(self):
        flat = with_holes(HeightMap(np.full((60, 40), 7.5), (1e-3, 1e-3)), (slice(20, 40), slice(10, 30)), (0, 0))
        result = done(flat, short_cutoff="20 um").values
        np.testing.assert_array_equal(np.isnan(result), np.isnan(flat.values))
        np.testing.assert_allclose(result[np.isfinite(result)], 7.5, rtol=1e-14)

    def test_cutoffs_that_are_off_the_map(self):
        rest = "a cut-off between two points, 4 um, and the length of the map, 78 um, is needed"
        for name, cutoff in (("short_cutoff", "3.9 um"), ("long_cutoff", "79 um")):
            assert refused(plane(), name, **{name: cutoff}) == f"{cutoff} is no wave of the map; {rest}"
        profile = HeightMap(np.zeros((20, 1)), (1e-3, 1e-3))
        assert "2 um, and the length of the map, 19 um" in refused(profile, "long_cutoff", long_cutoff="20 um")
