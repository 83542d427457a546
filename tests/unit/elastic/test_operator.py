from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.elastic import convolution, fftw
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

MATERIAL = Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6)
FULL, TANGENTIAL, NONE, NORMAL = (
    Terms(True, True, True),
    Terms(True, True, False),
    Terms(True, False, False),
    Terms(False, False, False),
)
SHAPE, SPACING = (12, 10), (0.1, 0.12)


def operator(terms=FULL, shape=SHAPE, **options):
    return ElasticOperator(shape, SPACING, MATERIAL, terms, **options)


def apply_all(elastic, tractions):
    """The displacements uz, ux, uy by pressure and shear, (3, nx, ny)."""
    displacements = np.empty_like(tractions)
    elastic.all(tractions[0], tractions[1:], displacements[0], displacements[1:])
    return displacements


@pytest.fixture
def tractions():
    return np.random.default_rng(0).normal(size=(3, *SHAPE))


def test_a_cell_under_its_own_pressure():
    uz = np.empty((1, 1))
    ElasticOperator((1, 1), (0.2, 0.2), MATERIAL, NORMAL).normal(np.ones((1, 1)), uz)
    exact = 0.2 * 4 * math.log(1 + math.sqrt(2)) / (math.pi * MATERIAL.contact_modulus)
    assert uz[0, 0] == pytest.approx(exact, rel=1e-12)


def test_self_coefficient():
    elastic, displacement, shear = operator(), np.empty((2, *SHAPE)), np.zeros((2, *SHAPE))
    shear[0, 3, 4] = 1.0
    elastic.tangential(shear, displacement)
    assert displacement[0, 3, 4] == pytest.approx(elastic.self_coefficient, rel=1e-12)


def test_in_plane_coupling_can_be_left_out(tractions):
    """Without in-plane coupling ux comes from qx alone; the rest does not change."""
    both, alone = np.empty((2, *SHAPE)), np.empty((2, *SHAPE))
    one = tractions[1:].copy()
    one[1] = 0.0
    operator(TANGENTIAL).tangential(one, both)
    operator(NONE).tangential(one, alone)
    np.testing.assert_allclose(alone[0], both[0], rtol=1e-10, atol=1e-18)
    assert not alone[1].any()
    assert both[1].any()


def test_all_without_coupling_keeps_pressure_and_shear_apart(tractions):
    uz, displacement = np.empty(SHAPE), np.empty((2, *SHAPE))
    operator(TANGENTIAL).all(tractions[0], np.zeros((2, *SHAPE)), uz, displacement)
    assert not displacement.any()
    assert uz.any()


def test_applications_are_counted(tractions):
    elastic, uz, displacement = operator(), np.empty(SHAPE), np.empty((2, *SHAPE))
    elastic.normal(tractions[0], uz)
    elastic.tangential(tractions[1:], displacement)
    elastic.tangential_from_pressure(tractions[0], displacement)
    elastic.normal_from_shear(tractions[1:], uz)
    elastic.all(tractions[0], tractions[1:], uz, displacement)
    assert elastic.applications == 5
    single = elastic.inner.dtype
    elastic.inner.normal(tractions[0].astype(single), uz.astype(single))
    assert (elastic.applications, elastic.total_applications) == (5, 6)


@pytest.mark.parametrize("terms", [TANGENTIAL, NONE])
def test_uncoupled_applications_count_once(terms, tractions):
    elastic, uz, displacement = operator(terms), np.empty(SHAPE), np.empty((2, *SHAPE))
    elastic.tangential(tractions[1:], displacement)
    elastic.all(tractions[0], tractions[1:], uz, displacement)
    assert elastic.applications == 2


def test_inputs_are_left_alone(tractions):
    before = tractions.copy()
    operator().all(tractions[0], tractions[1:], np.empty(SHAPE), np.empty((2, *SHAPE)))
    np.testing.assert_array_equal(tractions, before)


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


def test_a_part_of_a_grid_takes_the_coefficients_of_the_whole(tractions, monkeypatch):
    whole = operator(shape=(20, 15))
    parts = [operator(whole=whole), operator()]
    displacements = [apply_all(part, tractions) for part in parts]
    np.testing.assert_allclose(displacements[0], displacements[1], rtol=1e-12)
    monkeypatch.delattr("fretsolve.elastic.influence.influence_coefficients")
    smaller = operator(shape=(7, 9), whole=whole)
    uz = np.empty((7, 9))
    smaller.normal(tractions[0, :7, :9], uz)
    apply_all(whole, np.ones((3, 20, 15)))  # its own are kept, too
    assert uz.any()


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
