"""The JSON Schema of the case file agrees with what is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from test_case_errors import CASE
from test_case_models import FULL, MINIMAL, ROUND_TRIPS

from fretsolve.case import case_schema, load_case


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    schema = case_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("text", [CASE, *ROUND_TRIPS])
def test_cases_and_effective_cases_are_valid(
    tmp_path: Path, validator: jsonschema.Draft202012Validator, text: str
) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(text)
    case = load_case(path)
    written = yaml.safe_load(text.replace("1e-", "1.0e-"))  # PyYAML takes 1e-6 for text
    assert list(validator.iter_errors(written)) == []
    assert list(validator.iter_errors(case.effective())) == []


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("sphere:", "spere:"),
        ("{radius: 1}", "{radius: 0}"),
        ("{radius: 1}", "{radius: [1]}"),
        ("{radius: 1}", "{radius: thick}"),
        ("{sphere: {radius: 1}}", "[]"),
        ("{sphere: {radius: 1}}", "{}"),
        ("{sphere: {radius: 1}}", "{sphere: {radius: 1}, cone: {angle: 0.1}}"),
        ("{sphere: {radius: 1}}", "{cone: {angle: 2}}"),
        ("{sphere: {radius: 1}}", "{punch: {}}"),
        ("points: 8", "points: 8.5"),
        ("points: 8", "points: [8]"),
        ("points: 8", "points: 8, size: none"),
        ("points: 8", "point: 8"),
        ("rigid", "soft"),
        ("poisson_ratio: 0.3", "poisson_ratio: 0.6"),
        ("{P: 1}", "{P: -1}"),
        ("{P: 1}", "{P: 1, delta_z: 1}"),
        ("{P: 1}", "{P: 1, increments: 0}"),
        ("{P: 1}", "{cycle: {times: 1}}"),
        ("[{P: 1}]", "[]"),
        ("[{P: 1}]", "[{P: 1}]\ncoupling: all"),
        ("[{P: 1}]", "[{P: 1}]\ntitle:"),
        ("[{P: 1}]", "[{P: 1}]\nexpect: [{quantity: work, value: 1}]"),
        ("[{P: 1}]", "[{P: 1}]\nexpect: [{quantity: heat, value: 1, rel: 1}]"),
    ],
)
def test_mistakes_are_invalid(validator: jsonschema.Draft202012Validator, right: str, wrong: str) -> None:
    assert right in MINIMAL
    assert list(validator.iter_errors(yaml.safe_load(MINIMAL.replace(right, wrong))))


def test_defaults_are_those_of_the_effective_case(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(MINIMAL)
    effective = load_case(tmp_path / "case.yaml").effective()
    schema = case_schema()
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
    schema = case_schema()
    properties = [
        (name, value)
        for node in _nodes(schema)
        for name, value in node.get("properties", {}).items()
        if value
    ]
    assert len(properties) > 50
    described = [name for name, value in properties if "description" in value or "$ref" in value]
    assert described == [name for name, _ in properties]
    assert all(node.get("type") != "null" for node in _nodes(schema))
    assert yaml.safe_load(FULL).keys() <= schema["properties"].keys()
