from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe, ellipk
from solving import HERTZ, LOAD, integral_over_disc
from solving import MATERIAL as STEEL
from solving import A as RADIUS

from fretsolve.reference.hertz import boussinesq_punch, hertz_elliptic, hertz_sphere, love_cone


class TestHertz:
    def test_reference_numbers(self):
        assert pytest.approx(0.301107, abs=5e-7) == RADIUS
        assert HERTZ.max_pressure == pytest.approx(2106.491, abs=5e-4)
        assert HERTZ.delta_z == pytest.approx(9.066544e-3, abs=5e-10)

    def test_pressure_carries_the_load(self):
        assert integral_over_disc(HERTZ.pressure, RADIUS) == pytest.approx(LOAD, rel=1e-9)
        assert HERTZ.pressure(np.array([0.0, 1.0])).tolist() == [HERTZ.max_pressure, 0.0]

    @pytest.mark.parametrize("arguments", [(0.0, 10.0, 1e5), (400.0, -10.0, 1e5), (400.0, 10.0, 0.0)])
    def test_what_makes_no_contact_is_refused(self, arguments):
        with pytest.raises(ValueError, match="must be positive"):
            hertz_sphere(*arguments)


class TestEllipticHertz:
    @pytest.mark.parametrize("ratio", [1.0, 1.0 + 1e-13, 1.0 + 1e-9])
    def test_equal_radii_are_a_sphere(self, ratio):
        contact = hertz_elliptic(LOAD, 10.0 * ratio, 10.0, STEEL.contact_modulus)
        assert contact.semi_axes[0] == pytest.approx(RADIUS, rel=1e-8)
        assert contact.semi_axes[1] == pytest.approx(RADIUS, rel=1e-8)
        assert contact.max_pressure == pytest.approx(HERTZ.max_pressure, rel=1e-8)
        assert contact.delta_z == pytest.approx(HERTZ.delta_z, rel=1e-8)

    @pytest.mark.parametrize("ratio", [1.3, 4.0, 50.0, 1e4])
    def test_curvatures_follow_from_the_textbook_integrals(self, ratio):
        modulus = STEEL.contact_modulus
        contact = hertz_elliptic(LOAD, 10.0 * ratio, 10.0, modulus)
        a, b, p0 = *contact.semi_axes, contact.max_pressure
        m = (1.0 - b / a) * (1.0 + b / a)
        K, E = ellipk(m), ellipe(m)
        scale = p0 / modulus * b / (m * a * a)
        assert scale * (K - E) == pytest.approx(1 / (20.0 * ratio), rel=1e-10)
        assert scale * ((a / b) ** 2 * E - K) == pytest.approx(1 / 20.0, rel=1e-10)
        assert contact.delta_z == pytest.approx(p0 * b * K / modulus, rel=1e-12)
        assert 2 / 3 * math.pi * a * b * p0 == pytest.approx(LOAD, rel=1e-14)

    def test_slim_contact_is_nearly_a_line_contact(self):
        contact = hertz_elliptic(LOAD, 1e9, 10.0, STEEL.contact_modulus)
        line_load = 0.75 * LOAD / contact.semi_axes[0]  # N/mm at mid-length, where it peaks
        half_width = math.sqrt(4.0 * line_load * 10.0 / (math.pi * STEEL.contact_modulus))
        assert contact.semi_axes[1] == pytest.approx(half_width, rel=1e-3)


class TestPunchAndCone:
    def test_flat_punch(self):
        punch = boussinesq_punch(LOAD, 0.5, 1e5)
        assert punch.delta_z == pytest.approx(4e-3)
        assert integral_over_disc(punch.pressure, 0.5) == pytest.approx(LOAD, rel=1e-8)
        expected = [LOAD / (2 * math.pi * 0.25), math.inf, 0.0]
        assert punch.pressure(np.array([0.0, 0.5, 0.6])).tolist() == expected

    def test_cone(self):
        cone = love_cone(LOAD, math.radians(2.0), 1e5)
        assert integral_over_disc(cone.pressure, cone.contact_radius) == pytest.approx(LOAD, rel=1e-8)
        assert cone.contact_radius * cone.delta_z * 1e5 == pytest.approx(LOAD, rel=1e-12)
        assert cone.pressure(np.array([0.0, cone.contact_radius, 9.0])).tolist() == [math.inf, 0.0, 0.0]

    def test_deflection_at_the_centre_is_the_approach(self):
        """(2/E*) int p dr along the radius: Boussinesq's point solution over an axisymmetric pressure."""
        cone = love_cone(LOAD, math.radians(2.0), 1e5)
        punch = boussinesq_punch(LOAD, 0.5, 1e5)
        for contact in (cone, punch, hertz_sphere(LOAD, 10.0, 1e5)):
            a = contact.contact_radius

            def integrand(t, a=a, contact=contact):
                return a * math.cos(t) * float(contact.pressure(np.array(a * math.sin(t))))

            integral, _ = quad(integrand, 0.0, math.pi / 2)
            assert 2.0 / 1e5 * integral == pytest.approx(contact.delta_z, rel=1e-7)
