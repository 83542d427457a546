"""Elliptic integrals, moduli and roots are those of SciPy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe, ellipkm1, elliprd

from fretsolve.reference.hertz import complete_integral, modulus


@pytest.mark.parametrize("complement", [1e-150, 1e-20, 1e-6, 0.1, 0.5, 0.99, 1.0 - 1e-12, 1.0])
def test_integrals_are_those_of_scipy(complement: float) -> None:
    square = complement**2
    assert complete_integral(complement) == pytest.approx(float(ellipkm1(square)), rel=1e-14)
    assert complete_integral(complement, 1.0, square) == pytest.approx(float(ellipe(1.0 - square)), rel=1e-14)
    # Carlson's R_D are 3 D and 3 B/k'^2; they overflow in SciPy for the first modulus
    assert complete_integral(complement, cosine=0.0) == pytest.approx(float(elliprd(0.0, square, 1.0)) / 3.0, rel=1e-14)
    if complement > 1e-100:
        by_carlson = float(elliprd(0.0, 1.0, square)) * square / 3.0
        assert complete_integral(complement, sine=0.0) == pytest.approx(by_carlson, rel=1e-14)


@given(st.floats(0.05, 20.0))
def test_modulus_has_the_ratio_of_integrals(ratio: float) -> None:
    k = modulus(ratio)
    complement = math.sqrt((1.0 - k) * (1.0 + k)) if ratio < 1.0 else modulus(1.0 / ratio)
    assert float(ellipkm1(complement**2) / ellipkm1(k**2)) == pytest.approx(ratio, rel=1e-12)
    assert k**2 + modulus(1.0 / ratio) ** 2 == pytest.approx(1.0, abs=1e-14)


def test_modulus_at_its_limits() -> None:
    assert modulus(1.0) == pytest.approx(math.sqrt(0.5), rel=1e-15)
    assert modulus(0.02) == pytest.approx(4.0 * math.exp(-25.0 * math.pi), rel=1e-13)  # K(k) = pi/2, K(k') = ln(4/k)
    assert modulus(1e-6) == 0.0
    assert modulus(1e6) == 1.0
