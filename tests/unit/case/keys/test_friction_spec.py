"""Friction in the case file."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_cases import CASE, case_error, write_case

from fretsolve.case.loading import load_case

PLACE = "friction: 0.1"


def friction(folder: Path, text: str) -> Path:
    return write_case(folder, CASE.replace(PLACE, f"friction: {text}"))


def test_a_number_is_a_coefficient(tmp_path):
    case = load_case(friction(tmp_path, "20 %"))
    assert (case.friction.coefficient, case.friction.is_constant, case.friction_varies) == (0.2, True, False)
    assert case.effective()["friction"] == {"coefficient": 0.2}


def test_what_varies_is_known(tmp_path):
    for text in ("{coefficient: 0.1, shear_limit: 1 MPa}", "{expression: '0.1'}", "{coefficient: [0.2, 0.1]}"):
        assert load_case(friction(tmp_path, text)).friction_varies
    staged = CASE.replace("{Qx: 20 N, increments: 4}", "{friction: 0.05}").replace("stage: 1", "stage: 2")
    case = load_case(write_case(tmp_path, staged))
    assert case.friction_varies
    assert case.stages()[1].targets == (("friction", 0.05),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", "friction.coefficient: missing; needed: coefficient of friction, such as 0.1"),
        ("{shear_limit: 3 MPa}", "friction.coefficient: missing; needed: "),
        ("{final: 0.3, slip: 1 mm}", "friction.final: final belongs to initial, which is not given; give it as well"),
        (
            "[0.2, 0.1]",
            "friction: a list stands below a key, as {coefficient: [0.2, 0.1]} along two axes; name the key",
        ),
        ("{coefficient: -0.1}", "friction.coefficient: -0.1 is out of range; a number >= 0 is needed"),
        ("{coefficient: .nan}", "friction.coefficient: nan is not finite"),
        ("{coefficient: .inf}", "friction.coefficient: inf is not finite"),
        ("{coefficient: [0.1]}", "friction.coefficient: [0.1] has the wrong number of entries; 2 are needed"),
        ("{coefficient: [0.1, 0]}", "friction.coefficient.1: 0 is out of range; a number > 0 is needed"),
        ("{coefficient: 0.1, shear_limit: 0 MPa}", "friction.shear_limit: '0 MPa' is out of range; a pressure > 0"),
        ("{coefficient: 0.1, expression: '1'}", "friction.expression: coefficient and expression cannot be given"),
        ("{coefficient: 0.1, spacing: 1 um}", "friction.spacing: spacing belongs to map, which is not given"),
        ("{coefficient: 0.1, angle: 3 deg}", "friction.angle: angle belongs to two coefficients"),
        (
            "{coefficient: [0.1, 0.2], angle: 30}",
            "friction.angle: 30 rad is more than a turn; write '30 deg' if so meant",
        ),
        ("{coefficient: [0.1, 0.2], shear_limit: 9}", "friction: two coefficients cannot stand beside shear_limit"),
        ("{coefficient: 0.1, exponent: 0.5}", "friction: exponent and reference_pressure belong together"),
        (
            "{coefficient: 0.1, exponent: 0, reference_pressure: 1}",
            "friction.exponent: 0 is out of range; a number > 0",
        ),
        ("{initial: 0.1, slip: 1 mm}", "friction: initial is given without final"),
        ("{initial: 0.1, final: 0.2}", "friction: either slip or energy is needed beside initial and final"),
        ("{initial: 0.1, final: 0.2, slip: 1, energy: 1}", "friction: either slip or energy is needed"),
        ("{initial: 0.1, final: 0.2, slip: 0 mm}", "friction.slip: '0 mm' is out of range; a length > 0 mm"),
        ("{cycles: []}", "friction.cycles: [] has the wrong number of entries"),
        ("{cycles: [[5, 0.1], [5, 0.2]]}", "friction.cycles.1.0: the cycles do not ascend"),
        ("{cycles: [[1, -1]]}", "friction.cycles.0.1: -1 is out of range"),
        ("{expression: 'q'}", "friction.expression: 'q': 'q' is not allowed; numbers, "),
        ("{map: 3}", "friction.map: 3 is not the name of a file; one such as 'mu.npy' is needed"),
        (
            "{velocity: 3}",
            "friction.velocity: unknown key 'velocity'; the solution is quasi-static, without velocity, time",
        ),
        ("{mu: 0.1}", "friction.mu: unknown key 'mu'; the coefficient of friction is 'coefficient'"),
    ],
)
def test_mistakes(tmp_path, text, message):
    path = friction(tmp_path, text)
    error = case_error(path)
    assert str(error).startswith(f"{path}:{CASE[: CASE.index(PLACE)].count(chr(10)) + 1}: {message}")
    assert error.exit_code == 2


def test_a_stage_changes_one_coefficient_alone(tmp_path):
    text = CASE.replace(PLACE, "friction: {expression: '0.1'}").replace("{Qx: 20 N, increments: 4}", "{friction: 0.05}")
    error = case_error(write_case(tmp_path, text))
    assert error.message == "a stage can change friction only where it is one coefficient; remove it here"
    assert error.key == ("stage", 2)
