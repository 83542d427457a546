from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.problem.model.materials import Compliances, compliances


def body(young_modulus, poisson_ratio):
    return ElasticBody(young_modulus=young_modulus, poisson_ratio=poisson_ratio)


SIMILAR = body(200e3, 0.3)
bodies = st.builds(body, st.floats(1e-2, 1e6), st.floats(-0.9, 0.5))
ordinary_bodies = st.builds(body, st.floats(1.0, 1e6), st.floats(0.0, 0.5))


def test_similar_bodies():
    pair = compliances(SIMILAR, SIMILAR)
    shear_modulus = 200e3 / 2.6
    assert pytest.approx(1.4 / shear_modulus, rel=1e-15) == pair.A
    assert pytest.approx(0.6 / shear_modulus, rel=1e-15) == pair.B
    assert pair.C == 0.0
    assert pair.dundurs_constant == 0.0
    assert pair.tangential == pytest.approx(3.4 / shear_modulus, rel=1e-15)
    assert pair.torsional == pytest.approx(2.0 / shear_modulus, rel=1e-15)


def test_dissimilar_reference_pair_has_the_same_contact_modulus():
    pair = compliances(body(200e3, 0.06), body(200e3, 0.42))
    assert pair.dundurs_constant == pytest.approx(0.1938, abs=5e-5)
    assert pair.contact_modulus == pytest.approx(compliances(SIMILAR, SIMILAR).contact_modulus, rel=1e-14)


@given(bodies, bodies)
def test_contact_modulus_is_the_textbook_sum(one, two):
    compliance = sum((1 - b.poisson_ratio**2) / b.young_modulus for b in (one, two))
    assert compliances(one, two).contact_modulus == pytest.approx(1 / compliance, rel=1e-12)


@given(ordinary_bodies, ordinary_bodies)
def test_dundurs_constant_is_bounded_and_changes_sign_with_the_bodies(one, two):
    pair, swapped = compliances(one, two), compliances(two, one)
    assert abs(pair.dundurs_constant) <= 0.5
    assert swapped == Compliances(pair.A, pair.B, -pair.C)


def test_rigid_body_adds_nothing():
    alone = compliances(None, SIMILAR)
    assert alone.contact_modulus == pytest.approx(200e3 / (1 - 0.09), rel=1e-15)
    assert alone.dundurs_constant == pytest.approx(-0.4 / (2 * 0.7), rel=1e-15)
    assert compliances(SIMILAR, None).C == -alone.C > 0


def test_two_rigid_bodies_do_not_yield():
    pair = compliances(None, None)
    assert pair == Compliances(0.0, 0.0, 0.0)
    assert pair.contact_modulus == math.inf
    assert pair.dundurs_constant == 0.0
