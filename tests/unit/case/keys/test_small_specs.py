"""The small mappings of a case file: solver, output, stress."""

from __future__ import annotations

import pytest
from pydantic import ValidationError
from small_cases import CASE, case_error, write_case

from fretsolve.case.keys.accuracy_spec import LEVELS
from fretsolve.case.keys.output_spec import StressSpec
from fretsolve.case.keys.settings_spec import SINGLE_TOLERANCE, SolverSpec
from fretsolve.case.loading import load_case


@pytest.mark.parametrize("name", LEVELS)
def test_a_name_stands_for_an_accuracy(name):
    assert SolverSpec.model_validate({"accuracy": name}).accuracy.target == LEVELS[name]


@pytest.mark.parametrize("value", ["50 %", "0.001 %", 30, 0.0, -1])
def test_values_without_a_meaning_in_per_cent_are_not_guessed(value):
    with pytest.raises(ValidationError) as caught:
        SolverSpec.model_validate({"accuracy": value})
    assert "did you mean" not in str(caught.value)


def test_single_precision_has_a_tolerance_of_its_own():
    assert SolverSpec.model_validate({"precision": "single"}).tolerance == SINGLE_TOLERANCE
    assert SolverSpec.model_validate({"precision": "single", "tolerance": 1e-5}).tolerance == 1e-5


def test_stresses_with_units():
    spec = StressSpec.model_validate({"bodies": [2, 1], "depths": ["0 mm", "5 um"], "every": "auto", "components": []})
    assert (spec.bodies, spec.depths, spec.every, spec.components) == ((2, 1), (0.0, pytest.approx(5e-3)), None, ())


@pytest.mark.parametrize(
    ("text", "key", "message"),
    [
        (
            "solver: {precision: single, tolerance: 1e-7}",
            "solver.tolerance",
            "1e-07 is less than single precision can certify; 1e-05 or more is needed, or precision: double",
        ),
        ("solver: {accuracy: rough}", "solver.accuracy", "'rough' is not allowed; draft, standard, reference or"),
        (
            "solver: {accuracy: 30 %}",
            "solver.accuracy",
            "'30 %' is out of range; a number >= 0.01 % and <= 20 % is needed",
        ),
        (
            "solver: {accuracy: 1}",
            "solver.accuracy",
            "1 is out of range; a number >= 0.01 % and <= 20 % is needed (did",
        ),
        ("solver: {accuracy: 0.5}", "solver.accuracy", "is needed (did you mean 0.5 %?)"),
        (
            "solver: {accuracy: {target: 1 %, of: [Qx, stick_radus]}}",
            "solver.accuracy.of.1",
            "'stick_radus' is not a quantity with an error bar; did you mean 'stick_radius'?",
        ),
        ("solver: {accuracy: {target: 1 %, of: [pressure]}}", "solver.accuracy.of.0", "did you mean 'max_pressure'?"),
        ("solver: {accuracy: {target: 1 %, of: [Qx, Qx]}}", "solver.accuracy.of.1", "'Qx' is named twice; once is"),
        (
            "solver: {accuracy: {target: 1 %, of: [wear_volume]}}",
            "solver.accuracy.of.0",
            "wear_volume is known with wear alone; the case has none",
        ),
        (
            "solver: {accuracy: {target: 1 %, of: [energy_ratio]}}",
            "solver.accuracy.of.0",
            "energy_ratio is a quantity of a cycle, and the load path has none; another one is needed",
        ),
        (
            "solver: {accuracy: {target: 1 %, at_most: {time: 10}}}",
            "solver.accuracy.at_most.time",
            "10 has no unit; a time such as '10 min' is needed",
        ),
        (
            "solver: {accuracy: {target: 1 %, at_most: {time: '600'}}}",
            "solver.accuracy.at_most.time",
            "'600' has no unit; a time such as '600 min' is needed",
        ),
        (
            "solver: {accuracy: {target: 1 %, at_most: 10 min}}",
            "solver.accuracy.at_most",
            "'10 min' is not a mapping; one with the keys time, cells is needed",
        ),
        (
            "solver: {accuracy: {of: [Qx]}}",
            "solver.accuracy.target",
            "missing; needed: largest error bar over the quantity's scale",
        ),
        (
            "solver: {accuracy: 1 %, error_bars: false}",
            "solver.error_bars",
            "without error bars nothing tells what a round is known to; leave the key out",
        ),
        ("solver: {refinement: 0}", "solver.refinement", "0 is out of range; a number > 0 and <= 1000 is needed"),
        ("solver: {max_iterations: 0}", "solver.max_iterations", "0 is too small; a whole number >= 1 is needed"),
        ("output: {fields: [pressure, gap, pressure]}", "output.fields.2", "'pressure' is named twice; once is enough"),
        ("output: {every: 2.5}", "output.every", "2.5 is not allowed; a whole number such as 10 is needed"),
        ("output: {stress: {bodies: [1, 1]}}", "output.stress.bodies.1", "1 is named twice; once is enough"),
        ("output: {stress: {depths: [-1 um]}}", "output.stress.depths.0", "-1 um"),
        ("output: {stress: {every: often}}", "output.stress.every", "'often' is not allowed; auto or a value such as"),
    ],
)
def test_wrong_values_are_named_with_their_line(tmp_path, text, key, message):
    error = case_error(write_case(tmp_path, CASE + text + "\n"))
    assert ".".join(map(str, error.key)) == key
    assert error.line == len(CASE.splitlines()) + 1
    assert message in error.message


def test_output_is_read_with_a_case(tmp_path):
    text = "output: {fields: [shear, pressure], every: 3, stress: {window: all, every: 2, components: [xz, xx]}}\n"
    output = load_case(write_case(tmp_path, CASE + text)).output
    assert (output.fields, output.every) == (("shear", "pressure"), 3)
    assert output.stress is not None
    assert (output.stress.window, output.stress.every, output.stress.components) == ("all", 2, ("xz", "xx"))
