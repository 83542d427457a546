"""What is refused of a material and of a file of stresses, and constants that the body has."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import invoke, result_of
from small_cases import TWO_CYCLES, write_case

from fretsolve.errors import CaseError, FileError
from fretsolve.post.fatigue.material import read_material
from fretsolve.post.fatigue.request import FatigueRequest
from fretsolve.post.fatigue.stress_cycle import stress_cycles
from fretsolve.post.stress.computed_file import opened_computed

LIMITS = "tension_limit=300 MPa,torsion_limit=0.19 GPa"


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


def test_elastic_constants_of_a_body_fill_in_for_those_not_given() -> None:
    body = {"young_modulus": 2e5, "poisson_ratio": 0.3}
    material = read_material(f"{LIMITS},poisson_ratio=0.25").with_elastic_constants(body).material
    assert (material.young_modulus, material.poisson_ratio) == (2e5, 0.25)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with the stresses of both bodies beside it."""
    case = write_case(tmp_path_factory.mktemp("cycles"), TWO_CYCLES.replace("points: 16", "points: 12"))
    out = result_of(case)
    words = ("--cycle", "last", "--depth", "20 um", "--body", 1, "--body", 2, "-q")
    assert invoke("stress", out, *words).exit_code == 0
    return out


def test_a_result_is_no_file_of_stresses(out: Path) -> None:
    request = FatigueRequest(read_material(LIMITS), ("findley",))
    with pytest.raises(FileError, match="is not a file of stresses"), opened_computed(out) as file:
        stress_cycles(file, out, out, request)
