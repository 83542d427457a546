"""Planes and the stresses on them, and the smallest ball around points, against all subsets of them."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from fretsolve.post.fatigue.criteria import deviator_vectors, extreme_deviators, hydrostatic
from fretsolve.post.fatigue.planes import in_plane_axes, scan_normals, smallest_ball, traction_rows, upright

ROWS = ((0, 3, 4), (3, 1, 5), (4, 5, 2))


@pytest.mark.parametrize("step", [5.0, 10.0, 15.0])
def test_every_direction_is_near_a_plane_of_the_scan(step):
    directions = np.random.default_rng(3).normal(size=(5000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    nearest = np.degrees(np.arccos(np.clip(np.abs(directions @ scan_normals(step).T).max(axis=1), 0.0, 1.0)))
    assert nearest.max() < 0.75 * step


def test_no_plane_is_scanned_twice():
    normals = scan_normals(10.0)
    assert len(normals) == 206
    alike = np.abs(normals @ normals.T) - np.eye(len(normals))
    assert alike.max() < np.cos(np.radians(5.0))


def test_rows_give_tractions_on_planes():
    random = np.random.default_rng(1)
    stress = random.normal(size=6)
    normals = random.normal(size=(7, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    traction = normals @ stress[np.array(ROWS)]
    frame = np.stack([normals, *in_plane_axes(normals)], axis=1)
    np.testing.assert_allclose(frame @ frame.swapaxes(1, 2), np.broadcast_to(np.eye(3), frame.shape), atol=1e-14)
    for along in frame.swapaxes(0, 1):
        np.testing.assert_allclose(traction_rows(along, normals) @ stress, (traction * along).sum(axis=1), atol=1e-14)


def test_upright_normals():
    turned = upright(np.array([[0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [-1.0, 0.0, 0.0], [0.6, -0.8, 1e-17]]))
    np.testing.assert_allclose(turned, [[0, 0, 1], [-0.6, 0, 0.8], [1, 0, 0], [-0.6, 0.8, 0]], atol=1e-15)


def test_invariants_of_stresses():
    stress = np.random.default_rng(2).normal(size=(4, 6, 50))
    stress[0, :, 0] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    principal = np.linalg.eigvalsh(np.moveaxis(stress[:, np.array(ROWS)], 3, 1))
    mean = hydrostatic(stress)
    np.testing.assert_allclose(mean, principal.mean(axis=2), atol=1e-14)
    vectors = deviator_vectors(stress)
    J2 = 0.5 * np.square(principal - mean[..., None]).sum(axis=2)
    np.testing.assert_allclose(np.square(vectors).sum(axis=1), J2, atol=1e-13)
    largest, smallest = extreme_deviators(vectors)
    np.testing.assert_allclose(largest, principal[..., 2] - mean, atol=1e-7)
    np.testing.assert_allclose(smallest, principal[..., 0] - mean, atol=1e-7)


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
