"""The smallest ball around points, against all subsets of them."""

from itertools import combinations

import numpy as np
import pytest

from fretsolve.fatigue.smallest_ball import smallest_ball


def radius_by_subsets(points: np.ndarray) -> float:
    """Return the smallest radius of a ball through some of the points (n, d) that holds all of them."""
    n, d = points.shape
    radii = []
    for count in range(1, d + 2):
        for chosen in combinations(range(n), count):
            away = points[list(chosen[1:])] - points[chosen[0]]
            weights = np.linalg.lstsq(2.0 * away @ away.T, np.square(away).sum(axis=1), rcond=None)[0]
            center = points[chosen[0]] + away.T @ weights
            radii.append(np.linalg.norm(points - center, axis=1).max())
    return min(radii)


@pytest.mark.parametrize("dimensions", [1, 2, 5])
@pytest.mark.parametrize("kind", ["random", "ties", "flat"])
def test_radius_is_that_of_the_best_subset(dimensions, kind):
    points = np.random.default_rng(7).normal(size=(8, dimensions, 12))
    if kind == "ties":
        points = np.round(points)  # some coincide
    if kind == "flat":
        points[:, 1:] = 0.0
    radii, centers = smallest_ball(points)
    expected = [radius_by_subsets(points[:, :, i]) for i in range(12)]
    np.testing.assert_allclose(radii, expected, rtol=1e-12)
    reach = np.linalg.norm(points - centers, axis=1).max(axis=0)
    np.testing.assert_allclose(reach, radii, rtol=1e-12)


def test_triangle_is_larger_than_its_sides():
    """Half of the longest chord is 0.5 for a triangle of side 1; its circle has 1/sqrt 3."""
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]])[:, :, None]
    assert smallest_ball(triangle)[0][0] == pytest.approx(1.0 / np.sqrt(3.0), rel=1e-14)


def test_one_point_has_no_radius():
    radii, centers = smallest_ball(np.full((4, 2, 1), 3.0))
    assert radii[0] == 0.0
    np.testing.assert_array_equal(centers[:, 0], [3.0, 3.0])


def test_many_states_of_an_ellipse():
    angle = 2.0 * np.pi * np.arange(7200) / 7200
    points = np.stack([3.0 * np.cos(angle), 2.0 * np.sin(angle)], axis=1)[:, :, None] + 5.0
    radii, centers = smallest_ball(points)
    assert radii[0] == pytest.approx(3.0, rel=1e-9)
    np.testing.assert_allclose(centers[:, 0], 5.0, rtol=1e-6)
