"""What a study varies and compares, and what is wrong with either."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from command_line import refused
from small_cases import LOOP, TWO_CYCLES, write_case
from studying import EVERY, EXPECT, plan_of

from fretsolve import load_case
from fretsolve.errors import CaseError
from fretsolve.simulation.problem_setup import set_up
from fretsolve.sweep.quantity import StageQuantity, listed, usual_quantities
from fretsolve.sweep.study.plan import finest, read_variation, short, words


@pytest.mark.parametrize(
    ("text", "key", "values"),
    [
        ("grid.points=32,64", "grid.points", ("32", "64")),
        ("grid.points = [32, 64] , 64", "grid.points", ("[32, 64]", "64")),
        ("surface={sphere: {radius: 1, center: [0, 0]}},{cone: {angle: 0.1}}", "surface", None),
        ("title='a, b',\"c,d\"", "title", ("'a, b'", '"c,d"')),
        ("friction=0.1", "friction", ("0.1",)),
        (f"{EVERY}=5,auto", EVERY, ("5", "auto")),
    ],
)
def test_values_are_split_outside_of_brackets(text: str, key: str, values: tuple[str, ...] | None) -> None:
    read_key, read_values = read_variation(text)
    assert read_key == key
    assert read_values == (values or ("{sphere: {radius: 1, center: [0, 0]}}", "{cone: {angle: 0.1}}"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("grid.points", "KEY=A,B,C is needed"),
        ("=3", "KEY=A,B,C is needed"),
        ("grid..points=3", "KEY=A,B,C is needed"),
        ("grid.points=", "KEY=A,B,C is needed"),
        ("grid.points=3,,4", "a value is missing"),
        ("grid.points=3,", "a value is missing"),
        ("grid.points=3,4,3", "the value 3 is given twice"),
        ("load_path.*.*=3", r"\* stands for every stage"),
    ],
)
def test_what_is_no_variation(text: str, message: str) -> None:
    with pytest.raises(CaseError, match=message) as caught:
        read_variation(text)
    assert str(caught.value).startswith(f"--vary {text}: ")


@pytest.mark.parametrize(
    ("varied", "message"),
    [
        (["grid.points=8", "grid.points=10"], "--vary grid.points=10: grid.points: the key is varied twice"),
        (
            ["load_path.1.Qx=20 N", "stage.2.Qx=30 N"],
            "--vary stage.2.Qx=30 N: stage.2.Qx: load_path.1.Qx and stage.2.Qx are the same key; keep one of the two",
        ),
    ],
)
def test_a_key_is_varied_once(varied: list[str], message: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=re.escape(message)):
        plan_of(tmp_path, varied)


def test_one_stage_may_differ_from_every_stage(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, [f"{EVERY}=3,7", "load_path.0.increments=1"])
    assert [case.setup.load_path.counts for case in plan.cases] == [(1, 7, 7, 7), (1, 3, 3, 3)]


def test_all_combinations(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,16", f"{EVERY}=1,5", "solver.tolerance=1e-2"])
    assert sorted(short(case.settings) for case in plan.cases) == [
        "16, 1, 1e-2",
        "16, 5, 1e-2",
        "8, 1, 1e-2",
        "8, 5, 1e-2",
    ]
    assert words(plan.cases[0].settings) == "16 x 16, 5 increments per stage, tolerance 1e-2"
    assert words({EVERY: "1"}) == "1 increment per stage"
    assert words({"grid.points": "512"}, line=True) == "512 points"
    assert words({"grid.points": "[8, 16]"}) == "8 x 16"
    assert words({"load_path.1.increments": "5"}) == "5 increments in load_path.1"


def test_every_stage_is_also_that_within_cycles(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, [f"{EVERY}=3,7"])
    assert [stage.increments for stage in plan.cases[0].setup.case.stages()] == [7, 7, 7, 7]
    assert [case.setup.load_path.increments for case in plan.cases] == [28, 12]


@pytest.mark.parametrize(
    ("varied", "message"),
    [
        ("grid.points=8,0", "--vary grid.points=0: grid.points: 0 is too small"),
        ("grid.pints=8", "--vary grid.pints=8: grid.pints: unknown key 'pints'; did you mean 'points'?"),
        (f"{EVERY}=1,x", f"--vary {EVERY}=x: stage.*.increments: 'x' is not allowed"),
        ("load_path.9.increments=1", "--vary load_path.9.increments=1: load_path.9.increments: the list has no entry"),
        ("grid.points=8,1000000", "--vary grid.points=1000000: grid.points: 1000000 x 1000000 cells take"),
        ("surface={cylinder: {radius: 1}}", "--vary surface={cylinder: {radius: 1}}: surface.cylinder.axis: missing"),
    ],
)
def test_invalid_values_before_anything_runs(varied: str, message: str, tmp_path: Path) -> None:
    assert refused(2, "study", write_case(tmp_path, LOOP), "--vary", varied).startswith(message)
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


def test_invalid_case_is_its_own_fault(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP.replace("friction: 0.1", "friction: -1"))
    assert refused(2, "study", case, "--vary", "grid.points=8").startswith(f"{case}:7: friction")


def setup_of(folder: Path, text: str = LOOP, *overrides: str) -> Any:
    return set_up(load_case(write_case(folder, text), overrides))


def names(quantities: Sequence[StageQuantity]) -> list[str]:
    return [str(quantity) for quantity in quantities]


def test_usual_quantities_are_moved_or_expected_and_not_imposed(tmp_path: Path) -> None:
    usual = ["delta_z@4", "delta_x@4", "contact_radius@4", "stick_radius@4", "max_pressure@4", "work_total@4"]
    assert names(usual_quantities(setup_of(tmp_path))) == usual
    expected = [*usual[:1], "delta_x@2", *usual[1:]]
    assert names(usual_quantities(setup_of(tmp_path, LOOP + EXPECT))) == expected
    driven = LOOP.replace("Qx: 18 N", "delta_x: 1 um")
    assert names(usual_quantities(setup_of(tmp_path, driven)))[:2] == ["Qx@4", "delta_z@4"]
    smooth = names(usual_quantities(setup_of(tmp_path, LOOP, "friction=0")))
    assert "stick_radius@4" not in smooth


def test_quantities_are_judged_at_the_ends_of_all_stages(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8"], quantities=["work_total", "delta_x@2"])
    assert names(plan.quantities) == ["delta_x@2", "work_total@1", "work_total@2", "work_total@3", "work_total@4"]
    usual = [name for name in names(plan_of(tmp_path, ["grid.points=8"]).quantities) if name.startswith("delta_z")]
    assert usual == ["delta_z@1", "delta_z@2", "delta_z@3", "delta_z@4"]
    driven = LOOP.replace("Qx: 36 N", "delta_x: 1 um")  # and Qx in the cycle: what is imposed has no error
    found = names(plan_of(tmp_path, ["grid.points=8"], text=driven).quantities)
    assert [name for name in found if "x@" in name] == ["Qx@2", "delta_x@1", "delta_x@3", "delta_x@4"]


def test_of_a_repeated_cycle_the_last_repetition_is_judged(tmp_path: Path) -> None:
    cycles = ["delta_x", "dissipated_energy", "dissipated_energy@1"]
    plan = plan_of(tmp_path, ["grid.points=8"], text=TWO_CYCLES, quantities=cycles)
    delta_x = ["delta_x@1", "delta_x@2", "delta_x@5", "delta_x@6"]
    assert names(plan.quantities) == [*delta_x, "dissipated_energy@1", "dissipated_energy"]
    assert listed(plan.quantities) == "delta_x (stages 1-2,5-6), dissipated_energy (cycle 1 and last cycle)"
    assert names(plan_of(tmp_path, ["grid.points=8"], text=TWO_CYCLES, quantities=["delta_x@3"]).quantities) == [
        "delta_x@3"
    ]


@pytest.mark.parametrize(
    ("quantity", "message"),
    [
        ("delta_q", "'delta_q' is not a quantity that can be compared; did you mean 'delta_z'?"),
        ("wall_time", "'wall_time' is not a quantity"),
        (
            "stick_radius_corrected_error",
            "stick_radius is not corrected for the number of increments; use stick_radius",
        ),
        ("wear_volume_error", "did you mean 'wear_volume'?"),
        ("delta_x_error", "error bars stand beside their values; use delta_x"),
        ("stick_radius_corrected@1", "stick_radius is not corrected for the number of increments; use stick_radius"),
        ("work", "'work' is not a quantity that can be compared"),
        ("delta_x@5", "there is no stage '5'; one from 1 to 4"),
        ("delta_x@0", "there is no stage '0'"),
        ("delta_x@", "there is no stage ''"),
    ],
)
def test_what_is_no_quantity(quantity: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=message) as caught:
        plan_of(tmp_path, ["grid.points=8"], quantities=[quantity])
    assert str(caught.value).startswith(f"--quantity {quantity}: ")


def test_finest_has_most_points_then_increments_then_terms_then_the_least_tolerance(tmp_path: Path) -> None:
    varied = ["solver.tolerance=1e-6,1e-3", f"{EVERY}=5,1", "coupling=tangential,none", "grid.points=16,8"]
    plan = plan_of(tmp_path, varied)
    assert short(plan.cases[0].settings) == "1e-6, 5, tangential, 16"
    assert short(finest(plan.cases[1:]).settings) == "1e-3, 5, tangential, 16"
    told = "tolerance 1e-6, 5 increments per stage, coupling tangential, 16 x 16"
    assert plan.reference_words == f"the finest run, {told}"
    seconds = [case.expected.seconds for case in plan.cases[1:]]
    assert seconds == sorted(seconds)


def test_known_values_hold_for_one_problem(tmp_path: Path) -> None:
    words = ("--vary", "grid.points=8,10", "--vary", "friction=0.1,0.2", "--truth", "closed-form")
    told = refused(2, "study", write_case(tmp_path, LOOP), *words)
    assert told.startswith("--vary friction: changes the problem itself, and --truth closed-form holds for")
