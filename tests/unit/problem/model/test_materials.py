from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.problem.model.materials import Compliances, compliances


def body(young_modulus, poisson_ratio):
    return ElasticBody(young_modulus=young_modulus, poisson_ratio=poisson_ratio)


SIMILAR = body(200e3, 0.3)
ordinary_bodies = st.builds(body, st.floats(1.0, 1e6), st.floats(0.0, 0.5))


def test_dissimilar_reference_pair_has_the_same_contact_modulus():
    pair = compliances(body(200e3, 0.06), body(200e3, 0.42))
    assert pair.dundurs_constant == pytest.approx(0.1938, abs=5e-5)
    assert pair.contact_modulus == pytest.approx(compliances(SIMILAR, SIMILAR).contact_modulus, rel=1e-14)


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
