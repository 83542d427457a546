"""Elliptic integrals, moduli and roots are those of SciPy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1, elliprd

from fretsolve.reference.elliptic import complete_integral, growing_root, modulus
from fretsolve.reference.hertz import hertz_elliptic
from fretsolve.reference.line import RoundedPunch
from fretsolve.reference.tangential import spence_stick_ratio


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


def test_integral_is_the_one_that_it_states() -> None:
    value, _ = quad(
        lambda f: (0.3 * math.cos(f) ** 2 + 2.0 * math.sin(f) ** 2) / math.hypot(math.cos(f), 0.2 * math.sin(f)),
        0.0,
        math.pi / 2,
    )
    assert complete_integral(0.2, 0.3, 2.0) == pytest.approx(value, rel=1e-12)


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


def test_root_is_that_of_brent() -> None:
    for wanted in (-1.0, 0.3, 7.0):
        expected = brentq(lambda x, wanted=wanted: math.sinh(x) - wanted, -2.0, 5.0, xtol=1e-15, rtol=1e-15)
        assert growing_root(lambda x, wanted=wanted: math.sinh(x) - wanted, -2.0, 5.0) == pytest.approx(
            expected, abs=1e-15
        )
    assert growing_root(lambda x: x - 1.0, 0.0, 1.0) == 1.0
    assert growing_root(lambda x: x, 0.0, 1.0) == pytest.approx(0.0, abs=1e-17)


@pytest.mark.parametrize("ratio", [0.041, 0.1, 0.5, 1.0, 2.0, 10.0, 1e3])
def test_spence_as_solved_by_scipy(ratio: float) -> None:
    def mismatch(log_v: float) -> float:
        v = math.exp(log_v)
        return v / math.tanh(v) - ratio * float(ellipkm1(math.tanh(v) ** 2))

    log_v = brentq(mismatch, -25.4, max(1.0, math.log(2.0 * ratio)), xtol=1e-15, rtol=1e-15)
    assert spence_stick_ratio(0.3 * ratio, 0.3) == pytest.approx(math.tanh(math.exp(log_v)), rel=1e-12)


@pytest.mark.parametrize("radii", [(10.0, 10.0 + 1e-9), (10.0, 12.0), (1.0, 50.0), (1.0, 1e8)])
def test_ellipse_as_solved_by_scipy(radii: tuple[float, float]) -> None:
    def mismatch(log_ratio: float) -> float:
        square = math.exp(2.0 * log_ratio)
        return math.log(elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0)) - math.log(radii[1] / radii[0])

    ratio = math.exp(brentq(mismatch, math.log(radii[0] / radii[1]), 0.0, xtol=1e-15, rtol=1e-15))
    a = math.cbrt(400.0 * radii[1] * elliprd(0.0, ratio**2, 1.0) / (math.pi * 1e5))
    found = hertz_elliptic(400.0, *radii, 1e5)
    assert found.semi_axes == pytest.approx((ratio * a, a), rel=1e-12)
    approach = 1.5 * 400.0 / (math.pi * a) / 1e5 * float(ellipkm1(ratio**2))
    assert found.delta_z == pytest.approx(approach, rel=1e-12)


@pytest.mark.parametrize("load", [1e-6, 1.0, 1e3, 1e9])
def test_rounded_punch_as_solved_by_scipy(load: float) -> None:
    wanted = 4.0 * load * 20.0 / (1e5 * 0.5**2)

    def excess(g: float) -> float:
        return 2.0 * g - math.sin(2.0 * g) - wanted * math.cos(g) ** 2

    g = brentq(excess, 1e-4, 0.5 * math.pi, xtol=1e-15, rtol=1e-15)
    # The sine of this form, unlike that of the punch, cancels at small loads.
    assert RoundedPunch(load, 0.5, 20.0, 1e5).edge_angle == pytest.approx(
        0.5 * math.pi - g, abs=1e-12 if wanted > 1.0 else 1e-8
    )
