"""A material from a file or from the command line, and where its mistakes are."""

from __future__ import annotations

from pathlib import Path

import pytest

from fretsolve.errors import CaseError
from fretsolve.fatigue.request import read_material

LIMITS = "tension_limit=300 MPa,torsion_limit=0.19 GPa"


def test_keys() -> None:
    material = read_material(LIMITS).material
    assert (material.tension_limit, material.torsion_limit) == (300.0, pytest.approx(190.0))


def test_file(tmp_path: Path) -> None:
    path = tmp_path / "steel.yaml"
    path.write_text("tension_limit: 300 MPa\ntorsion_limit: 190 MPa\n")
    assert read_material(str(path)).material == read_material(LIMITS).material


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tension_limit=", "--material: 'tension_limit=' is not a list KEY=VALUE,KEY=VALUE of constants"),
        ("tension_limit=300 MPa,190 MPa=", "is not a list KEY=VALUE,KEY=VALUE of constants"),
        ("tension_limit=300 mm", "--material: tension_limit: '300 mm'"),
        ("limit=300 MPa", "--material: limit: "),
    ],
)
def test_wrong_keys(text: str, message: str) -> None:
    with pytest.raises(CaseError) as caught:
        read_material(text)
    assert message in str(caught.value)


def test_a_wrong_value_in_a_file_has_its_line(tmp_path: Path) -> None:
    path = tmp_path / "steel.yaml"
    path.write_text("tension_limit: 300 MPa\ntorsion_limit: -190 MPa\n")
    with pytest.raises(CaseError) as caught:
        read_material(str(path))
    assert (caught.value.line, caught.value.key) == (2, ("torsion_limit",))
    assert "-190 MPa" in caught.value.message


def test_a_constant_that_a_criterion_lacks_is_named() -> None:
    source = read_material("tension_limit=300 MPa")
    with pytest.raises(CaseError, match=r"^--material: torsion_limit: is missing; a pressure such as"):
        source.require(("crossland",))


def test_elastic_constants_of_a_body_fill_in_for_those_not_given() -> None:
    body = {"young_modulus": 2e5, "poisson_ratio": 0.3}
    material = read_material(f"{LIMITS},poisson_ratio=0.25").with_elastic_constants(body).material
    assert (material.young_modulus, material.poisson_ratio) == (2e5, 0.25)
