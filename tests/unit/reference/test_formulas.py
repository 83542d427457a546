from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad, quad
from scipy.special import ellipe, ellipk
from solving import FRICTION, HERTZ, LOAD
from solving import MATERIAL as STEEL
from solving import A as RADIUS

from fretsolve.reference.cyclic_loading import CyclicLoading
from fretsolve.reference.hertz import boussinesq_punch, hertz_elliptic, hertz_sphere, love_cone
from fretsolve.reference.tangential import (
    cattaneo_mindlin,
    full_stick_compliance,
    gross_slip_torque,
    lubkin,
    spence_stick_ratio,
)


def integral_over_disc(profile, radius, *breaks):
    """Integral of a radial profile over the disc, by substituting r = radius sin(t) (edge singularities)."""
    points = [math.asin(b / radius) for b in breaks]

    def integrand(t):
        return math.pi * radius**2 * math.sin(2 * t) * float(profile(np.array(radius * math.sin(t))))

    return quad(integrand, 0.0, math.pi / 2, points=points or None, epsabs=0.0, epsrel=1e-10, limit=200)[0]


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

    def test_pressure_bends_the_surfaces_into_contact(self):
        """The deflection 1/(pi E*) int p/r at the centre is the approach."""
        contact = hertz_elliptic(LOAD, 30.0, 10.0, STEEL.contact_modulus)
        a, b = contact.semi_axes

        def along_ray(r, angle):
            return float(contact.pressure(np.array(r * math.cos(angle)), np.array(r * math.sin(angle))))

        def reach(angle):
            return 1.0 / math.hypot(math.cos(angle) / a, math.sin(angle) / b)

        deflection, _ = dblquad(along_ray, 0.0, math.pi / 2, 0.0, reach, epsrel=1e-6)
        deflection *= 4.0 / (math.pi * STEEL.contact_modulus)
        assert deflection == pytest.approx(contact.delta_z, rel=1e-5)

    @given(st.floats(1e-3, 1e6), st.floats(1e-3, 1e6))
    def test_swapping_the_radii_swaps_the_axes(self, radius_x, radius_y):
        one = hertz_elliptic(LOAD, radius_x, radius_y, 1e5)
        other = hertz_elliptic(LOAD, radius_y, radius_x, 1e5)
        assert one.semi_axes == other.semi_axes[::-1]
        assert (one.semi_axes[0] >= one.semi_axes[1]) == (radius_x >= radius_y)
        assert one.delta_z == other.delta_z

    def test_slim_contact_is_nearly_a_line_contact(self):
        contact = hertz_elliptic(LOAD, 1e9, 10.0, STEEL.contact_modulus)
        line_load = 0.75 * LOAD / contact.semi_axes[0]  # N/mm at mid-length, where it peaks
        half_width = math.sqrt(4.0 * line_load * 10.0 / (math.pi * STEEL.contact_modulus))
        assert contact.semi_axes[1] == pytest.approx(half_width, rel=1e-3)


def unloaded(force):
    """Displacement on the way back from 36 N."""
    path = (36.0, force)
    return CyclicLoading(HERTZ, (0.0, 0.0), FRICTION, STEEL.tangential, (1.0, 0.0), path).displacements()["delta_x"]


