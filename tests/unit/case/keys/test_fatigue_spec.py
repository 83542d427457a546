"""`output.fatigue` in the case file: what is read, and what is refused with its line and key."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_cases import TWO_CYCLES, case_error, write_case

from fretsolve.case.keys.output_spec import FatigueSpec
from fretsolve.case.loading import load_case

MATERIAL = "    material: {tension_limit: 300 MPa, torsion_limit: 190 MPa}\n"
CRITERIA = "    criteria: [findley, swt]\n"
BOTH = MATERIAL + CRITERIA


def asked(folder: Path, keys: str, before: str = TWO_CYCLES) -> Path:
    """Write a case whose `output.fatigue` has these keys, the first of them in line 14."""
    return write_case(folder, f"{before}output:\n  fatigue:\n{keys}")


def spec_of(folder: Path, keys: str) -> FatigueSpec:
    spec = load_case(asked(folder, keys)).output.fatigue
    assert spec is not None
    return spec


def test_material_and_criteria_are_enough(tmp_path):
    spec = spec_of(tmp_path, BOTH)
    assert (spec.material.tension_limit, spec.material.torsion_limit) == (300.0, 190.0)
    assert spec.criteria == ("findley", "swt")
    assert (spec.average, spec.bodies, spec.depths) == (None, (), ())


def test_the_material_may_be_a_file_beside_the_case(tmp_path):
    (tmp_path / "steel.yaml").write_text("tension_limit: 0.3 GPa\n")
    assert spec_of(tmp_path, "    material: steel.yaml\n" + CRITERIA).material.tension_limit == pytest.approx(300.0)


def test_bodies_and_depths(tmp_path):
    spec = spec_of(tmp_path, BOTH + "    bodies: [1, 2]\n    depths: [0 mm, 20 um]\n")
    assert (spec.bodies, spec.depths) == ((1, 2), (0.0, pytest.approx(0.02)))


@pytest.mark.parametrize("kind", ["point", "line", "volume"])
def test_an_average_of_each_kind(tmp_path, kind):
    average = spec_of(tmp_path, BOTH + f"    average: {{{kind}: 40 um}}\n").average
    assert average is not None
    assert (average.kind, average.length) == (kind, pytest.approx(0.04))


@pytest.mark.parametrize(
    ("keys", "line", "message"),
    [
        (CRITERIA, 13, "material: missing; needed: constants of the material, or the name of a file of them"),
        (MATERIAL, 13, "criteria: missing"),
        (BOTH + "    every: 2\n", 16, "every: unknown key 'every'; one of cycle, blocks, material"),
        (MATERIAL + "    criteria: []\n", 15, "criteria: [] has the wrong number of entries; at least 1 is needed"),
        (MATERIAL + "    criteria: [findly]\n", 15, "criteria.0: 'findly' is not allowed; did you mean 'findley'?"),
        (MATERIAL + "    criteria: [swt, swt]\n", 15, "criteria.1: 'swt' is named twice; once is enough"),
        (
            MATERIAL + "    criteria: swt\n",
            15,
            "criteria: 'swt' is not allowed; a list such as [crossland, swt] is needed",
        ),
        (BOTH + "    average: {}\n", 16, "average: one of point, line, volume is needed, such as {point: 20 um}; none"),
        (BOTH + "    average: {point: 2 um, line: 2 um}\n", 16, "such as {point: 20 um}; point and line are given"),
        (BOTH + "    average: 20 um\n", 16, "average: '20 um' is not a mapping; one with the keys point, line, volume"),
        (BOTH + "    average: {point: 0 um}\n", 16, "average.point: '0 um' is out of range; a length > 0 mm is needed"),
        (BOTH + "    average: {line: 2 N}\n", 16, "average.line: '2 N' is a force; a length such as '10 mm' is needed"),
        (BOTH + "    bodies: [3]\n", 16, "bodies.0: 3 is not allowed; one of 1, 2 is needed"),
        (BOTH + "    bodies: [2, 2]\n", 16, "bodies.1: 2 is named twice; once is enough"),
        (BOTH + "    depths: [-1 um]\n", 16, "depths.0: '-1 um' is out of range; a length >= 0 mm is needed"),
        (BOTH + "    depths: [0, 0 mm]\n", 16, "depths.1: 0.0 is named twice; once is enough"),
        (
            BOTH + "    depths: [0]\n    average: {volume: 20 um}\n",
            16,
            "depths: an average has depths of its own; remove one of the two",
        ),
        (
            CRITERIA + "    material: {tension_limit: 0 MPa}\n",
            15,
            "material.tension_limit: '0 MPa' is out of range; a pressure > 0 MPa is needed",
        ),
        (
            CRITERIA + "    material: {tensoin_limit: 300 MPa}\n",
            15,
            "material.tensoin_limit: unknown key 'tensoin_limit'; did you mean 'tension_limit'?",
        ),
        (
            CRITERIA + "    material: {strain_life: {strength: 900 MPa, strength_exponent: 0.1}}\n",
            15,
            "material.strain_life.strength_exponent: 0.1 is out of range; a number >= -2 and < 0 is needed",
        ),
        (CRITERIA + "    material: none.yaml\n", 15, "material: FOLDER/none.yaml: cannot be read"),
    ],
)
def test_mistakes(tmp_path, keys, line, message):
    path = asked(tmp_path, keys)
    says = str(case_error(path))
    assert says.startswith(f"{path}:{line}: output.fatigue.")
    assert message.replace("FOLDER", str(tmp_path)) in says


@pytest.mark.parametrize(
    ("before", "message"),
    [
        (
            TWO_CYCLES.replace("  - {young_modulus: 200 GPa, poisson_ratio: 0.3}\n", "  - rigid\n", 1),
            "16: output.fatigue.bodies.0: body 1 is rigid, so that it has no stress; leave it out",
        )
    ],
)
def test_what_the_rest_of_the_case_must_have(tmp_path, before, message):
    path = asked(tmp_path, BOTH + "    bodies: [1]\n", before)
    assert message in str(case_error(path))


def test_the_tractions_must_be_stored(tmp_path):
    path = asked(tmp_path, BOTH + "  fields: [pressure, slip]\n")
    assert "output.fatigue: stresses follow from pressure and shear; output.fields needs shear" in str(case_error(path))
