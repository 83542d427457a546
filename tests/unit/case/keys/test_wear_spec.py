"""Wear in the case file, and cycles that represent others."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_cases import SPHERE, case_error, write_case

from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.case.loading import load_case

LAW = "{law: energy, alpha: 1e-4 mm^3/J}"
CYCLE = "{represents: 1e6, stages: [{Qx: -36 N}, {Qx: 36 N}]}"


def worn(folder: Path, wear: str = LAW, cycle: str = CYCLE, before: str = "{Qx: 36 N}", more: str = "") -> Path:
    text = SPHERE + (f"wear: {wear}\n" if wear else "")
    return write_case(folder, f"{text}load_path:\n  - {{P: 400 N}}\n  - {before}\n  - cycle: {cycle}\n{more}")


def test_energy_law(tmp_path):
    case = load_case(worn(tmp_path))
    assert case.wear is not None
    assert (case.wear.law, case.wear.alpha, case.wear.share) == ("energy", pytest.approx(1e-7), (0.5, 0.5))
    assert {stage.cycle.jumps for stage in case.stages() if stage.cycle} == {WearJumps(1e6, None, 0.01, None)}


@pytest.mark.parametrize("unit", ["mm^3/(N*mm)", "mm^3/(N mm)", "mm^3/N/mm", "mm²/N", "1000 mm^3/(N*m)", "1e9 um^3/mJ"])
def test_units_of_archards_coefficient(tmp_path, unit):
    number, _, unit = unit.rpartition(" ") if unit[0] == "1" else ("1", "", unit)
    case = load_case(worn(tmp_path, f"{{law: archard, k: {float(number) * 1e-7} {unit}, share: [1, 0]}}"))
    assert case.wear is not None
    assert (case.wear.k, case.wear.share) == (pytest.approx(1e-7), (1.0, 0.0))


def test_jumps_of_a_cycle(tmp_path):
    cycle = "{represents: 1e5, jump: 500, tolerance: 2 %, max_depth: 50 nm, amplitude: {delta_x: 1 um}}"
    stages = load_case(worn(tmp_path, cycle=cycle)).stages()
    assert [stage.cycle is None for stage in stages[:5]] == [True, True, True, False, False]
    assert stages[3].cycle is not None
    assert stages[3].cycle.jumps == WearJumps(1e5, 500.0, 0.02, pytest.approx(5e-5))
    assert dict(stages[2].targets) == {"delta_x": pytest.approx(1e-3)}


def test_cycles_of_one_block(tmp_path):
    """Each innermost cycle has its own number of represented cycles."""
    small = "{cycle: {represents: 10, stages: [{Qx: 12 N}, {Qx: 36 N}]}}"
    case = load_case(worn(tmp_path, cycle=f"{{times: 2, stages: [{{cycle: {CYCLE}}}, {small}]}}"))
    jumps = [stage.cycle.jumps for stage in case.stages() if stage.cycle]
    assert list(dict.fromkeys(jumps)) == [WearJumps(1e6, None, 0.01, None), WearJumps(10.0, None, 0.01, None)]


def test_many_cycles_that_choose_their_jumps_fit_in_a_path(tmp_path):
    alone = load_case(worn(tmp_path)).stages()
    assert max(stage.cycle.turn for stage in alone if stage.cycle) == 1000
    blocks = f"{{times: 50, stages: [{{P: 300 N}}, {{P: 400 N}}, {{cycle: {CYCLE}}}]}}"
    stages = load_case(worn(tmp_path, cycle=blocks)).stages()
    assert max(stage.cycle.turn for stage in stages if stage.cycle) == 100
    assert len({stage.cycle.cycle for stage in stages if stage.cycle}) == 50
    assert len(stages) == 2 + 50 * (2 + 3 * 100)


def test_too_many_given_jumps_are_refused_by_their_number(tmp_path):
    error = case_error(worn(tmp_path, cycle="{represents: 1e9, jump: 1000, stages: [{Qx: -36 N}, {Qx: 36 N}]}"))
    assert error.message.endswith("; 1e+06 jumps are too many, give a larger jump, or jump: auto")
    assert error.exit_code == 2


@pytest.mark.parametrize(
    ("wear", "message"),
    [
        ("{law: energy, alpha: -1e-4 mm^3/J}", "wear.alpha: '-1e-4 mm^3/J' is out of range; a wear coefficient > 0"),
        ("{law: energy, alpha: 0}", "wear.alpha: 0 is out of range; a wear coefficient > 0 mm^3/(N mm) is needed"),
        ("{law: energy, alpha: .inf}", "wear.alpha: inf is not finite"),
        ("{law: energy, alpha: 3 MPa}", "wear.alpha: '3 MPa' is a pressure; a wear coefficient such as '1e-4 mm^3/J'"),
        ("{law: energy}", "wear.alpha: missing; needed: worn volume of both bodies per dissipated energy"),
        ("{law: archard}", "wear.k: missing; needed: worn volume of both bodies per normal force and path of slip"),
        ("{law: energy, k: 1e-7}", "wear.k: k belongs to law: archard; alpha is the coefficient of energy"),
        ("{law: archard, alpha: 1}", "wear.alpha: alpha belongs to law: energy; k is the coefficient of archard"),
        ("{law: energy, alpha: 1, exponent: 2}", "wear.exponent: exponent belongs to law: archard"),
        ("{law: archard, k: 1, exponent: 2}", "wear: exponent and reference_pressure belong together"),
        ("{law: reye, alpha: 1}", "wear.law: 'reye' is not a law of wear; energy or archard is needed"),
        ("{alpha: 1}", "wear.law: missing; needed: energy, depth = alpha"),
        ("{law: energy, alpha: 1, share: [0.5, 0.6]}", "wear.share: 0.5 and 0.6 add up to 1.1; 1 is needed"),
        ("{law: energy, alpha: 1, share: [-0.5, 1.5]}", "wear.share.0: -0.5 is out of range; a number >= 0 and <= 1"),
        ("{law: energy, alpha: 1, share: [1]}", "wear.share: [1] has the wrong number of entries; 2 are needed"),
        ("1e-4 mm^3/J", "wear: '1e-4 mm^3/J' is not a mapping; one with the keys law, alpha, "),
    ],
)
def test_mistakes_of_the_law(tmp_path, wear, message):
    path = worn(tmp_path, wear)
    error = case_error(path)
    assert str(error).startswith(f"{path}:{SPHERE.count(chr(10)) + 1}: {message}")
    assert error.exit_code == 2


@pytest.mark.parametrize(
    ("cycle", "message"),
    [
        ("{represents: 0, stages: [{Qx: 36 N}]}", ".represents: 0 is out of range; a number >= 1 is needed"),
        ("{represents: -5, stages: [{Qx: 36 N}]}", ".represents: -5 is out of range"),
        ("{represents: 2.5, stages: [{Qx: 36 N}]}", ".represents: 2.5 is not a whole number of cycles"),
        ("{represents: 10, jump: 20, stages: [{Qx: 36 N}]}", ".jump: 20 cycles are more than the 10 that the cycle"),
        ("{represents: 10, jump: 0.5, stages: [{Qx: 36 N}]}", ".jump: 0.5 is out of range; a number >= 1"),
        ("{represents: 10, jump: soon, stages: [{Qx: 36 N}]}", ".jump: 'soon' has no number; a number such as '1000'"),
        ("{represents: 10, times: 3, stages: [{Qx: 36 N}]}", ".times: times and represents exclude each other"),
        ("{represents: 10, until: periodic, stages: [{Qx: 1 N}]}", ".until: until and represents exclude each other"),
        ("{represents: 10, at_most: 3, stages: [{Qx: 1 N}]}", ".at_most: at_most and represents exclude each other"),
        ("{represents: 10, max_depth: 0, stages: [{Qx: 1 N}]}", ".max_depth: 0 is out of range; a length > 0 mm"),
        ("{times: 3, jump: 2, stages: [{Qx: 36 N}]}", ".jump: only represents takes it; remove it, or add represents"),
        ("{times: 3, max_depth: 2, stages: [{Qx: 36 N}]}", ".max_depth: only represents takes it"),
        (f"{{represents: 3, stages: [{{cycle: {CYCLE}}}]}}", ".represents: its stages hold cycles, of which each may"),
        (
            "{represents: 10, stages: [{Qx: -36 N}, {Qx: 35 N}]}",
            ": a cycle that represents others has to close, but Qx is 36 N before it and 35 N at its end; a stage"
            " {Qx: 35 N} before it would do",
        ),
        (
            "{represents: 10, stages: [{Qx: 36 N}, {P: 0 N}]}",
            ": a cycle that represents others has to close, but P is 400 N before it and 0 N at its end; let it begin"
            " and end where the bodies are pressed together",
        ),
        (
            "{represents: 10, stages: [{Qx: -36 N}, {delta_x: 1 um}]}",
            ": a cycle that represents others has to close, but delta_x is imposed in it alone and 0.001 mm at its end",
        ),
        (
            "{represents: 10, stages: [{bulk_2: {xx: 70}}]}",
            ": a cycle that represents others has to close, but bulk_2_xx is 0 MPa before it and 70 MPa at its end;"
            " a stage {bulk_2: {xx: 70 MPa}} before it would do",
        ),
        (
            "{represents: 10, stages: [{Qx: -36 N}, {Qx: 36 N, friction: 0.2}]}",
            ": a cycle that represents others has to close, but friction is 0.1 before it and 0.2 at its end",
        ),
    ],
)
def test_mistakes_of_the_cycle(tmp_path, cycle, message):
    path = worn(tmp_path, cycle=cycle)
    error = case_error(path)
    assert str(error).startswith(f"{path}:{SPHERE.count(chr(10)) + 5}: load_path.2.cycle{message}")
    assert error.exit_code == 2


def test_a_cycle_that_ends_without_load_is_refused_where_the_load_stands(tmp_path):
    cycle = "\n      represents: 10\n      stages: [{P: 400 N}, {Qx: 20 N}, {Qx: 0 N},\n        {P: 0 N}]"
    path = worn(tmp_path, cycle=cycle, before="{P: 0 N}")
    error = case_error(path)
    line = next(number for number, text in enumerate(path.read_text().splitlines(), start=1) if "        {P:" in text)
    assert str(error).startswith(f"{path}:{line}: stage.6.P: at its end the cycle changes the")
    assert error.exit_code == 2
    # held at 0 from before the cycle
    path = worn(tmp_path, cycle="{represents: 10, stages: [{Qx: 0.0}]}", before="{P: 0 N}")
    assert str(case_error(path)).startswith(f"{path}:{SPHERE.count(chr(10)) + 4}: stage.2.P: at its end")


def test_represents_needs_wear(tmp_path):
    message = case_error(worn(tmp_path, wear="")).message
    assert message == (
        "only wear makes a cycle stand for others; add wear: {law: energy, alpha: 1e-4 mm^3/J}, or give times"
    )


def test_wear_needs_friction(tmp_path):
    path = worn(tmp_path)
    path.write_text(path.read_text().replace("friction: 0.1", "friction: 0"))
    assert case_error(path).message == "friction is 0, so that nothing is dissipated; friction above 0 is needed"