class TestCattaneoMindlin:
    reference = cattaneo_mindlin(HERTZ, FRICTION, 36.0, STEEL.tangential)

    def test_reference_numbers(self):
        assert self.reference.stick_radius == pytest.approx(0.139761, abs=5e-7)
        assert self.reference.center_shear == pytest.approx(112.874, abs=5e-4)
        assert self.reference.delta_x == pytest.approx(0.863748e-3, abs=5e-10)
        assert self.reference.work_per_cycle == pytest.approx(1.413563e-2, abs=5e-9)

    @pytest.mark.parametrize("force", [0.0, 3.0, 36.0, -36.0, 40.0])
    def test_shear_carries_the_force_within_friction(self, force):
        contact = cattaneo_mindlin(HERTZ, FRICTION, force, STEEL.tangential)
        breaks = [contact.stick_radius] if 0.0 < contact.stick_radius < RADIUS else []
        assert integral_over_disc(contact.shear, RADIUS, *breaks) == pytest.approx(force, rel=1e-8, abs=1e-9)
        r = np.linspace(0.0, 1.2 * RADIUS, 50)
        assert np.all(np.abs(contact.shear(r)) <= FRICTION * HERTZ.pressure(r) + 1e-12)
        assert contact.shear(np.array(0.0)) == pytest.approx(contact.center_shear, abs=1e-10)

    @given(st.floats(0.01, 1.0))
    def test_work_is_that_of_the_printed_formula(self, fraction):
        work = cattaneo_mindlin(HERTZ, FRICTION, fraction * 40.0, STEEL.tangential).work_per_cycle
        rest = 1.0 - fraction
        braces = 1.0 - rest ** (5 / 3) - 5 / 6 * fraction * (1.0 + rest ** (2 / 3))
        scale = 0.9 * 40.0**2 / RADIUS * STEEL.tangential
        assert work == pytest.approx(scale * braces, rel=1e-9, abs=1e-15 * scale)

    def test_work_is_the_area_of_the_hysteresis_loop(self):
        def loop_width(force):
            return unloaded(force) + unloaded(-force)

        area, _ = quad(loop_width, -36.0, 36.0, epsabs=0.0, epsrel=1e-10)
        assert area == pytest.approx(self.reference.work_per_cycle, rel=1e-9)

    def test_unloading_goes_from_the_peak_to_its_mirror_image(self):
        assert unloaded(36.0) == self.reference.delta_x
        opposite = unloaded(-36.0)
        assert opposite == pytest.approx(-self.reference.delta_x, rel=1e-14)

    @pytest.mark.parametrize("fraction", [1e-6, 1e-12])
    def test_nothing_cancels_at_small_forces(self, fraction):
        contact = cattaneo_mindlin(HERTZ, FRICTION, fraction * 40.0, STEEL.tangential)
        scale = 0.9 * 40.0**2 / RADIUS * STEEL.tangential
        expected = 5 / 162 * fraction**3 * (1.0 + 2 / 3 * fraction)
        assert contact.work_per_cycle == pytest.approx(scale * expected, rel=1e-11)
        limit = FRICTION * HERTZ.max_pressure
        assert contact.center_shear == pytest.approx(limit * fraction / 3, rel=fraction)
        slope = full_stick_compliance(RADIUS, STEEL.tangential)
        assert contact.delta_x == pytest.approx(slope * fraction * 40.0, rel=fraction)

    def test_sliding_is_about_to_begin(self):
        contact = cattaneo_mindlin(HERTZ, FRICTION, 40.0, STEEL.tangential)
        assert contact.stick_radius == 0.0
        assert contact.delta_x == pytest.approx(1.5 * 40.0 * full_stick_compliance(RADIUS, STEEL.tangential))
        assert contact.work_per_cycle == pytest.approx(0.15 * 40.0**2 / RADIUS * STEEL.tangential, rel=1e-14)

    @given(st.floats(1e-9, 1.0))
    def test_reversing_the_force_reverses_the_displacement(self, fraction):
        forth = cattaneo_mindlin(HERTZ, FRICTION, fraction * 40.0, STEEL.tangential).delta_x
        assert cattaneo_mindlin(HERTZ, FRICTION, -fraction * 40.0, STEEL.tangential).delta_x == -forth < 0.0

    @pytest.mark.parametrize(("friction", "force"), [(0.1, 40.1), (0.1, -40.1), (0.0, 0.0)])
    def test_sliding_is_refused(self, friction, force):
        with pytest.raises(ValueError, match="must not exceed mu P"):
            cattaneo_mindlin(HERTZ, friction, force, STEEL.tangential)


