"""The case file of a line contact: its units, what it refuses, and its schema."""

from __future__ import annotations

import json

import jsonschema
import pytest
import yaml
from line_cases import LINE
from small_cases import SPHERE, case_error, write_case

from fretsolve.case.line_case import LineCase
from fretsolve.case.loading import load_case
from fretsolve.case.schema import case_schema, line_schema

ROUND_TRIPS = [
    LINE,
    LINE.replace("{cylinder: {radius: 10 mm}}", "[{punch: {half_width: 1}}, {cylinder: {radius: -20, center: 0.1}}]"),
    LINE.replace("{cylinder: {radius: 10 mm}}", "{heights: {file: a.h5, dataset: z, unit: um, spacing: 2 um}}"),
    LINE.replace(", size: 0.28 mm", ", size: auto") + "reference_depth: 10 mm\n",
    LINE + "  - {bulk_1: {xx: 10 MPa}, bulk_2: {xx: -1}, increments: 3}\n",
    LINE + "  - {cycle: {times: 2, stages: [{Qy: 3 N/m, My: 0.1 N mm/mm}]}}\n",
    LINE + "expect: [{quantity: work, value: 1 uJ/mm, abs: 1e-7}, {quantity: P, value: 1 kN/m, rel: 1 %, stage: 1}]\n",
]


@pytest.mark.parametrize("text", ROUND_TRIPS)
def test_effective_case_loads_as_an_equal_case(tmp_path, text):
    case = load_case(write_case(tmp_path, text))
    again = load_case(write_case(tmp_path, json.dumps(case.effective())))
    assert isinstance(case, LineCase)
    assert (again, again.effective(), again.stages()) == (case, case.effective(), case.stages())


@pytest.mark.parametrize("text", ROUND_TRIPS)
def test_schema_allows_it(tmp_path, text):
    schema = case_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    assert list(validator.iter_errors(yaml.safe_load(text))) == []
    assert list(validator.iter_errors(load_case(write_case(tmp_path, text)).effective())) == []


def test_loads_are_per_length(tmp_path):
    text = LINE.replace("Qx: 18 N/mm", "Qx: 18 kN/m, My: 2 N*m/m")
    case = load_case(write_case(tmp_path, text))
    assert dict(case.stages()[1].targets) == {"Qx": 18.0, "My": 2.0}
    assert case.grid.points == (64, 1)


MISTAKES = [
    ("{P: 100 N/mm}", "{P: 100 N}", "stage.1.P: '100 N' is a force; a force per length such as '100 N/mm' is"),
    ("cylinder: {radius: 10 mm}", "sphere: {radius: 1}", "surface.sphere: it makes no line contact; cylinder, punch"),
    ("cylinder: {radius: 10 mm}", "cone: {angle: 2 deg}", "surface.cone: it makes no line contact"),
    ("cylinder: {radius: 10 mm}", "ellipsoid: {radius_x: 1, radius_y: 2}", "surface.ellipsoid: it makes no line"),
    ("radius: 10 mm", "radius: 10 mm, axis: y", "surface.cylinder.axis: a line contact is endless along y"),
    ("cylinder: {radius: 10 mm}", "punch: {radius: 1}", "surface.punch.radius: no punch of a line contact is round"),
    ("points: 64", "points: [64, 64]", "grid.points: [64, 64] is a list; with plane: strain one value is needed"),
    ("size: 0.28 mm", "size: [1, 2]", "grid.size: [1, 2] is a list"),
    ("Qx: 18 N/mm", "Mx: 1", "stage.2.Mx: a line contact is the same all along y"),
    ("Qx: 18 N/mm", "phi_x: 1", "stage.2.phi_x: a line contact is the same all along y"),
    ("Qx: 18 N/mm", "Mz: 1", "stage.2.Mz: a line contact cannot turn about z"),
    ("Qx: 18 N/mm", "phi_z: 1", "stage.2.phi_z: a line contact cannot turn about z"),
    (
        "Qx: 18 N/mm",
        "delta_x: 1",
        "stage.2.delta_x: delta_x has an unknown constant in a line contact; give reference_depth, or impose Qx",
    ),
    ("Qx: 18 N/mm", "actuator_x: 1", "stage.2.actuator_x: no actuator without a rig; add rig: {stiffness_x: ...}"),
    (
        "friction: 0.3",
        "friction: 0.3\nrig: {stiffness_x: 5 kN/mm}",
        "rig.stiffness_x: '5 kN/mm' is a force per length; a stiffness per length such as '5 kN/mm^2' is needed",
    ),
    (
        "friction: 0.3",
        "friction: 0.3\nrig: {stiffness_y: 5 kN/mm^2}",
        "rig.stiffness_y: the motion along y is unknown in a line contact; remove it, or plane: strain",
    ),
    ("friction: 0.3", "friction: 0.3\nrig: {stiffness_phi_z: 5}", "rig.stiffness_phi_z: a line contact turns about y"),
    ("Qx: 18 N/mm", "delta_y: 1", "stage.2.delta_y: a displacement along y has an unknown constant"),
    ("Qx: 18 N/mm", "bulk_2: {yy: 1}", "stage.2.bulk_2.yy: in plane strain the stress along y follows from xx"),
    ("Qx: 18 N/mm", "bulk_1: {xy: 1, xx: 1}", "stage.2.bulk_1.xy: a line contact is the same all along y"),
    ("Qx: 18 N/mm", "bulk_2: {}", "stage.2.bulk_2: the bulk stress has no value; at least one of xx, yy, xy is"),
    ("{P: 100 N/mm}", "{delta_z: 1 um}", "stage.1.delta_z: delta_z has an unknown constant in a line contact; give"),
    ("plane: strain", "plane: stress", "plane: 'stress' is not allowed"),
    ("plane: strain\n", "", "stage.1.P: '100 N/mm' is a force per length; a force such as '400 N' is needed"),
    ("points: 64", "points: 8", "grid.points: 8 are too few for error bars; 16 or more per side are needed"),
    ("friction:", "coupling: tangential\nfriction:", "coupling: 'tangential' is not allowed"),
    ("friction: 0.3", "friction: {coefficient: [0.2, 0.1]}", "a line contact has one coefficient of friction"),
    ("plane:", "expect: [{quantity: work, value: 1 N/mm, rel: 1}]\nplane:", "'1 N/mm' is a force per length"),
]


@pytest.mark.parametrize(("right", "wrong", "says"), MISTAKES)
def test_mistakes_are_refused(tmp_path, right, wrong, says):
    assert right in LINE
    text = LINE.replace(right, wrong) + "solver: {error_bars: true}\n" * ("points: 8" in wrong)
    assert says in str(case_error(write_case(tmp_path, text)))


def test_a_contact_on_an_area_has_no_reference_depth(tmp_path):
    text = f"{SPHERE}reference_depth: 1 mm\nload_path: [{{P: 1}}]\n"
    assert "reference_depth: only a line contact needs it" in str(case_error(write_case(tmp_path, text)))


def test_other_keys_are_refused_by_the_schema():
    validator = jsonschema.Draft202012Validator(line_schema())
    case = yaml.safe_load(LINE)
    for stage in ({"Mx": 1.0}, {"phi_z": 1.0}, {"delta_y": 1.0}, {"actuator_phi_z": 1.0}):
        assert list(validator.iter_errors({**case, "load_path": [{"P": 1.0}, stage]}))
    assert list(validator.iter_errors({**case, "surface": {"sphere": {"radius": 1.0}}}))
