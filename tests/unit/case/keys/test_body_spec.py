"""A body may name a material of the library."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import pytest
import yaml
from command_line import invoke
from small_cases import CASE, SIMILAR, SPHERE, case_error, write_case

from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.case.loading import load_case
from fretsolve.case.schema import case_schema
from fretsolve.reference.materials import LIBRARY, every_name, material_named


def case_with(tmp_path: Path, body: str) -> Path:
    first = SPHERE.splitlines()[1].removeprefix("  - ")
    return write_case(tmp_path, CASE.replace(first, body, 1))


@pytest.mark.parametrize("name", ["Ti-6Al-4V", "ti 6al 4v", "TI6AL4V", "Ti64"])
def test_a_name_stands_for_the_constants_of_a_material(tmp_path: Path, name: str) -> None:
    case = load_case(case_with(tmp_path, f"{{material: {name}}}"))
    constants = {"young_modulus": 113800.0, "poisson_ratio": 0.342, "yield_stress": 880.0}
    assert case.effective()["bodies"][0] == {"material": "Ti-6Al-4V", **constants}


def test_a_number_is_a_name_too(tmp_path: Path) -> None:
    body = load_case(case_with(tmp_path, "{material: 52100}")).bodies[0]
    assert body == ElasticBody(material="100Cr6", young_modulus=210e3, poisson_ratio=0.3)


def test_keys_beside_the_name_and_overrides_hold(tmp_path: Path) -> None:
    path = case_with(tmp_path, "{material: steel, young_modulus: 205 GPa, yield_stress: 1 GPa}")
    body = load_case(path, ["bodies.0.poisson_ratio=0.29"]).bodies[0]
    assert body == ElasticBody(material="steel", young_modulus=205e3, poisson_ratio=0.29, yield_stress=1000.0)
    other = load_case(path, ["bodies.0={material: copper}"]).bodies[0]
    assert isinstance(other, ElasticBody)
    assert other.young_modulus == 129.8e3


def test_an_override_of_the_name_replaces_the_constants_of_the_file(tmp_path: Path) -> None:
    """Else a body of given numbers would keep them under another name."""
    path = case_with(tmp_path, "{young_modulus: 205 GPa, poisson_ratio: 0.29, yield_stress: 1 GPa}")
    copper = ElasticBody(material="copper", young_modulus=129.8e3, poisson_ratio=0.343)
    assert load_case(path, ["bodies.0.material=copper"]).bodies[0] == copper
    assert load_case(path, ["bodies.1.material=copper"]).bodies[1] == copper
    for overrides in (
        ["bodies.0.material=copper", "bodies.0.yield_stress=70 MPa"],
        ["bodies.0.yield_stress=70 MPa", "bodies.0.material=copper"],
    ):
        assert load_case(path, overrides).bodies[0] == copper.model_copy(update={"yield_stress": 70.0})
    rigid = case_with(tmp_path, "rigid")
    assert load_case(rigid, ["bodies.0.material=copper"]).bodies[0] == copper


def test_an_effective_case_keeps_the_constants_that_it_was_run_with(tmp_path: Path) -> None:
    effective = load_case(case_with(tmp_path, "{material: brass}")).effective()
    effective["bodies"][0]["young_modulus"] = 99e3  # as an earlier library might have had it
    again = load_case(write_case(tmp_path, yaml.safe_dump(effective)))
    assert again.effective() == effective


@pytest.mark.parametrize(
    ("body", "key", "message"),
    [
        ("{material: stel}", "bodies.0.material", "'stel' is not a material of the library; did you mean 'steel'?"),
        ("{material: 7074-T6}", "bodies.0.material", "'7074-T6' is not a material of the library; did you mean"),
        (
            "{material: unobtainium}",
            "bodies.0.material",
            "'unobtainium' is not a material of the library; one of steel,",
        ),
        ("{material: aluminiun}", "bodies.0.material", "'aluminiun' is not a material of the library; did you"),
        ("{material: [1]}", "bodies.0.material", "[1] is not a material of the library; one of steel,"),
        ("{material: steel, poison_ratio: 0.3}", "bodies.0.poison_ratio", "unknown key 'poison_ratio'; did you mean"),
        ("{material: steel, young_modulus: 0}", "bodies.0.young_modulus", "0 is out of range; a pressure > 0 MPa"),
        ("{}", "bodies.0.young_modulus", "missing; needed: Young's modulus"),
        ("steel", "bodies.0", "'steel' is not a body; rigid or {material: steel} is needed"),
        ("52100", "bodies.0", "52100 is not a body; rigid or {material: 100Cr6} is needed"),
    ],
)
def test_what_is_no_material_is_refused_in_a_line(tmp_path: Path, body: str, key: str, message: str) -> None:
    path = case_with(tmp_path, body)
    assert str(case_error(path)).splitlines()[0].startswith(f"{path}:3: {key}: {message}")


def test_editors_take_a_name_in_place_of_constants() -> None:
    validator = jsonschema.Draft202012Validator(case_schema())
    case = yaml.safe_load(CASE)

    def valid(body: object) -> bool:
        return validator.is_valid({**case, "bodies": [body, "rigid"]})

    assert all(
        map(valid, ({"material": "steel"}, {"material": 52100}, {"material": "SiC", "young_modulus": "400 GPa"}))
    )
    assert not any(map(valid, ({}, {"material": ["steel"]}, {"poisson_ratio": 0.3}, {"material": "steel", "E": 1})))
    assert valid(yaml.safe_load(SIMILAR)[0])


def test_every_name_of_the_library_is_one_material_with_a_source() -> None:
    names = every_name()
    assert len({name.lower().replace(" ", "").replace("-", "") for name in names}) == len(names)
    assert {material_named(name) for name in names} == set(LIBRARY)
    for one in LIBRARY:
        assert len(one.source) > 15
        assert ElasticBody.model_validate({"material": one.name}).young_modulus == one.young_modulus
    assert material_named("unobtainium") is None


def test_validate_names_the_source_and_what_the_case_changes(tmp_path: Path) -> None:
    path = case_with(tmp_path, "{material: ti64, young_modulus: 120 GPa, yield_stress: 900 MPa}")
    lines = invoke("validate", path).stdout.splitlines()
    (told,) = [line for line in lines if line.startswith("body ")]
    assert told.startswith("body 1: Ti-6Al-4V, by ASM Aerospace Specification Metals")
    assert told.endswith("; the case changes young_modulus and yield_stress")
    plain = invoke("validate", case_with(tmp_path, "{material: copper}")).stdout
    assert "\nbody 1: copper, by Kaye and Laby, Tables of Physical and Chemical Constants" in plain
    assert "the case changes" not in plain


def test_the_command_lists_all_of_them() -> None:
    listed = invoke("materials")
    assert listed.exit_code == 0
    assert "\nTi-6Al-4V          113.8  0.342          880  Ti64, TA6V\n    ASM Aerospace" in listed.stdout
    assert all(one.source in listed.stdout for one in LIBRARY)


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("S355", 355),
        ("s235jr", 235),
        ("Ti-6Al-4V", 880),
        ("Ti-6Al-4V STA", 1100),
        ("6061-T6", 276),
        ("C26000 H02", 350),
    ],
)
def test_graded_materials_have_a_yield_stress_with_its_source(name: str, limit: float) -> None:
    found = material_named(name)
    assert found is not None and found.yield_stress == limit


@pytest.mark.parametrize("name", ["steel", "52100", "Inconel 718", "brass", "copper", "alumina", "fused silica"])
def test_open_grades_and_brittle_materials_have_no_yield_stress(name: str) -> None:
    found = material_named(name)
    assert found is not None and found.yield_stress is None