class TestSpence:
    @pytest.mark.parametrize(
        ("friction", "ratio"), [(0.05, 0.0826), (0.1, 0.5102), (0.15, 0.7928), (0.2, 0.9136), (0.25, 0.9632)]
    )
    def test_reference_numbers(self, friction, ratio):
        assert spence_stick_ratio(friction, 0.1938) == pytest.approx(ratio, abs=5e-5)
        assert spence_stick_ratio(friction, -0.1938) == spence_stick_ratio(friction, 0.1938)

    def test_limits(self):
        assert spence_stick_ratio(0.0, 0.2) == 0.0
        assert spence_stick_ratio(0.3, 0.0) == 1.0
        assert spence_stick_ratio(1e9, 0.2) == 1.0

    def test_weak_friction_is_the_asymptote_without_a_jump(self):
        below, above = (spence_stick_ratio(ratio * 0.2, 0.2) for ratio in (0.04 - 1e-12, 0.04 + 1e-12))
        assert above == pytest.approx(below, rel=1e-8)
        assert below == pytest.approx(4.0 * math.exp(-25.0), rel=1e-8)

    @given(st.floats(1e-3, 10.0), st.floats(1e-2, 0.5))
    def test_more_friction_sticks_more(self, friction, beta):
        assert 0.0 <= spence_stick_ratio(friction, beta) <= spence_stick_ratio(1.1 * friction, beta) <= 1.0


class TestLubkin:
    reference = lubkin(HERTZ, FRICTION, 5.0, STEEL.torsional)

    def test_reference_numbers(self):
        assert self.reference.stick_radius == pytest.approx(0.2088, abs=5e-5)
        assert math.degrees(self.reference.phi_z) == pytest.approx(0.0831, abs=5e-5)
        assert gross_slip_torque(HERTZ, FRICTION) == pytest.approx(7.0947, abs=5e-5)

    def test_rotation_at_the_rounded_stick_radius(self):
        """1.45053e-3 rad goes with c = 0.2088 mm; the root itself is 0.208818 mm."""
        m = 1.0 - (0.2088 / RADIUS) ** 2
        rotation = 3 * FRICTION * LOAD * (ellipk(m) - ellipe(m)) / (4 * math.pi * RADIUS**2) * STEEL.torsional
        assert rotation == pytest.approx(1.45053e-3, abs=5e-9)
        slightly_more = lubkin(HERTZ, FRICTION, 5.0 + 6.1e-4, STEEL.torsional)
        assert slightly_more.stick_radius == pytest.approx(0.2088, abs=2e-6)
        assert slightly_more.phi_z == pytest.approx(rotation, rel=2e-5)

    @pytest.mark.parametrize("torque", [0.5, 5.0, -5.0, 7.09])
    def test_shear_carries_the_torque(self, torque):
        contact = lubkin(HERTZ, FRICTION, torque, STEEL.torsional)

        def moment(r):
            return r * contact.shear(r)

        assert integral_over_disc(moment, RADIUS, contact.stick_radius) == pytest.approx(torque, rel=1e-6)
        assert contact.phi_z * torque > 0.0

    def test_shear_stays_within_friction_and_vanishes_at_the_centre(self):
        r = np.linspace(0.0, 1.2 * RADIUS, 200)
        shear, bound = self.reference.shear(r), FRICTION * HERTZ.pressure(r)
        assert np.all(shear <= bound * (1 + 1e-12))
        slips = r >= self.reference.stick_radius
        np.testing.assert_array_equal(shear[slips], bound[slips])
        assert shear[0] == pytest.approx(0.0, abs=1e-11)

    @pytest.mark.parametrize("torque", [1e-6, 1e-100])
    def test_nothing_cancels_at_small_torques(self, torque):
        full_stick = 3.0 / 16.0 * torque / RADIUS**3 * STEEL.torsional
        assert lubkin(HERTZ, FRICTION, torque, STEEL.torsional).phi_z == pytest.approx(full_stick, rel=1e-6)

    def test_no_torque_no_slip(self):
        contact = lubkin(HERTZ, FRICTION, 0.0, STEEL.torsional)
        assert (contact.stick_radius, contact.phi_z) == (RADIUS, 0.0)
        assert np.all(np.abs(contact.shear(np.linspace(0.0, RADIUS, 9))) < 1e-10)

    def test_gross_slip_is_refused(self):
        with pytest.raises(ValueError, match=r"gross slip, 7\.09467 N\.mm"):
            lubkin(HERTZ, FRICTION, 7.1, STEEL.torsional)


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

    @pytest.mark.parametrize("angle", [0.0, -0.1, math.pi / 2, 2.0])
    def test_no_cone(self, angle):
        with pytest.raises(ValueError, match="between 0 and pi/2"):
            love_cone(LOAD, angle, 1e5)
