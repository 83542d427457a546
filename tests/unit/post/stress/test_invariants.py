"""Invariants of stresses."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.case.keys.quantity_names import INVARIANTS
from fretsolve.post.stress.invariants import invariant, largest, principal, von_mises


def tensors(stress):
    xx, yy, zz, xy, xz, yz = stress
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), (0, 1), (-2, -1))


@pytest.fixture
def stress():
    return np.random.default_rng(3).normal(size=(6, 20, 17))


def test_principal_stresses_are_eigenvalues(stress):
    exact = np.linalg.eigvalsh(tensors(stress))[..., ::-1]
    np.testing.assert_allclose(np.moveaxis(principal(stress), 0, -1), exact, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    "values", [(1, 1, 1, 0, 0, 0), (0, 0, 0, 0, 0, 0), (2, 1, 1, 0, 0, 0), (2, 2, -1, 0, 0, 0), (0, 0, 0, 1, 0, 0)]
)
def test_equal_principal_stresses(values):
    stress = np.array(values, float)[:, None]
    exact = np.linalg.eigvalsh(tensors(stress))[..., ::-1]
    np.testing.assert_allclose(principal(stress).T, exact, rtol=0, atol=3e-8)


def test_known_states():
    """Uniaxial tension s: von Mises s, tension s, largest shear s/2. Pure shear t: sqrt 3 t, t, t."""
    uniaxial, shear = np.array([5.0, 0, 0, 0, 0, 0]), np.array([0, 0, 0, 0, 2.0, 0])
    for stress, exact in ((uniaxial, (5.0, 5.0, 2.5)), (shear, (2.0 * np.sqrt(3.0), 2.0, 2.0))):
        found = [float(invariant(name, stress[:, None])[0]) for name in INVARIANTS]
        assert found == pytest.approx(exact, rel=1e-14)


def test_the_largest_values_are_those_of_all_cells(stress):
    for scale in (1.0, -1.0, 0.0):
        shifted = scale * stress
        shifted[:3] += 0.7
        for name, (value, cell) in largest(shifted).items():
            everywhere = invariant(name, shifted)
            assert value == pytest.approx(everywhere.max(), rel=1e-14)
            assert everywhere[cell] == pytest.approx(value, rel=1e-14)
    assert von_mises(np.zeros((6, 1))) == 0.0
