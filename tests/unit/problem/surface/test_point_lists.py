from __future__ import annotations

import re

import numpy as np
import pytest

from fretsolve.problem.surface.files.point_lists import evened, gridded

RNG = np.random.default_rng(4)
PLACES = np.stack(np.meshgrid(np.arange(30), np.arange(17), indexing="ij"), axis=-1).reshape(-1, 2)
"""Index along x and y of each point of a grid."""
HEIGHTS = PLACES @ [100.0, 1.0]


def listed(x, y, z=HEIGHTS) -> np.ndarray:
    """Return the points in disorder."""
    return RNG.permutation(np.column_stack([x, y, z]))


def grid(points):
    """Return heights, spacing and remark of points below ten lines of a header."""
    values, spacing, _, remark = gridded(points, np.arange(len(points)) + 11)
    return values, spacing, remark


def profile(points):
    return evened(points, np.arange(len(points)) + 11)


def refusal(points) -> str:
    with pytest.raises(ValueError, match=r"^[^\n]+$") as caught:
        grid(np.array(points, float))
    return str(caught.value)


class TestGrid:
    def test_in_any_order(self):
        values, spacing, remark = grid(listed(PLACES[:, 0] * 2.0 + 5.0, PLACES[:, 1] * -3.0))
        np.testing.assert_array_equal(values, HEIGHTS.reshape(30, 17)[:, ::-1])  # y upwards
        assert spacing == pytest.approx((2.0, 3.0), rel=1e-12)
        assert remark is None

    @pytest.mark.parametrize("step", [1 / 3, 0.7, 1.04])
    @pytest.mark.parametrize("digits", [1, 3])
    @pytest.mark.parametrize("noise", [0.0, 1e-4, 0.05, 0.1])
    def test_coordinates_rounded_and_noisy(self, step, digits, noise):
        x, y = np.round(step * (PLACES + RNG.uniform(-noise, noise, PLACES.shape)) + 70.0, digits).T
        values, spacing, _ = grid(listed(x, y))
        np.testing.assert_array_equal(values, HEIGHTS.reshape(30, 17))
        assert spacing == pytest.approx((step, step), rel=0.01)

    def test_missing_points_are_holes(self):
        x, y = 0.1 * PLACES.T
        z = np.where(PLACES[:, 0] == 3, np.nan, HEIGHTS)  # a line of x y nan
        values, _, remark = grid(listed(x, y, z)[np.argsort(RNG.random(len(x)))[:400]])
        finite = np.isfinite(values)
        np.testing.assert_array_equal(values[finite], HEIGHTS.reshape(30, 17)[finite])
        assert not finite[3].any()
        assert remark == f"{510 - finite.sum()} of 510 points are missing: holes"

    def test_points_without_anything_are_missing_ones(self):
        points = [[0, 0, 1], [1, 0, 2], [np.nan, np.nan, np.nan], [0, 1, 3]]
        values, _, remark = grid(np.array(points))
        np.testing.assert_array_equal(values, [[1, 3], [2, np.nan]])
        assert remark == "1 of 4 points are missing: holes"

    def test_where_it_begins(self):
        start = gridded(listed(PLACES[:, 0] * 2.0 + 5.0, PLACES[:, 1] * -3.0), np.arange(510))[2]
        assert start == (5.0, -48.0)

    def test_no_grid(self):
        start = "its 3 columns are read as x y z, which are no grid: "
        assert refusal([[1, 2, 3]] * 4) == start + "all have the same x"
        assert refusal(np.arange(12).reshape(4, 3)).startswith(start + "a grid for them has 4 x 4 points, they are 4")
        same = [[0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 3], [1, 0, 2]]
        assert refusal(same) == start + "lines 13 and 15 give one place, x = 1, y = 0"
        off = np.column_stack([0.1 * PLACES, HEIGHTS])
        off[7, 0] += 0.04
        assert re.search("the x in line 18, 0.04, is 0.4[0-9] of a step off a regular line of ", refusal(off))
        assert refusal(RNG.random((300, 3))).startswith(start)

    def test_coordinates_rounded_to_about_a_step(self):
        x, y = np.round(PLACES * [1.0, 0.0156], 2).T
        assert "lines along y, 0.01 apart, have no point; are the coordinates rounded too coarsely?" in refusal(
            listed(x, y)
        )

    def test_most_points_are_needed(self):
        points = np.column_stack([PLACES, np.where(np.arange(510) % 5 < 2, HEIGHTS, np.nan)])
        assert refusal(points) == "306 of the 30 x 17 points of its grid x y z are missing, more than half"
        assert "they are 170, less than half" in refusal(points[np.arange(510) % 3 == 0])

    def test_a_height_needs_a_place(self):
        assert refusal([[0, 0, 1], [1e300, 0, 2], [0, 1, 3]]) == "line 12 holds no possible x or y"
        assert refusal([[0, 0, 1], [np.nan, 0, 2], [0, 1, 3]]) == "line 12 has a height, but its x or y is lost"


class TestProfile:
    def test_even(self):
        z, step, remark = profile(np.array([[0.2, 3.0], [0.0, 1.0], [0.1, 2.0]]))
        assert z.tolist() == [1.0, 2.0, 3.0]
        assert step == pytest.approx(0.1, rel=1e-12)
        assert remark is None

    def test_uneven_is_resampled_to_the_mean_step(self):
        z, step, remark = profile(np.array([[0.0, 0.0], [1.0, 10.0], [3.0, 10.0], [4.0, 20.0], [8.0, 60.0]]))
        assert z.tolist() == [0.0, 10.0, 20.0, 40.0, 60.0]
        assert step == 2.0
        assert remark == "x of the profile is not even: steps of 1 to 4 are resampled to 2"

    @pytest.mark.parametrize(
        ("points", "message"),
        [
            ([[0, 1], [1, 2], [1, 3]], "lines 12 and 13 have the same x, 1; a profile x z has one height for each x"),
            ([[0, 1]], "it has 1 points x z of a profile; at least 2 are needed"),
            ([[0, 1], [np.nan, 2], [2, 3]], "line 12 has a height, but its x is lost"),
        ],
    )
    def test_faults(self, points, message):
        with pytest.raises(ValueError, match=r".") as caught:
            profile(np.array(points, float))
        assert str(caught.value) == message
