"""The criteria under loads with known values, the constants of a material, and lives by strain-life curves."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.quantity_names import STRESS_CRITERIA
from fretsolve.errors import CaseError
from fretsolve.post.fatigue.criteria import (
    LONGEST,
    fatigue_field,
    lives,
    require_constants,
    shear_strain_lives,
    swt_lives,
)

STEEL = {
    "tension_limit": "300 MPa",
    "torsion_limit": "190 MPa",
    "tensile_strength": "700 MPa",
    "yield_stress": "500 MPa",
    "young_modulus": "200 GPa",
    "poisson_ratio": 0.3,
}


def test_factors():
    material = Material.model_validate(STEEL)
    assert material.crossland_factor == pytest.approx(0.167949, abs=5e-7)
    assert material.dang_van_factor == pytest.approx(0.4)
    assert material.findley_factor == pytest.approx(0.276686, abs=5e-7)
    assert material.findley_limit == pytest.approx(197.1386, abs=5e-5)
    assert material.mcdiarmid_factor == pytest.approx(190.0 / 1400.0)
    assert Material.model_validate(STEEL | {"mcdiarmid_limit": 150.0}).mcdiarmid_shear_limit == 150.0
    assert material.shear_modulus == pytest.approx(200e3 / 2.6)


@pytest.mark.parametrize("name", STRESS_CRITERIA)
def test_limit_in_tension_and_torsion_is_used_up_at_once(name):
    """Amplitudes at both fatigue limits have utilisation 1, but for McDiarmid's in tension."""
    material = Material.model_validate(STEEL)
    stress = np.zeros((3, 6, 2))
    stress[:, 0, 0] = [0.0, 300.0, -300.0]
    stress[:, 3, 1] = [0.0, 190.0, -190.0]
    used = fatigue_field(name, material, stress).utilisation
    if name in ("fatemi-socie", "swt"):
        assert used is None
    else:
        tension = 1.0 if name != "mcdiarmid" else (150.0 + 190.0 / 1400.0 * 150.0) / 190.0
        np.testing.assert_allclose(used, [tension, 1.0], rtol=1e-6)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("tension_limit", 0.0, "a pressure > 0 MPa is needed"),
        ("tensile_strength", "-700 MPa", "a pressure > 0 MPa is needed"),
        ("poisson_ratio", 0.6, "<= 0.5 is needed"),
        ("fatemi_socie_factor", -1, ">= 0 is needed"),
        ("yield_stress", "500 N", "is a force; a pressure such as"),
        ("strain_life", {"strength": 1000, "strength_exponent": 0.1}, "< 0 is needed"),
    ],
)
def test_constants_out_of_range_are_refused(key, value, message):
    with pytest.raises(ValidationError, match=message):
        Material.model_validate(STEEL | {key: value})


@pytest.mark.parametrize(
    ("name", "torsion", "bound"),
    [("crossland", 173.0, "above 0.57735"), ("dang-van", 150.0, "above 0.5"), ("findley", 300.0, "below 1")],
)
def test_ratio_of_limits_out_of_range_is_refused(name, torsion, bound):
    material = Material.model_validate(STEEL | {"torsion_limit": torsion})
    message = rf"torsion_limit/tension_limit is {torsion:g}/300 = .* a ratio .*{bound}.* is needed for {name}"
    with pytest.raises(CaseError, match=message):
        require_constants((name,), material)


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("crossland", "torsion_limit"),
        ("dang-van", "tension_limit"),
        ("findley", "tension_limit"),
        ("mcdiarmid", "tensile_strength"),
        ("fatemi-socie", "yield_stress"),
        ("swt", "poisson_ratio"),
    ],
)
def test_missing_constants_are_named(name, key):
    with pytest.raises(CaseError, match="is missing") as caught:
        require_constants((name,), Material.model_validate({k: v for k, v in STEEL.items() if k != key}))
    assert caught.value.key == (key,)


CURVE = {"strength": 1000.0, "strength_exponent": -0.1, "ductility": 0.5, "ductility_exponent": -0.6}


def test_lives_invert_the_curve():
    cycles = np.array([1.0, 1e3, 1e6, 1e9])
    terms = [(0.005, -0.1), (0.5, -0.6)]
    value = sum(factor * (2.0 * cycles) ** exponent for factor, exponent in terms)
    np.testing.assert_allclose(lives(value, terms), cycles, rtol=1e-9)


def test_lives_end_at_half_a_cycle_and_at_endless():
    assert lives(np.array([0.0, 1e9]), [(1.0, -0.1)]).tolist() == [np.inf, 0.0]
    assert lives(np.array([(2.0 * LONGEST) ** -0.1 * 0.99]), [(1.0, -0.1)])[0] == np.inf


def test_curves_of_both_parameters():
    material = Material(young_modulus=200e3, poisson_ratio=0.25, strain_life=CURVE, shear_strain_life=CURVE)
    twice = 2e5
    product = 1000.0**2 / 200e3 * twice**-0.2 + 1000.0 * 0.5 * twice**-0.7
    assert swt_lives(material, np.array([product]))[0] == pytest.approx(1e5)
    strain = 1000.0 / 80e3 * twice**-0.1 + 0.5 * twice**-0.6
    assert shear_strain_lives(material, np.array([strain]))[0] == pytest.approx(1e5)
