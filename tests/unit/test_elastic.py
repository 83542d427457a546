from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.elastic import ElasticOperator
from fretsolve.materials import Compliances
from fretsolve.terms import Terms

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


@pytest.fixture
def tractions():
    return np.random.default_rng(0).normal(size=(3, *SHAPE))


def test_a_cell_under_its_own_pressure():
    uz = np.empty((1, 1))
    ElasticOperator((1, 1), (0.2, 0.2), MATERIAL, NORMAL).normal(np.ones((1, 1)), uz)
    exact = 0.2 * 4 * math.log(1 + math.sqrt(2)) / (math.pi * MATERIAL.contact_modulus)
    assert uz[0, 0] == pytest.approx(exact, rel=1e-12)


def test_tangential_self_coefficient():
    elastic, displacement, shear = operator(), np.empty((2, *SHAPE)), np.zeros((2, *SHAPE))
    shear[0, 3, 4] = 1.0
    elastic.tangential(shear, displacement)
    assert displacement[0, 3, 4] == pytest.approx(elastic.tangential_self_coefficient, rel=1e-12)


def test_terms_that_are_left_out(tractions):
    """Without cross influence ux comes from qx alone; the rest is as it was."""
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
    elastic.normal_inverse(uz, tractions[0])
    assert elastic.applications == 5
    assert elastic.transforms == pytest.approx(1 + 2 + 1.5 + 1.5 + 3 + 1)


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


def test_the_preconditioner_is_symmetric_and_positive():
    elastic, shape = ElasticOperator((6, 5), SPACING, MATERIAL, NORMAL), (6, 5)
    columns = []
    for unit in np.eye(30):
        image = np.empty(shape)
        elastic.normal_inverse(unit.reshape(shape), image)
        columns.append(image.ravel())
    matrix = np.array(columns)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * matrix.max())
    assert np.linalg.eigvalsh(matrix).min() > 0.0


def test_the_preconditioner_nearly_inverts():
    """Of the product of both few eigenvalues lie far from 1: that is what saves iterations."""
    shape = (12, 12)
    elastic = ElasticOperator(shape, (0.1, 0.1), MATERIAL, NORMAL)
    product = []
    for unit in np.eye(144):
        uz, back = np.empty(shape), np.empty(shape)
        elastic.normal(unit.reshape(shape), uz)
        elastic.normal_inverse(uz, back)
        product.append(back.ravel())
    eigenvalues = np.linalg.eigvals(np.array(product)).real
    assert eigenvalues.min() > 0.1
    assert np.count_nonzero(np.abs(eigenvalues - 1.0) < 0.3) > 0.6 * eigenvalues.size


def test_threads_and_single_precision_give_the_same(tractions):
    plain, threaded, single = np.empty(SHAPE), np.empty(SHAPE), np.empty(SHAPE, dtype=np.float32)
    operator(NORMAL).normal(tractions[0], plain)
    operator(NORMAL, threads=2).normal(tractions[0], threaded)
    operator(NORMAL, dtype=np.float32).normal(tractions[0].astype(np.float32), single)
    np.testing.assert_allclose(threaded, plain, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(single, plain, atol=1e-5 * np.abs(plain).max())
