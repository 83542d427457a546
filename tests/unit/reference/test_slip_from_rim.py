"""Abel's transform of an axisymmetric friction limit. Certified values: closed forms, rings within 9e-5."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.slip_from_rim import RimFrictionLimit
from fretsolve.reference.tangential import cattaneo_mindlin, gross_slip_torque

LOAD = 2.0 * math.pi / 3.0
"""mu P with a = p0 = mu = 1."""


def hertz(r):
    return np.sqrt(np.maximum(1.0 - r**2, 0.0))


LAWS = {
    "mu p": (hertz, 1.0, (0.793701, 0.581257), (0.464159, 1.232379)),
    "cap 0.5": (lambda r: np.minimum(hertz(r), 0.5), 0.6875, (0.869007, 0.384574), (0.566742, 0.770077)),
    "cap 0.25": (lambda r: np.minimum(hertz(r), 0.25), 0.367188, (0.904929, 0.199815), (0.586505, 0.398447)),
    "spot": (lambda r: np.where(r < 0.4, 3.0, 1.0) * hertz(r), 1.460255, (0.646229, 0.914813), (0.305497, 2.395466)),
    "power": (lambda r: hertz(r) ** (2.0 / 3.0), 1.125, (0.829717, 0.636719), (0.496831, 1.328591)),
}


@pytest.mark.parametrize("name", LAWS)
def test_certified(name):
    bound, gross_slip, *certified = LAWS[name]
    law = RimFrictionLimit(bound, 1.0, 4.0)
    assert law.slips_from_rim
    assert law.gross_slip_force / LOAD == pytest.approx(gross_slip, rel=2e-6)
    for share, (c, delta) in zip((0.5, 0.9), certified, strict=True):
        found = law.under(share * law.gross_slip_force)
        assert found.stick_radius == pytest.approx(c, rel=1e-5)
        assert found.delta_x == pytest.approx(delta, rel=1e-5)


def test_coulomb_friction_gives_cattaneo_and_mindlin():
    contact = hertz_sphere(400.0, 10.0, 110e3)
    law = RimFrictionLimit(lambda r: 0.1 * contact.pressure(r), contact.contact_radius, 3e-5)
    assert law.gross_slip_torque == pytest.approx(gross_slip_torque(contact, 0.1))
    r = np.linspace(0.01, 0.35, 30)
    for force in (30.0, -10.0, 39.9):
        known, found = cattaneo_mindlin(contact, 0.1, force, 3e-5), law.under(force)
        assert found.stick_radius == pytest.approx(known.stick_radius, abs=1e-4)
        assert found.delta_x == pytest.approx(known.delta_x)
        assert found.work_per_cycle == pytest.approx(known.work_per_cycle, rel=1e-6)
        assert found.shear(r) == pytest.approx(known.shear(r), abs=0.2)


def test_slip_from_the_middle_is_not_covered():
    inside_out = RimFrictionLimit(lambda r: np.where(r < 0.4, 0.2, 1.0) * hertz(r), 1.0, 4.0)
    assert not inside_out.slips_from_rim
    assert inside_out.gross_slip_force == pytest.approx(LOAD * (1.0 - 0.8 * (1.0 - (1.0 - 0.16) ** 1.5)))


def test_more_than_gross_slip_is_refused():
    law = RimFrictionLimit(hertz, 1.0, 4.0)
    with pytest.raises(ValueError, match="must not exceed"):
        law.under(1.001 * law.gross_slip_force)
