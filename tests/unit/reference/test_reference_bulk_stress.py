"""Closed forms under bulk stress against certified values, quadrature of the integral equations, and each other."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from solving import FRICTION, HERTZ, MATERIAL, A

from fretsolve.reference.hertz import HertzLine
from fretsolve.reference.line_slip import LinePartialSlip, line_stick_ratio_under_bulk_alone
from fretsolve.reference.tangential import SphereUnderBulk

# E = 200 GPa, nu = 0.3, R = 10 mm, P = 100 N/mm, mu = 0.3
BASE = HertzLine(100.0, 10.0, 2.0 / 1.82e-5)


def line(f: float, b: float) -> LinePartialSlip:
    return LinePartialSlip(BASE, 0.3, f * 0.3 * 100.0, 1.82e-5, b * 1.82e-5 * 0.3 * BASE.max_pressure)


class TestLine:
    @pytest.mark.parametrize(
        ("f", "b", "low", "high"),
        [(0.6, 0.1, -0.53246, 0.73246), (0.9, 0.2, -0.11623, 0.51623), (0.3, 0.2, -0.63703, 0.96948)],
    )
    def test_certified_stick_zones(self, f, b, low, high):
        assert np.array(line(f, b).stick_zone) / BASE.half_width == pytest.approx([low, high], abs=5e-6)
        assert line(f, b).reverses == (f == 0.3)

    @pytest.mark.parametrize(
        ("b", "ratio"),
        [(0.02, 0.980100), (0.05, 0.950633), (0.1, 0.902562), (0.2, 0.810483), (0.5, 0.569321), (1.0, 0.289359)],
    )
    def test_certified_stick_zone_under_bulk_alone(self, b, ratio):
        assert line_stick_ratio_under_bulk_alone(b) == pytest.approx(ratio, abs=6e-7)
        assert np.array(line(0.0, b).stick_zone) / BASE.half_width == pytest.approx([-ratio, ratio], abs=6e-7)

    @pytest.mark.parametrize(("b", "work"), [(0.0, 5.57719e-4), (0.1, 6.82853e-4), (0.2, 1.05826e-3)])
    def test_certified_work_per_cycle(self, b, work):
        assert line(0.6, b).work_per_cycle == pytest.approx(work, rel=5e-6)
        assert line(0.6, -b).work_per_cycle == pytest.approx(work, rel=5e-6)

    @pytest.mark.parametrize("f", [0.01, 0.3, 0.7, 0.99])
    @pytest.mark.parametrize("excess", [1e-6, 0.01, 0.3, 1.0, 2.0])
    def test_reversed_slip_solves_its_integral_equations(self, f, excess):
        """By quadrature with algebraic weights, another way than that of the solution."""
        b = 1.0 - math.sqrt(1.0 - f) + excess
        contact = line(f, b)
        low, high = np.array(contact.stick_zone) / BASE.half_width
        assert -1.0 < low < high < 1.0

        def both(factor):
            right = quad(
                lambda x: -factor(x) * math.sqrt((1 + x) / (x - low)), high, 1.0, weight="alg", wvar=(-0.5, 0.5)
            )
            left = quad(
                lambda x: -factor(x) * math.sqrt((1 - x) / (high - x)), -1.0, low, weight="alg", wvar=(0.5, -0.5)
            )
            return right[0] + left[0]

        middle = 0.5 * (low + high)
        assert both(lambda x: 1.0) == pytest.approx(-math.pi * b, rel=1e-7)
        assert both(lambda x: x - middle) == pytest.approx(0.5 * math.pi * f, rel=1e-7, abs=1e-9)

    @pytest.mark.parametrize("f", [0.0, 1e-6, 0.3, 0.9, 0.9999])
    def test_a_stick_zone_too_narrow_for_its_ends_is_not_known(self, f):
        """It narrows with bulk stress until that; no size of stress divides by 0."""
        stresses = [1.0, 2.0, 5.0, 8.0, 10.0, 12.0, 20.0, 1e3, 1e5]
        known = [line(f, b) for b in stresses if line(f, b).is_known]
        assert [abs(one.bulk) for one in known] == pytest.approx(stresses[: len(known)])
        widths = [one.stick_half_width / BASE.half_width for one in known]
        assert 0 < len(known) < 7 and (np.diff(widths) < 0.0).all() and widths[-1] > 1e-9
        unknown = line(f, 1e5)
        assert not unknown.is_reached_in_proportion
        with pytest.raises(ValueError, match="not known"):
            _ = unknown.stick_zone

    @pytest.mark.parametrize(
        ("f", "b", "reached"),
        [
            *((0.6, b, True) for b in (0.0, 0.3)),
            *((0.6, b, False) for b in (0.31, 0.36, 0.5, 0.6)),
            *((0.9, 0.75, False), (0.3, 0.2, True), (0.1, 0.3, True), (0.0, 0.3, True), (-0.6, 0.5, False)),
        ],
    )
    def test_loading_in_proportion_leads_there_or_not(self, f, b, reached):
        """By the ends of the stick zone on the way: no one moves outwards."""
        assert line(f, b).is_reached_in_proportion is line(f, -b).is_reached_in_proportion is reached
        ends = np.array([line(part * f, part * b).stick_zone for part in np.linspace(0.05, 1.0, 60)])
        outward = np.concatenate([-np.diff(ends[:, 0]), np.diff(ends[:, 1])])
        assert bool((outward < 1e-7).all()) is reached

    def test_shear_carries_the_force_and_reaches_its_limit_in_the_slip_zones(self):
        contact = line(-0.6, 0.2)
        low, high = contact.stick_zone
        total = quad(
            lambda x: float(contact.shear(np.array(x))),
            -BASE.half_width,
            BASE.half_width,
            points=(low, high),
            limit=200,
        )[0]
        assert total == pytest.approx(contact.shear_force, rel=1e-7)
        x = np.array([-0.1, low, high, 0.1])
        limit = 0.3 * BASE.pressure(x)
        assert contact.shear(x) == pytest.approx(-limit, rel=1e-12)
        assert (contact.slip(x)[[0, 3]] < 0.0).all()
        assert contact.slip(x)[1:3] == pytest.approx(0.0, abs=1e-20)

    def test_out_of_range(self):
        with pytest.raises(ValueError, match="below mu P"):
            line(1.001, 0.0)
        for wanted in (lambda one: one.work_per_cycle, lambda one: one.shear(np.zeros(1)), lambda one: one.slip(0.1)):
            with pytest.raises(ValueError, match="opposite signs"):
                wanted(line(0.1, 0.5))
        with pytest.raises(ValueError, match="negative"):
            line_stick_ratio_under_bulk_alone(-0.1)


class TestSphere:
    @pytest.mark.parametrize(
        ("mismatch", "center", "delta_x"), [(3.333685e-4, 0.1, 0.50828), (6.66737e-4, 0.2, 0.52333)]
    )
    def test_certified_values(self, mismatch, center, delta_x):
        found = SphereUnderBulk(HERTZ, FRICTION, (MATERIAL.A, MATERIAL.B), 24.0, mismatch)
        assert found.stick_radius / A == pytest.approx(0.73681, abs=5e-6)
        assert found.stick_center / A == pytest.approx(center, rel=1e-6)
        assert 1e3 * found.delta_x == pytest.approx(delta_x, abs=5e-6)
        assert found.mismatch_across / mismatch == pytest.approx(-0.3 / 3.1, rel=1e-12)
        back = replace(found, shear_force=-24.0)
        assert (back.stick_center, back.delta_x) == pytest.approx((-found.stick_center, -found.delta_x), rel=1e-15)

    def test_out_of_range(self):
        with pytest.raises(ValueError, match="below mu P"):
            SphereUnderBulk(HERTZ, FRICTION, (MATERIAL.A, MATERIAL.B), 40.0, 0.0)
        with pytest.raises(ValueError, match="edge of the contact"):
            SphereUnderBulk(HERTZ, FRICTION, (MATERIAL.A, MATERIAL.B), 24.0, 1e-3)
