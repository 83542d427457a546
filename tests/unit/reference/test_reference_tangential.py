from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from solving import FRICTION, HERTZ, integral_over_disc
from solving import MATERIAL as STEEL
from solving import A as RADIUS

from fretsolve.reference.cyclic_loading import CyclicLoading
from fretsolve.reference.tangential import (
    cattaneo_mindlin,
    full_stick_compliance,
    gross_slip_torque,
    lubkin,
    spence_stick_ratio,
)


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

    @pytest.mark.parametrize("force", [3.0, -36.0, 40.0])
    def test_slip_times_friction_is_the_work(self, force):
        """In a cycle each place slips four times what it slips on first loading."""
        contact = cattaneo_mindlin(HERTZ, FRICTION, force, STEEL.tangential)
        breaks = [contact.stick_radius] if contact.stick_radius > 0.0 else []
        energy = integral_over_disc(lambda r: contact.slip(r) * FRICTION * HERTZ.pressure(r), RADIUS, *breaks)
        assert 4.0 * energy == pytest.approx(contact.work_per_cycle, rel=1e-7)
        assert contact.slip(np.array([0.0, 0.5 * contact.stick_radius])).tolist() == [0.0, 0.0]

    def test_work_is_the_area_of_the_hysteresis_loop(self):
        def loop_width(force):
            return unloaded(force) + unloaded(-force)

        area, _ = quad(loop_width, -36.0, 36.0, epsabs=0.0, epsrel=1e-10)
        assert area == pytest.approx(self.reference.work_per_cycle, rel=1e-9)

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


class TestLubkin:
    reference = lubkin(HERTZ, FRICTION, 5.0, STEEL.torsional)

    def test_reference_numbers(self):
        assert self.reference.stick_radius == pytest.approx(0.2088, abs=5e-5)
        assert math.degrees(self.reference.phi_z) == pytest.approx(0.0831, abs=5e-5)
        assert gross_slip_torque(HERTZ, FRICTION) == pytest.approx(7.0947, abs=5e-5)

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

    def test_gross_slip_is_refused(self):
        with pytest.raises(ValueError, match=r"gross slip, 7\.09467 N mm"):
            lubkin(HERTZ, FRICTION, 7.1, STEEL.torsional)
