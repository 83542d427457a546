"""A material from a file or from keys, and from a result or a file of stresses to cycles."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import invoke, result_of
from small_cases import TWO_CYCLES, write_case

from fretsolve.errors import CaseError, FileError
from fretsolve.post.fatigue.request import FatigueRequest, read_material, stresses_of_cycle
from fretsolve.post.fatigue.stress_cycle import cycles_of, stresses_beside
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import open_result

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


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with the stresses of both bodies beside it."""
    case = write_case(tmp_path_factory.mktemp("cycles"), TWO_CYCLES.replace("points: 16", "points: 12"))
    out = result_of(case)
    words = ("--cycle", "last", "--depth", "20 um", "--body", 1, "--body", 2, "-q")
    assert invoke("stress", out, *words).exit_code == 0
    return out


def test_stresses_of_the_last_cycle(out: Path) -> None:
    request = FatigueRequest(read_material(LIMITS), ("findley",), bodies=(2,))
    with open_result(out) as result:
        found = stresses_of_cycle(TractionHistory(result), request)
    assert (found.bodies, list(found.steps)) == ((2,), [6, 7, 8, 9, 10])
    assert found.depths[0] == 0.0


def test_material_is_refused_before_anything_is_computed(out: Path) -> None:
    request = FatigueRequest(read_material("tension_limit=300 MPa"), ("findley",))
    with open_result(out) as result, pytest.raises(CaseError, match="torsion_limit"):
        stresses_of_cycle(TractionHistory(result), request)


@pytest.mark.parametrize(("asked", "found"), [((), [1, 2]), ((1,), [1]), ((2,), [2])])
def test_cycles_of_the_bodies_that_are_asked_for(out: Path, asked: tuple[int, ...], found: list[int]) -> None:
    stresses = out.with_suffix(".stress.h5")
    request = FatigueRequest(read_material(LIMITS), ("findley",), bodies=asked)  # type: ignore[arg-type]
    with opened_computed(stresses) as file:
        cycles = cycles_of(file, stresses, out, request)
    assert list(cycles.of_body) == found
    assert {cycle.chosen for cycle in cycles.of_body.values()} == {(0, 1, 2, 3, 4)}


def test_a_result_is_no_file_of_stresses(out: Path) -> None:
    request = FatigueRequest(read_material(LIMITS), ("findley",))
    with pytest.raises(FileError, match="is not a file of stresses"), opened_computed(out) as file:
        cycles_of(file, out, out, request)


def test_stresses_for_a_while_leave_nothing(tmp_path: Path) -> None:
    with stresses_beside(tmp_path / "out.fatigue.h5") as stresses:
        assert stresses.parent.parent == tmp_path
        stresses.write_bytes(b"x")
    assert list(tmp_path.iterdir()) == []
