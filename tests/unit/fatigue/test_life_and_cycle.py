"""Lives by strain-life curves, and closed cycles."""

import numpy as np
import pytest

from fretsolve.case.keys.material_spec import Material
from fretsolve.errors import CaseError
from fretsolve.fatigue.criteria import LONGEST, lives, shear_strain_lives, swt_lives
from fretsolve.fatigue.request import require_states
from fretsolve.fatigue.stress_cycle import not_closed, opening_of

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


def test_without_curves_there_are_no_lives():
    assert swt_lives(Material(), np.ones(1)) is None
    assert shear_strain_lives(Material(), np.ones(1)) is None


def test_cycle_of_two_states_is_refused():
    with pytest.raises(CaseError, match="2 stored states; 3 or more are needed"):
        require_states(2)
    require_states(3)


def test_opening_is_the_largest_change_over_the_largest_range():
    stress = np.zeros((3, 6, 2))
    stress[1, 1, 0], stress[2, 3, 1] = 100.0, -2.0
    assert opening_of(stress) == pytest.approx(0.02)
    assert opening_of(np.zeros((3, 6, 2))) == 0.0


def test_only_open_cycles_give_a_warning():
    assert not_closed(0.01) is None
    assert "differs from its first by 2 % of the range (more than 1 %)" in not_closed(0.02)
