"""The layer between the bodies in a case file: what is refused, and with which words."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_cases import CASE, case_error, write_case

RANGE = "is out of range; a displacement per traction > 0 mm/MPa is needed"


@pytest.mark.parametrize(
    ("layer", "key", "message"),
    [
        ("{shear_compliance: 0}", "shear_compliance", f"0 {RANGE}"),
        ("{shear_compliance: -2e-5 mm/MPa}", "shear_compliance", f"'-2e-5 mm/MPa' {RANGE}"),
        ("{normal_compliance: 0 mm/MPa}", "normal_compliance", f"'0 mm/MPa' {RANGE}"),
        ("{shear_compliance: .inf}", "shear_compliance", "inf is not finite; a displacement per traction such as"),
        (
            "{shear_compliance: 2 mm}",
            "shear_compliance",
            "'2 mm' is a length; a displacement per traction such as '2e-5 mm/MPa' is needed",
        ),
        ("{shear_compliance: 2 GPa}", "shear_compliance", "'2 GPa' is a pressure; a displacement per traction"),
        ("{thickness: 5 um, shear_modulus: 0 GPa}", "shear_modulus", "'0 GPa' is out of range; a pressure > 0 MPa"),
        ("{thickness: -5 um, shear_modulus: 2 GPa}", "thickness", "'-5 um' is out of range; a length > 0 mm"),
        ("{shear_modulus: 2 GPa}", "shear_modulus", "a modulus needs the layer's thickness; add thickness: 5 um"),
        ("{normal_modulus: 2 GPa}", "normal_modulus", "a modulus needs the layer's thickness; add thickness: 5 um"),
        ("{thickness: 5 um}", "thickness", "a thickness needs a modulus; add shear_modulus: 2 GPa, or normal_modulus"),
        (
            "{thickness: 5 um, shear_modulus: 2 GPa, shear_compliance: 1e-6}",
            "shear_modulus",
            "shear_modulus and shear_compliance exclude each other; keep one of the two",
        ),
        (
            "{thickness: 5 um, normal_modulus: 2 GPa, normal_compliance: 1e-6}",
            "normal_modulus",
            "normal_modulus and normal_compliance exclude each other; keep one of the two",
        ),
        ("{shear: 2e-5 mm/MPa}", "shear", "unknown key"),
    ],
)
def test_layers_that_are_refused(tmp_path: Path, layer: str, key: str, message: str) -> None:
    error = case_error(write_case(tmp_path, f"{CASE}interface: {layer}\n"))
    assert ".".join(map(str, error.key)) == f"interface.{key}"
    assert message in error.message
    assert error.line == CASE.count("\n") + 1


def test_a_layer_without_a_number(tmp_path: Path) -> None:
    error = case_error(write_case(tmp_path, f"{CASE}interface: {{}}\n"))
    assert error.message == "the layer is rigid; shear_compliance, such as 2e-5 mm/MPa, or a modulus is needed"
