"""Invariants of stresses, means over blocks of cells, and the bounds of the largest stress on them."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.post.names import INVARIANTS
from fretsolve.post.stress.edge import in_blocks, merged, rises
from fretsolve.post.stress.invariants import invariant, largest, principal, von_mises
from fretsolve.post.stress.peaks import SurfaceBounds


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


def test_blocks_that_fit() -> None:
    field = np.arange(24.0).reshape(4, 6)
    means = in_blocks(field, (2, 3), (0, 0), (2, 2))
    assert means.tolist() == [[4.0, 7.0], [16.0, 19.0]]
    # cells past the field count as 0
    assert in_blocks(np.ones((3, 2)), (2, 2), (1, 0), (2, 1)).tolist() == [[0.5], [1.0]]


def test_blocks_of_a_window_cover_it() -> None:
    assert merged((slice(3, 8), slice(0, 5)), (2, 5)) == (slice(1, 4), slice(0, 1))


def test_largest_bound_away_from_a_place() -> None:
    bounds = SurfaceBounds(np.array([9.0, 7.0, 5.0]), np.array([[0.0, 2.0, 9.0], [0.0, 0.0, 3.0]]), 0.5)
    here = np.array([0.0, 0.0])
    assert bounds.most() == 9.0
    assert [bounds.most(here, distance) for distance in (1.0, 2.0, 9.0)] == [7.0, 5.0, -np.inf]


def test_a_trailing_edge_rises_and_a_leading_one_does_not():
    """Columns: tension that grows with smaller cells, compression that grows, tension whose other parts change more."""
    values = np.array([[100.0, 0.0, 100.0], [0.0, -90.0, 0.0], [0.0, -300.0, 0.0]])
    change = np.array([[20.0, 40.0, 1.0], [5.0, -20.0, 0.0], [0.0, -60.0, 30.0]])
    np.testing.assert_allclose(rises(values, change), [20.0, 0.0, 0.0])
