from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.operator import ElasticOperator, Preconditioner
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

MATERIAL = Compliances(A=1.1e-5, B=3.4e-6, C=0.0)


def inverse(shape, spacing=(0.1, 0.12), in_plane_coupling=True, factor=1.0, dtype=np.float64):
    return Preconditioner(shape, spacing, MATERIAL, Terms(True, in_plane_coupling, False), factor, dtype=dtype)


def matrix(apply, components, shape):
    """The linear map as a matrix, from its images of unit fields."""
    columns = []
    for unit in np.eye(components * shape[0] * shape[1]):
        image = np.empty((components, *shape))
        apply(unit.reshape((components, *shape)), image)
        columns.append(image.ravel())
    return np.array(columns).T


@pytest.mark.parametrize("shape", [(6, 5), (7, 8), (1, 9)])
@pytest.mark.parametrize("in_plane_coupling", [True, False])
def test_symmetric_and_positive(shape, in_plane_coupling):
    made = inverse(shape, in_plane_coupling=in_plane_coupling)
    for apply, components in ((made.normal, 1), (made.tangential, 2)):
        found = matrix(apply, components, shape)
        np.testing.assert_allclose(found, found.T, atol=1e-12 * found.max())
        assert np.linalg.eigvalsh(found).min() > 0.0


@pytest.mark.parametrize("components", [1, 2])
def test_it_nearly_inverts(components):
    """Few eigenvalues of the product lie far from 1: that saves iterations."""
    shape, spacing = (12, 12), (0.1, 0.1)
    elastic = ElasticOperator(shape, spacing, MATERIAL, Terms(True, True, False))
    made = inverse(shape, spacing)
    if components == 1:
        there = matrix(lambda field, out: elastic.normal(field[0], out[0]), 1, shape)
        back = matrix(made.normal, 1, shape)
    else:
        there, back = matrix(elastic.tangential, 2, shape), matrix(made.tangential, 2, shape)
    eigenvalues = np.linalg.eigvals(back @ there).real
    assert eigenvalues.min() > 0.1
    assert np.count_nonzero(np.abs(eigenvalues - 1.0) < 0.3) > 0.6 * eigenvalues.size
