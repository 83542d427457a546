"""Constants of a material with units of stress intensity and of crack growth."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from fretsolve.case.keys.material_spec import Material, ParisLaw


@pytest.mark.parametrize(
    ("text", "value"),
    [("2.1 MPa m^0.5", 2.1), ("2.1 MPa sqrt(m)", 2.1), ("100 MPa mm^0.5", 100.0 / 1000.0**0.5), (2.1, 2.1)],
)
def test_stress_intensities(text: str | float, value: float) -> None:
    material = Material.model_validate({"threshold_range": text, "toughness": text})
    assert material.threshold_range == pytest.approx(value, rel=1e-12)
    assert material.toughness == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "says"),
    [("2.1 MPa", "'2.1 MPa' is a pressure"), ("-1 MPa m^0.5", "out of range"), ("2.1 MPa m", "2.1 MPa m")],
)
def test_what_is_no_stress_intensity(text: str, says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        Material.model_validate({"toughness": text})


@pytest.mark.parametrize(
    ("coefficient", "value"),
    [
        (1e-11, 1e-11),
        ("1e-11", 1e-11),
        ("1e-8 mm/cycle", 1e-11),
        # 1 mm/(MPa mm^0.5)^3 is 1e-3 m over (1000^-0.5 MPa m^0.5)^3
        ("5e-13 mm/(MPa mm^0.5)^3", 5e-13 * 1e-3 * 1000.0**1.5),
        ("1e-11 m/(MPa m^0.5)^3", 1e-11),
        ("1e-11 m/cycle/(MPa sqrt(m))^3", 1e-11),
    ],
)
def test_coefficients_of_paris(coefficient: str | float, value: float) -> None:
    law = ParisLaw.model_validate({"coefficient": coefficient, "exponent": 3})
    assert law.coefficient == pytest.approx(value, rel=1e-12)
    assert law.walker_exponent == 1.0


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"coefficient": "5e-13 mm/(MPa mm^0.5)^4"}, "has the power 4, the exponent is 3"),
        ({"coefficient": "5e-13 MPa"}, "'5e-13 MPa' is not a coefficient of Paris's law; a number in m per cycle"),
        ({"coefficient": "5e-13 N/(MPa mm^0.5)^3"}, "is not a coefficient of Paris's law"),
        ({"coefficient": -1e-11}, "-1e-11 is out of range"),
        ({"coefficient": 5.0}, "5.0 is out of range"),
        ({"coefficient": 1e-11, "exponent": 0}, "out of range"),
        ({"coefficient": 1e-11, "walker_exponent": 2}, "out of range"),
    ],
)
def test_mistakes_in_the_law_of_growth(keys: dict[str, Any], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        ParisLaw.model_validate({"exponent": 3} | keys)
