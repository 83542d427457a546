"""Planes and the stresses on them."""

import numpy as np
import pytest

from fretsolve.fatigue.criteria import deviator_vectors, extreme_deviators, hydrostatic
from fretsolve.fatigue.planes import in_plane_axes, scan_normals, traction_rows, upright

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
    for along in (normals, *in_plane_axes(normals)):
        np.testing.assert_allclose(traction_rows(along, normals) @ stress, (traction * along).sum(axis=1), atol=1e-14)


def test_in_plane_axes_are_at_right_angles():
    normals = scan_normals(15.0)
    first, second = in_plane_axes(normals)
    frame = np.stack([normals, first, second], axis=1)
    np.testing.assert_allclose(frame @ frame.swapaxes(1, 2), np.broadcast_to(np.eye(3), frame.shape), atol=1e-14)


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
