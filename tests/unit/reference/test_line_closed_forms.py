"""Closed forms of line contacts: values certified by independent code, and the integrals that they come from."""

from __future__ import annotations

import numpy as np
import pytest
from line_cases import CATTANEO, FRICTION, HERTZ, MATERIAL, PUNCH
from scipy.integrate import quad

from fretsolve.problem.model.increment_grading import LINE
from fretsolve.reference.hertz import HertzLine, RoundedPunch, pressed_stick_ratio
from fretsolve.reference.line_slip import LinePartialSlip


def at(function, x):
    return float(function(np.array([x]))[0])


def test_cylinder():
    assert HERTZ.half_width == pytest.approx(0.1076405, abs=5e-8)
    assert HERTZ.max_pressure == pytest.approx(591.4314, abs=5e-5)
    assert 2.0 * quad(lambda x: at(HERTZ.pressure, x), 0.0, HERTZ.half_width)[0] == pytest.approx(100.0, rel=1e-8)
    assert at(HERTZ.pressure, 1.01 * HERTZ.half_width) == 0.0


def test_partial_slip_of_a_cylinder():
    assert CATTANEO.stick_half_width == pytest.approx(0.0680778, abs=5e-8)
    assert CATTANEO.stick_half_width / HERTZ.half_width == pytest.approx(float(LINE.stick_ratio(np.array(0.6))))
    assert at(CATTANEO.shear, 0.0) == pytest.approx(65.2132, abs=5e-5)
    assert at(CATTANEO.slip, HERTZ.half_width) == pytest.approx(6.28988e-5, rel=1e-6)
    assert CATTANEO.work_per_cycle == pytest.approx(5.57719e-4, rel=1e-6)
    total = quad(lambda x: at(CATTANEO.shear, x), 0.0, HERTZ.half_width, points=[CATTANEO.stick_half_width])[0]
    assert 2.0 * total == pytest.approx(18.0, rel=1e-7)
    density = [FRICTION * at(HERTZ.pressure, x) * at(CATTANEO.slip, x) for x in (0.08, 0.1)]
    assert min(density) > 0.0


def test_work_is_the_integral_of_the_slip():
    a, c = HERTZ.half_width, CATTANEO.stick_half_width
    found = quad(lambda x: FRICTION * at(HERTZ.pressure, x) * at(CATTANEO.slip, x), c, a, epsabs=0.0)[0]
    assert CATTANEO.work_per_cycle == pytest.approx(8.0 * found, rel=1e-8)


def test_slip_is_that_of_the_shear_traction():
    """The displacement of the shear, -(A/pi) times the integral of q ln|x - t|, is level but for the slip."""
    a, c = HERTZ.half_width, CATTANEO.stick_half_width

    def moved(x):
        def change(t):  # towards that of the middle, whose singularities are weak
            return at(CATTANEO.shear, t) * (np.log(abs(x - t)) - np.log(abs(t)))

        points = sorted({-c, c, 0.0, x})
        return -MATERIAL.A / np.pi * quad(change, -a, a, points=points, limit=400)[0]

    assert abs(moved(0.5 * c)) < 1e-10
    for x in (0.75 * a, 0.9 * a):
        assert -moved(x) == pytest.approx(at(CATTANEO.slip, x), rel=1e-5)


def test_rounded_punch():
    assert PUNCH.half_width == pytest.approx(0.8666692, abs=5e-8)
    assert at(PUNCH.pressure, 0.0) == pytest.approx(89.13927, abs=1e-5)
    assert at(PUNCH.pressure, 0.25) == pytest.approx(95.65080, abs=1e-5)
    assert at(PUNCH.pressure, 0.60313) == pytest.approx(163.5155, abs=1e-4)
    assert PUNCH.max_pressure == pytest.approx(163.5155, abs=1e-4)
    assert at(PUNCH.pressure, 0.5) == pytest.approx(at(PUNCH.pressure, 0.5 + 1e-9), rel=1e-6)
    total = quad(lambda x: at(PUNCH.pressure, x), 0.0, PUNCH.half_width, points=[0.5], limit=200)[0]
    assert 2.0 * total == pytest.approx(200.0, rel=1e-8)


def test_shear_of_a_rounded_punch():
    shear = LinePartialSlip(PUNCH, 0.3, 36.0, MATERIAL.A)
    assert shear.stick_half_width == pytest.approx(0.7097077, abs=5e-8)
    assert at(shear.shear, 0.0) == pytest.approx(14.49338, abs=1e-5)


@pytest.mark.parametrize("flat", [1e-6, 1e-3])
def test_a_punch_of_a_narrow_flat_is_a_cylinder(flat):
    punch = RoundedPunch(100.0, flat, 10.0, MATERIAL.contact_modulus)
    assert punch.half_width == pytest.approx(HERTZ.half_width, rel=20.0 * flat)
    assert at(punch.pressure, 0.05) == pytest.approx(at(HERTZ.pressure, 0.05), rel=20.0 * flat)


@pytest.mark.parametrize(
    ("friction", "ratio"), [(0.05, 0.00906), (0.1, 0.18869), (0.15, 0.49120), (0.2, 0.73086), (0.25, 0.87005)]
)
def test_stick_ratio_of_dissimilar_bodies(friction, ratio):
    assert pressed_stick_ratio(friction, 0.1938462) == pytest.approx(ratio, abs=5e-6)
    assert pressed_stick_ratio(friction, -0.1938462) == pressed_stick_ratio(friction, 0.1938462)


def test_stick_ratio_at_its_limits():
    assert pressed_stick_ratio(0.3, 0.0) == 1.0
    assert pressed_stick_ratio(0.0, 0.1) == 0.0
    assert 0.0 < pressed_stick_ratio(1e-3, 0.2) < 1e-100
    assert pressed_stick_ratio(50.0, 0.2) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: HertzLine(0.0, 10.0, 1e5),
        lambda: RoundedPunch(100.0, -1.0, 10.0, 1e5),
        lambda: LinePartialSlip(HERTZ, FRICTION, 30.0, MATERIAL.A),
    ],
)
def test_what_is_out_of_range_is_refused(make):
    with pytest.raises(ValueError, match="must be"):
        make()
