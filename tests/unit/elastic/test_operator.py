from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic import convolution, fftw
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

MATERIAL = Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6)
FULL, TANGENTIAL, NONE = Terms(True, True, True), Terms(True, True, False), Terms(True, False, False)
SHAPE, SPACING = (12, 10), (0.1, 0.12)


def operator(terms=FULL, shape=SHAPE, **options):
    return ElasticOperator(shape, SPACING, MATERIAL, terms, **options)


@pytest.fixture
def tractions():
    return np.random.default_rng(0).normal(size=(3, *SHAPE))


def test_the_inner_operator_is_the_same_in_its_units(tractions):
    elastic, displacement = operator(), np.empty((2, *SHAPE))
    inner = elastic.inner
    elastic.tangential(tractions[1:], displacement)
    found = np.empty((2, *SHAPE), inner.dtype)
    inner.tangential(tractions[1:].astype(inner.dtype), found)
    np.testing.assert_allclose(found * elastic.unit, displacement, atol=2e-6 * np.abs(displacement).max())


def test_x_and_y_change_places_on_a_square_grid():
    """The spectrum of uy from qy is taken from that of ux from qx there."""
    elastic = ElasticOperator((8, 8), (0.1, 0.1), MATERIAL, TANGENTIAL)
    oblong = ElasticOperator((8, 8), (0.1, 0.1 * (1 + 1e-13)), MATERIAL, TANGENTIAL)
    shear = np.random.default_rng(1).normal(size=(2, 8, 8))
    displacement, other = np.empty((2, 8, 8)), np.empty((2, 8, 8))
    elastic.tangential(shear, displacement)
    oblong.tangential(shear, other)
    np.testing.assert_allclose(displacement, other, atol=1e-11 * np.abs(other).max())


@pytest.mark.parametrize("terms", [NONE, TANGENTIAL, FULL])
def test_threads_change_no_bit(tractions, terms, monkeypatch):
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", 0)
    monkeypatch.setattr(fftw, "CACHE_BYTES", 2048)  # blocks enough to share out
    found = []
    for team in (ThreadTeam(1), ThreadTeam(2), ThreadTeam(5)):
        displacement = np.empty((3, *SHAPE))
        operator(terms, team=team).all(tractions[0], tractions[1:], displacement[0], displacement[1:])
        found.append(displacement)
    np.testing.assert_array_equal(found[1], found[0])
    np.testing.assert_array_equal(found[2], found[0])
