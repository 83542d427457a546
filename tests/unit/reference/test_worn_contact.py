"""The worn limit of partial slip and the law of gross slip against certified tables, with R = E* = a0 = 1."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from fretsolve.reference.worn_contact import (
    WornLimit,
    worn_by_gross_slip,
    worn_limit_at_displacement,
    worn_limit_at_force,
)

P0, V0, CENTER_PRESSURE = 4.0 / 3.0, 0.25 * math.pi, 2.0 / math.pi

# c/a0, then a/a0, P/P0, V/V0, p(0)/p0 with d kept, and d/d0, a/a0, V/V0, p(0)/p0 with P kept
LIMITS = [
    (0.2, (1.346365, 0.296000, 2.616746, 2.600000), (3.346667, 2.521171, 36.135934, 8.466667)),
    (0.464159, (1.244606, 0.646238, 1.126405, 1.309297), (1.508104, 1.571002, 3.538490, 1.856636)),
    (0.5, (1.229791, 0.687500, 0.966769, 1.250000), (1.416667, 1.502677, 2.685716, 1.666667)),
    (0.8, (1.096897, 0.944000, 0.114653, 1.025000), (1.046667, 1.130818, 0.154466, 1.054167)),
]


@pytest.mark.parametrize(("c", "certified"), [(c, one) for c, one, _ in LIMITS])
def test_limit_at_displacement(c, certified):
    """With friction 0.3 and G* = 0.8."""
    limit = worn_limit_at_displacement(1.0, (1.0 - c**2) * 0.3 / 0.8, 0.3, 1.0, 1.0, 4.0 / 0.8)
    found = limit.scar_radius, limit.load / P0, limit.volume / V0, limit.pressure(np.zeros(1))[0] / CENTER_PRESSURE
    assert found == pytest.approx(certified, abs=3e-6)
    assert (limit.stick_radius, limit.delta_z) == pytest.approx((c, 1.0))
    assert limit.shear_force(0.3) == pytest.approx(2.0 * 0.8 * c * (1.0 - c**2) * 0.3 / 0.8)  # 2 G* c delta_x


@pytest.mark.parametrize(("c", "certified"), [(c, one) for c, _, one in LIMITS])
def test_limit_at_force(c, certified):
    force = 0.3 * P0 * (1.0 - c**3)
    limit = worn_limit_at_force(P0, -force, 0.3, 1.0, 1.0)
    found = limit.delta_z, limit.scar_radius, limit.volume / V0, limit.pressure(np.zeros(1))[0] / CENTER_PRESSURE
    assert found == pytest.approx(certified, rel=2e-6)
    assert (limit.stick_radius, limit.load) == pytest.approx((c, P0))
    assert limit.shear_force(0.3) == pytest.approx(force)


def test_profile_and_pressure_hold_together():
    """The profile is continuous, its volume is the worn one, and the pressure carries the load."""
    limit = worn_limit_at_force(P0, 0.26, 0.3, 1.0, 1.0)
    c, a = limit.stick_radius, limit.scar_radius
    r = np.array([0.5 * c, c, c * (1 + 1e-12), a * (1 - 1e-12), a, 2.0 * a])
    assert limit.profile(r) == pytest.approx(0.5 * r**2, abs=1e-5)
    assert (limit.depth(np.linspace(c, a, 50)[1:-1]) > 0.0).all()
    volume = quad(lambda r: 2.0 * math.pi * r * float(limit.depth(np.array(r))), c, a, epsabs=1e-12)[0]
    assert limit.volume == pytest.approx(volume, rel=1e-8)
    load = quad(lambda t: 2.0 * math.pi * c**2 * math.sin(t) * math.cos(t) * float(
        limit.pressure(np.array(c * math.sin(t)))), 0.0, 0.5 * math.pi)[0]  # fmt: skip
    assert load == pytest.approx(P0, rel=1e-8)
    middle = 0.5 * (c + a)
    bracket = 0.5 * middle**2 * math.asin(c / middle) - 0.5 * c * math.sqrt(middle**2 - c**2)
    direct = 2.0 / math.pi * (bracket + limit.delta_z * (0.5 * math.pi - math.asin(c / middle)))
    assert float(limit.profile(np.array(middle))) == pytest.approx(direct, rel=1e-12)


def test_deep_wear_about_a_small_stick_zone():
    """As c falls, the scar tends to the cap of depth d."""
    limit = WornLimit(1e-5, 1.0, 1.0, 1.0)
    assert limit.scar_radius == pytest.approx(math.sqrt(2.0), rel=1e-4)
    assert limit.volume == pytest.approx(math.pi, rel=1e-4)


@pytest.mark.parametrize(
    ("T", "radius", "delta_z", "center"),
    [
        (0.1, 0.939, 1.01623, 0.112),
        (1.0, 1.1645, 1.1421, 0.413),
        (10.0, 1.8343, 1.97698, 1.5142),
        (100.0, 3.1802, 5.22688, 4.95997),
        (1000.0, 5.6291, 15.93942, 15.78863),
    ],
)
def test_gross_slip(T, radius, delta_z, center):
    law = worn_by_gross_slip(P0, 1.0, 1.0, T * V0)
    assert law.scar_radius == pytest.approx(radius, abs=6e-4)
    assert law.delta_z == pytest.approx(delta_z, rel=5e-5)
    assert law.center_depth == pytest.approx(center, abs=5e-4)
    assert law.rigid_scar_radius == pytest.approx(T**0.25)
    assert law.mean_pressure == pytest.approx(P0 / (math.pi * law.scar_radius**2))


@pytest.mark.parametrize(
    "make",
    [
        lambda: worn_limit_at_force(P0, 0.3 * P0, 0.3, 1.0, 1.0),
        lambda: worn_limit_at_displacement(1.0, 1.0, 0.3, 1.0, 1.0, 4.0),
        lambda: WornLimit(1.0, 0.9, 1.0, 1.0),
        lambda: worn_by_gross_slip(P0, 1.0, 1.0, 0.0),
    ],
)
def test_outside_the_stated_range(make):
    with pytest.raises(ValueError, match=r"must be|are needed"):
        make()
