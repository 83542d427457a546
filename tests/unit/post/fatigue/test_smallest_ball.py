"""The smallest ball around points, against all subsets of the points."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from fretsolve.post.fatigue.planes import smallest_ball


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
