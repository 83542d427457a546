"""The JSON Schema of the case file agrees with what is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from command_line import invoke, refused
from small_cases import write_case
from test_models import FULL, MINIMAL, ROUND_TRIPS
from test_problems import CASE

import fretsolve
from fretsolve.case.dimensions import DIMENSIONS, LAYER_COMPLIANCE, STIFFNESS, TURNING_STIFFNESS
from fretsolve.case.loading import load_case
from fretsolve.case.quantities import UNIT_NOTE, to_internal
from fretsolve.case.schema import area_schema, case_schema
from fretsolve.case.source import parse
from fretsolve.cli.commands.check import cases_at

UNITS = {one.unit: one for one in (STIFFNESS, TURNING_STIFFNESS, LAYER_COMPLIANCE, *DIMENSIONS)}
ROOT = Path(__file__).parents[3]
FOLDERS = (ROOT / "cases", ROOT / "cases" / "external", Path(fretsolve.__file__).parent / "case" / "templates")
CASES = [case for folder in FOLDERS[:2] for case in cases_at(folder)[0]] + sorted(FOLDERS[2].glob("*.yaml"))


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    schema = case_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("text", [CASE, *ROUND_TRIPS])
def test_cases_and_effective_cases_are_valid(
    tmp_path: Path, validator: jsonschema.Draft202012Validator, text: str
) -> None:
    case = load_case(write_case(tmp_path, text))
    written = yaml.safe_load(text.replace("1e-", "1.0e-"))  # PyYAML takes 1e-6 for text
    assert list(validator.iter_errors(written)) == []
    assert list(validator.iter_errors(case.effective())) == []


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("sphere:", "spere:"),
        ("{radius: 1}", "{radius: 0}"),
        ("{radius: 1}", "{radius: thick}"),
        ("{sphere: {radius: 1}}", "[]"),
        ("{sphere: {radius: 1}}", "{sphere: {radius: 1}, cone: {angle: 0.1}}"),
        ("{sphere: {radius: 1}}", "{punch: {}}"),
        ("points: 8", "points: 8.5"),
        ("points: 8", "points: 8, size: none"),
        ("points: 8", "point: 8"),
        ("rigid", "soft"),
        ("{P: 1}", "{P: -1}"),
        ("{P: 1}", "{P: 1, delta_z: 1}"),
        ("{P: 1}", "{cycle: {times: 1}}"),
        ("[{P: 1}]", "[{P: 1}]\ncoupling: all"),
        ("[{P: 1}]", "[{P: 1}]\nexpect: [{quantity: work, value: 1}]"),
    ],
)
def test_mistakes_are_invalid(validator: jsonschema.Draft202012Validator, right: str, wrong: str) -> None:
    assert right in MINIMAL
    assert list(validator.iter_errors(yaml.safe_load(MINIMAL.replace(right, wrong))))


def test_defaults_are_those_of_the_effective_case(tmp_path: Path) -> None:
    effective = load_case(write_case(tmp_path, MINIMAL)).effective()
    schema = area_schema()
    for key in ("friction", "coupling", "solver", "output", "expect"):
        assert schema["properties"][key]["default"] == effective[key]
    assert schema["$defs"]["GridSpec"]["properties"]["size"]["default"] == "auto"
    assert schema["$defs"]["StageSpec"]["properties"]["increments"]["default"] == "auto"


def _nodes(node: Any) -> list[dict[str, Any]]:
    if isinstance(node, list):
        return [inner for item in node for inner in _nodes(item)]
    if not isinstance(node, dict):
        return []
    return [node, *(inner for value in node.values() for inner in _nodes(value))]


def test_every_key_is_described_and_none_may_be_null() -> None:
    schema = area_schema()
    properties = [
        (name, value) for node in _nodes(schema) for name, value in node.get("properties", {}).items() if value
    ]
    assert len(properties) > 50
    described = [name for name, value in properties if "description" in value or "$ref" in value]
    assert described == [name for name, _ in properties]
    assert all(node.get("type") != "null" for node in _nodes(schema))
    assert yaml.safe_load(FULL).keys() <= schema["properties"].keys()


def _keys(schema: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Every key of the case file with its schema."""
    return [(name, node) for found in _nodes(schema) for name, node in found.get("properties", {}).items() if node]


def _has_choices(node: dict[str, Any]) -> bool:
    return "enum" in node or any(_has_choices(one) for one in node.get("anyOf", ()))


def test_quantities_tell_their_unit_and_every_key_has_an_example_default_or_choice() -> None:
    keys = _keys(area_schema())
    with_unit = {name: node["description"].partition(UNIT_NOTE)[2] for name, node in keys if "description" in node}
    expected = {"radius": "mm", "P": "N", "young_modulus": "MPa", "Mz": "N mm", "phi_z": "rad", "size": "mm", "rel": ""}
    assert {name: with_unit[name] for name in expected} == expected
    assert {unit for unit in with_unit.values() if unit} <= UNITS.keys()
    telling = {"examples", "default", "enum", "$ref"}
    assert [name for name, node in keys if not (telling & node.keys() or _has_choices(node))] == []


def test_examples_and_defaults_are_valid_and_of_the_right_dimension() -> None:
    schema = area_schema()
    for name, node in _keys(schema):
        validator = jsonschema.Draft202012Validator({"$defs": schema["$defs"], **node})
        for example in (*node.get("examples", ()), *([node["default"]] if "default" in node else [])):
            assert list(validator.iter_errors(example)) == [], name
        unit = node.get("description", "").partition(UNIT_NOTE)[2]
        texts = [example for example in node.get("examples", ()) if isinstance(example, str) and example != "x"]
        for text in texts if unit else ():
            assert to_internal(text, UNITS[unit], bare_unit=True) > 0.0


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_shipped_cases_and_templates_are_valid(path: Path, validator: jsonschema.Draft202012Validator) -> None:
    assert list(validator.iter_errors(parse(path.read_text()).value)) == []


def test_schema_is_written_for_editors(tmp_path: Path) -> None:
    file = tmp_path / "fretsolve.schema.json"
    done = invoke("schema", "-o", file)
    assert (done.exit_code, done.stdout) == (0, f"{file}\n")
    assert file.read_text() == invoke("schema").stdout
    file.write_text("mine")
    told = f"{file}: exists: --overwrite replaces it, or give another name with -o\n"
    assert refused(2, "schema", "-o", file) == told
    assert file.read_text() == "mine"
    assert invoke("schema", "-o", file, "--overwrite").exit_code == 0
    assert file.read_text() == invoke("schema").stdout
    told = f"{tmp_path}/case.yaml: the name of a JSON Schema must end in .json\n"
    assert refused(2, "schema", "-o", tmp_path / "case.yaml") == told
    assert refused(4, "schema", "-o", tmp_path / "none" / "schema.json")
