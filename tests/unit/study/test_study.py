"""``fretsolve study``: what is varied, what the reference is, what is reused, and what comes out."""

from __future__ import annotations

import csv
import math
import re
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
from command_line import PATIENCE, finish, invoke, refused, start
from PIL import Image
from small_cases import LOOP, write_case

import fretsolve.commands.study as command
from fretsolve import load_case, open_result
from fretsolve.commands.messages.case_messages import CaseMessages
from fretsolve.errors import CaseError
from fretsolve.setup.problem_setup import set_up
from fretsolve.study.assessment import Assessment, assess, front
from fretsolve.study.plan import ReferenceKind, StudyPlan, finest, make_study_plan
from fretsolve.study.report import advice, two_digits
from fretsolve.study.variation import changes_the_problem, read_variation, short, words
from fretsolve.sweep.case_run import run_serially
from fretsolve.sweep.outcome import Outcome
from fretsolve.sweep.quantity import StageQuantity, usual_quantities
from fretsolve.sweep.status import missing

EXPECT = "expect: [{quantity: delta_x, value: 0.863748e-3 mm, rel: 1 %, stage: 2}, {quantity: Qx, value: 0, abs: 1}]\n"
BRIEF = ("--quantity", "delta_x", "--quantity", "delta_x@2", "--quantity", "work_total")
EVERY = "load_path.*.increments"


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """No picture, which takes longer than the runs of these tests."""
    monkeypatch.setattr(command, "_draw", lambda path, study, title: None)


def rows_of(folder: Path) -> list[dict[str, str]]:
    """``study.csv``."""
    with (folder / "study.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def runs_of(output: str) -> list[dict[str, str]]:
    """The lines of progress."""
    lines = [line for line in output.splitlines() if line.startswith("run=")]
    return [dict(word.split("=", 1) for word in line.split()) for line in lines]


# What is varied


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
        ("bodies.*.poisson_ratio=0.3", r"\* stands for every stage"),
        ("load_path.*=3", r"\* stands for every stage"),
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
        (
            ["solver.error_bars=true", "solver.error_estimate=true"],
            "solver.error_bars and solver.error_estimate are the same key",
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
        (f"{EVERY}=1,x", f"--vary {EVERY}=x: load_path.*.increments: 'x' is not allowed"),
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


# What is compared, and with what


def plan_of(
    folder: Path,
    varied: Sequence[str],
    *,
    text: str = LOOP,
    quantities: Sequence[str] = (),
    kind: ReferenceKind = "finest",
) -> StudyPlan:
    case = write_case(folder, text)
    return make_study_plan(case, (), varied, quantities, kind, folder / "case.study")


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


@pytest.mark.parametrize(
    ("quantity", "message"),
    [
        ("delta_q", "'delta_q' is not a quantity that can be compared; did you mean 'delta_z'?"),
        ("wall_time", "'wall_time' is not a quantity"),
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


def made_up(plan: StudyPlan, seconds: Sequence[float], values: Sequence[Sequence[float]]) -> Assessment:
    """A study of outcomes in the order of the plan's cases."""
    return assess(plan, [outcome(cost, row) for cost, row in zip(seconds, values, strict=True)])


def outcome(seconds: float, values: Sequence[float], peaks: Sequence[float] | None = None) -> Outcome:
    """The outcome of a run in one increment."""
    largest = np.abs(values if peaks is None else peaks)
    return Outcome(np.array(values), np.full(len(values), np.nan), 1, seconds, 1, largest)


def test_front() -> None:
    assert front([3.0, 1.0, 2.0, 2.0, 4.0], [1.0, 3.0, 2.0, 1.5, 1.0]) == [True, True, False, True, False]
    assert front([], []) == []


def test_errors_marks_and_advice(tmp_path: Path) -> None:
    quantities = ["delta_x", "stick_radius", "work_total"]
    plan = plan_of(tmp_path, ["grid.points=8,16,24,32,40"], quantities=quantities)
    values = [[2.0, 1.0, 4.0], [1.9, 1.0, 4.0], [2.01, 1.1, 4.0], [2.0, 0.995, 4.02], [2.0, 1.0, 5.0]]
    study = made_up(plan, [10.0, 1.0, 2.0, 5.0, 20.0], values)
    assert [row.outcome.seconds for row in study.rows] == [1.0, 2.0, 5.0, 10.0, 20.0]
    np.testing.assert_allclose([row.worst for row in study.rows], [0.05, 0.1, 0.005, np.nan, 0.25])
    assert [row.best for row in study.rows] == [True, False, True, False, False]
    assert [row.is_reference for row in study.rows] == [False, False, False, True, False]
    first, second, third = advice(study)
    assert first == (
        "for 1 %: 24 x 24: stick_radius within 0.50 %, work_total within 0.50 %, delta_x within 0 %;"
        " 5.0 s, 2.0 times cheaper than the finest run"
    )
    assert second.startswith("for 1 % in all but stick_radius (10 %): 16 x 16: delta_x within 0.50 %")
    assert third.startswith("for 0.1 %: no other run meets it; the nearest is 24 x 24")


def test_errors_of_components_refer_to_their_largest_value(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,16"], quantities=["delta_x", "work_total"])
    study = assess(plan, [outcome(1.0, values, [2.0, 8.0]) for values in ([0.1, 4.0], [0.3, 3.0])])
    np.testing.assert_allclose(study.scales, [2.0, 4.0])
    np.testing.assert_allclose(next(row for row in study.rows if row.compared).errors, [0.1, 0.25])


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (0.1, "0.10"), (1.23, "1.2"), (9.96, "10"), (1234.5, "1234"), (1.2e-6, "1.2e-06"), (math.nan, "-")],
)
def test_two_digits(value: float, text: str) -> None:
    assert two_digits(value) == text


# The command


def test_study_and_its_files(tmp_path: Path, undrawn: None) -> None:
    case = write_case(tmp_path, LOOP)
    result = invoke("study", case, "--vary", "grid.points=8,12", "--vary", "solver.tolerance=1e-2,1e-6", *BRIEF)
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert lines[:3] == ["loop", f"results: {tmp_path / 'case.study'}", "4 cases of grid.points, solver.tolerance"]
    assert lines[3] == "reference: the finest run, 12 x 12, tolerance 1e-6"
    runs = runs_of(result.stdout)
    assert [run["run"] for run in runs] == ["1", "2", "3", "4"]
    assert (runs[0]["grid.points"], runs[0]["solver.tolerance"], runs[0]["increments"]) == ("12", "1e-6", "4")
    assert "coupling: none leaves out ux from qy" in result.stderr
    rows = rows_of(tmp_path / "case.study")
    assert sorted(float(row["time (s)"]) for row in rows) == [float(row["time (s)"]) for row in rows]
    (truth,) = [row for row in rows if row["role"] == "reference"]
    assert truth["worst error (%)"] == ""
    with open_result(tmp_path / "case.study" / truth["result"]) as solved:
        assert solved.fields == ()
        assert float(truth["delta_x@2 (mm)"]) == pytest.approx(solved.history["delta_x"][1], rel=1e-9)
        assert float(truth["time (s)"]) == pytest.approx(solved.history["wall_time"].sum(), rel=1e-5)
        scale = np.abs(solved.history["delta_x"]).max()
    other = next(row for row in rows if row["role"] != "reference")
    off = abs(float(other["delta_x@2 (mm)"]) - float(truth["delta_x@2 (mm)"])) / scale
    assert float(other["error of delta_x@2 (%)"]) == pytest.approx(100.0 * off, rel=1e-4)
    assert any(row["role"] == "best" for row in rows)
    with h5py.File(tmp_path / "case.study/study.h5") as file:
        assert file["values/work_total@4"].attrs["units"] == "mJ"
        np.testing.assert_allclose(100.0 * file["errors/delta_x@2"][:], percentages(rows, "delta_x@2"), rtol=1e-8)
        assert [name.decode() for name in file["result"]] == [row["result"] for row in rows]
        assert file["settings/solver.tolerance"][:].astype(str).tolist() == [row["solver.tolerance"] for row in rows]
        assert file["cost/time"].attrs["units"] == "s"
        assert file["truth"] == file["reference"]  # its name before
        assert file.attrs["truth"] == file.attrs["reference"] == "the finest run, 12 x 12, tolerance 1e-6"
        assert file["values/delta_x@2"].attrs["truth"] == file["values/delta_x@2"].attrs["reference"]


def percentages(rows: list[dict[str, str]], quantity: str) -> list[float]:
    return [float(row[f"error of {quantity} (%)"] or "nan") for row in rows]


def test_table_has_all_quantities_and_marks(tmp_path: Path, undrawn: None) -> None:
    result = invoke("study", write_case(tmp_path, LOOP), "--vary", "grid.points=8,10,12")
    table = result.stdout[result.stdout.index("points") :].splitlines()
    for heading in ("worst", "delta_z", "delta_x", "contact", "stick", "max", "work"):
        assert heading in result.stdout
    rows = table[table.index(next(line for line in table if "─" in line)) + 1 :][:3]
    reference = next(row for row in rows if "reference" in row)
    assert reference.split()[0] == "12"
    assert any(row.split()[0] == "*" for row in rows)
    assert "for 1 %" in result.stdout


def test_second_call_runs_nothing_and_a_larger_one_only_what_is_new(
    tmp_path: Path, undrawn: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = write_case(tmp_path, LOOP)
    first = invoke("study", case, "--vary", "grid.points=8,10", *BRIEF)
    before = rows_of(tmp_path / "case.study")
    larger = invoke("study", case, "--vary", "grid.points=8,10,12", *BRIEF)
    assert [run["reused"] for run in runs_of(larger.stdout)] == ["no", "yes", "yes"]
    monkeypatch.setattr("fretsolve.sweep.case_run.run", lambda *_: pytest.fail("something is run"))
    write_case(tmp_path, LOOP.replace("title: loop", "title: renamed") + EXPECT)
    second = invoke("study", case, "--vary", "grid.points=8,10", *BRIEF)
    assert (first.exit_code, second.exit_code) == (0, 0)
    assert "2 cases of grid.points, 2 done already" in second.stdout
    assert [run["reused"] for run in runs_of(second.stdout)] == ["yes", "yes"]
    assert rows_of(tmp_path / "case.study") == before


def test_quiet(tmp_path: Path, undrawn: None) -> None:
    text = LOOP.replace("coupling: none", "coupling: auto")
    (tmp_path / "case.study").mkdir()
    (tmp_path / "case.study" / "study.csv.01ab23cd.tmp").touch()  # as a kill leaves it
    result = invoke("study", write_case(tmp_path, text), "--vary", "grid.points=8,10", *BRIEF, "-q")
    assert (result.exit_code, result.output) == (0, "")
    assert len(rows_of(tmp_path / "case.study")) == 2


def test_closed_form_truth(tmp_path: Path, undrawn: None) -> None:
    case = write_case(tmp_path, LOOP)
    words = ("study", case, "--vary", "grid.points=16,24", "--set", f"{EVERY.replace('*', '1')}=2")
    result = invoke(*words, "--truth", "closed-form", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    truth, *rows = rows_of(tmp_path / "out")
    assert (truth["role"], truth["status"], truth["time (s)"]) == ("reference", "the closed forms", "")
    assert float(truth["delta_z@4 (mm)"]) == pytest.approx(9.066544e-3, rel=1e-6)
    assert len(rows) == 2
    assert all(float(row["error of delta_x@4 (%)"]) < 1.0 for row in rows)
    assert all(float(row["error of work_total@4 (%)"]) < 2.0 for row in rows)
    assert "error of its own" not in result.stdout


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        (LOOP.replace("none", "full"), ("--truth", "closed-form"), "no closed form is known for this case"),
        (LOOP, ("--truth", "closed-form", "--quantity", "max_shear"), "max_shear@4: --truth closed-form: it has no"),
        (
            LOOP,
            ("--truth", "closed-form", "--quantity", "delta_x@2", "--set", "coupling=tangential"),
            "max_pressure; with Poisson's ratios other than 0, shear along x also moves the surfaces along y, which",
        ),
        (LOOP, ("--truth", "expect"), "expect: the case expects nothing that --truth expect could compare with"),
        (LOOP + EXPECT, ("--truth", "expect", "--quantity", "delta_x"), "no expected value; these have: delta_x@2"),
    ],
)
def test_truth_that_is_not_there(text: str, words: tuple[str, ...], message: str, tmp_path: Path) -> None:
    assert message in refused(2, "study", write_case(tmp_path, text), "--vary", "grid.points=8", *words)


def test_expected_truth(tmp_path: Path, undrawn: None) -> None:
    case = write_case(tmp_path, LOOP + EXPECT)
    result = invoke("study", case, "--vary", "grid.points=8,16", "--truth", "expect")
    assert result.exit_code == 0
    truth, *rows = rows_of(tmp_path / "case.study")
    assert float(truth["delta_x@2 (mm)"]) == 0.863748e-3
    assert "Qx@4 (N)" not in truth  # imposed: no run is off
    assert all(0.0 < float(row["error of delta_x@2 (%)"]) < 2.0 for row in rows)


def test_failures_are_rows_with_their_reason(tmp_path: Path, undrawn: None) -> None:
    case = write_case(tmp_path, LOOP)
    words = ("study", case, "--vary", "grid.points=8,10", "--vary", "solver.max_iterations=1,500", *BRIEF)
    result = invoke(*words)
    assert result.exit_code == 0
    assert [run["status"] for run in runs_of(result.stdout)].count("failed") == 2
    failed = [row for row in rows_of(tmp_path / "case.study") if row["status"] == "failed"]
    assert len(failed) == 2
    assert all("is not solved after 1 iterations" in row["reason"] for row in failed)
    assert all(row["worst error (%)"] == "" for row in failed)
    assert "failed: 8 x 8, max iterations 1: " in result.stdout
    assert [run["reused"] for run in runs_of(invoke(*words).stdout)] == ["yes"] * 4
    quiet = invoke(*words, "-q")
    assert (quiet.exit_code, quiet.stdout) == (0, "")
    told, told_quietly = (
        [line for line in text.splitlines() if line.startswith("failed: ")] for text in (result.stdout, quiet.stderr)
    )
    assert (told_quietly, len(told)) == (told, 2)


def test_truth_that_fails(tmp_path: Path, undrawn: None) -> None:
    case = write_case(tmp_path, LOOP)
    words = ("--vary", "grid.points=8,10", "--vary", "load_path.1.Qx=50 N")
    result = invoke("study", case, *words, *BRIEF)
    assert result.exit_code == 3
    last = result.stderr.splitlines()[-1]
    assert last.startswith("the reference (10 x 10, Qx 50 N) has no solution, so no changes are known: ")
    result = invoke("study", case, *words[:2], "--set", "load_path.1.Qx=50 N", *BRIEF)
    assert result.exit_code == 3
    assert result.stderr.splitlines()[-1].startswith(
        "the reference (10 x 10) has no solution, so no errors are known: "
    )
    assert all(row["worst error (%)"] == "" for row in rows_of(tmp_path / "case.study"))


def test_other_problems_have_changes_but_no_errors(tmp_path: Path) -> None:
    case, folder = write_case(tmp_path, LOOP), tmp_path / "case.study"
    folder.mkdir()
    (folder / "study.png").write_bytes(b"another study, drawn by fretsolve")
    result = invoke("study", case, "--vary", "load_path.1.Qx=20 N,30 N", "--vary", "grid.points=8,10", *BRIEF)
    assert result.exit_code == 0
    assert "load_path.1.Qx changes the problem itself. Differences are not errors" in result.stderr
    assert "reference: the run with Qx 20 N, 10 x 10" in result.stdout
    table = result.stdout[result.stdout.rindex("run=4") :]
    assert all(word in table for word in ("largest", "change", "reference", "not errors, since load_path.1.Qx"))
    assert not any(word in table for word in ("worst", "*", "for 1 %"))
    rows = {(row["load_path.1.Qx"], row["grid.points"]): row for row in rows_of(folder)}
    assert [row["role"] for row in rows.values()].count("reference") == 1
    assert rows["20 N", "10"]["role"] == "reference"
    assert float(rows["30 N", "10"]["change of delta_x@2 (%)"]) > 10.0
    assert not (folder / "study.png").exists()
    with h5py.File(folder / "study.h5") as file:
        assert "errors" not in file
        assert file["changes/delta_x@2"].attrs["long_name"].startswith("change of delta_x")
        assert file["values/delta_x@2"].attrs["reference"] > 0.0
        assert file.attrs["advice"] == ""


def test_spacing_of_increments_changes_no_problem() -> None:
    changing = {"load_path.0.spacing": False, EVERY: False, "load_path.0.P": True, "friction": True, "coupling": False}
    assert {key: changes_the_problem(key) for key in changing} == changing


def test_known_values_hold_for_one_problem(tmp_path: Path) -> None:
    words = ("--vary", "grid.points=8,10", "--vary", "friction=0.1,0.2", "--truth", "closed-form")
    told = refused(2, "study", write_case(tmp_path, LOOP), *words)
    assert told.startswith("--vary friction: changes the problem itself, and --truth closed-form holds for")


def test_it_is_told_why_there_is_no_closed_form_of_shear(tmp_path: Path, undrawn: None) -> None:
    words = ("--vary", "grid.points=8,10", "--truth", "closed-form")
    linked = write_case(tmp_path, LOOP.replace("none", "tangential"))
    told = invoke("study", linked, *words).stdout
    assert "left out, without a closed form: delta_x@4, stick_radius@4, work_total@4\n(with Poisson's ratios" in told
    assert "they are exact only with coupling: none" in told


def test_known_truth_outlives_a_failing_finest_run(tmp_path: Path, undrawn: None) -> None:
    words = ("--vary", "solver.max_iterations=500,1", "--truth", "closed-form", "--quantity", "delta_x@2")
    result = invoke("study", write_case(tmp_path, LOOP), *words)
    assert result.exit_code == 0
    assert result.stdout.count("failed: ") == 1
    assert [row["status"] for row in rows_of(tmp_path / "case.study")] == ["the closed forms", "failed", "complete"]


def test_all_fail(tmp_path: Path, undrawn: None) -> None:
    words = ("--vary", "solver.max_iterations=1", "--truth", "closed-form")
    result = invoke("study", write_case(tmp_path, LOOP), *words)
    assert result.exit_code == 3
    assert result.stderr.splitlines()[-1].startswith(f"{tmp_path / 'case.yaml'}: none of the cases has a solution: ")


def test_quantities_that_are_nothing(tmp_path: Path, undrawn: None) -> None:
    case = write_case(tmp_path, LOOP)
    result = invoke("study", case, "--vary", "grid.points=8,10", "--quantity", "delta_y", *BRIEF)
    assert result.exit_code == 0
    assert "left out, since 0: delta_y@4" in result.stdout
    alone = invoke("study", case, "--vary", "grid.points=8,10", "--quantity", "delta_y")
    assert alone.exit_code == 2
    assert alone.stderr.endswith(f"{case}: nothing to compare, since 0: delta_y@4; name others with --quantity\n")


# Interrupts


def stopping(after: int) -> tuple[Any, Callable[..., None], list[int]]:
    """A request to stop that comes after so many increments, what counts them, and their steps."""
    stop, steps = SimpleNamespace(requested=False), []

    def show(case: object, summary: Any) -> None:
        steps.append(summary.step)
        stop.requested = len(steps) >= after

    return stop, show, steps


def test_stopped_run_is_resumed(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,10"], quantities=["delta_x"])
    (tmp_path / "case.study").mkdir()
    stop, show, steps = stopping(after=6)
    assert [report.increments for report in run_serially(plan.cases, stop, show)] == [4]
    assert steps == [0, 1, 2, 3, 0, 1]
    assert plan.cases[0].out.exists()
    assert plan.cases[1].out.with_name(plan.cases[1].out.name + ".parts").is_dir()
    stop, show, steps = stopping(after=100)
    reports = list(run_serially(plan.cases, stop, show))
    assert [report.wrote_result for report in reports] == [False, True]
    assert steps == [2, 3]
    assert [len(open_result(case.out).history["step"]) for case in plan.cases] == [4, 4]


def test_interrupt_keeps_what_is_done(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP)
    words = ("study", case, "--vary", f"{EVERY}=20,21,22,23", "--quantity", "work_total@2", "--set", "grid.points=12")
    with start(*words) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("run=1"):
                process.send_signal(signal.SIGINT)
                break
        output, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode == 75
    assert "the same command goes on with what is missing" in messages
    done = len(rows_of(tmp_path / "case.study"))
    assert 1 <= done < 4
    assert output.splitlines()[-1].startswith(f"4 cases: {done} complete, ")
    code, output, _ = finish(*words)
    assert code == 0
    assert [run["reused"] for run in runs_of(output)].count("yes") == done
    assert (tmp_path / "case.study/study.png").exists()


def test_bar_counts_what_is_not_there_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,10"], quantities=["delta_x"])
    plan.cases[0].out.parent.mkdir()
    plan.cases[0].out.touch()
    monkeypatch.setattr("sys.stdout", SimpleNamespace(isatty=lambda: True))
    messages = CaseMessages(plan.manifest, missing(plan.manifest), 2, bar=True)
    assert messages.bar is not None
    (task,) = messages.bar.tasks
    assert task.total == pytest.approx(plan.cases[1].expected.seconds)
    messages.case(plan.cases[0].id)
    assert (task.completed, task.fields["run"]) == (0.0, 2)
    messages.increment(plan.cases[1], SimpleNamespace(step=1))  # type: ignore[arg-type]
    assert task.completed == pytest.approx(0.5 * plan.cases[1].expected.seconds)
    assert task.fields["detail"] == "8 x 8: increment 2/4"
    messages.case(plan.cases[1].id)
    assert task.finished


# Pictures


def test_picture(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP)
    varied = ("--vary", "grid.points=8,10,12", "--vary", "solver.tolerance=1e-2,1e-6")
    result = invoke("study", case, *varied, "--quantity", "delta_x", "--quantity", "contact_radius")
    assert result.exit_code == 0, result.stderr
    picture = tmp_path / "case.study/study.png"
    assert result.stdout.splitlines()[-1].endswith(str(picture))
    with Image.open(picture) as image:
        assert min(image.size) > 400


def test_picture_has_a_panel_per_quantity_with_the_front(tmp_path: Path) -> None:
    from fretsolve.study.plot import trade

    plan = plan_of(tmp_path, ["grid.points=8,16,24,32"], quantities=["delta_x", "work_total"])
    study = made_up(plan, [9.0, 1.0, 2.0, 4.0], [[2.0, 4.0], [1.9, 4.1], [1.8, 4.0], [1.99, 4.01]])
    figure = trade(study, "title")
    worst, delta_x, work = figure.axes[:3]
    titles = [axes.get_title() for axes in figure.axes[:3]]
    assert titles == [
        "worst of the quantities",
        r"rigid displacement along x $\delta_x$, stage 4",
        "dissipated energy, stage 4",
    ]
    np.testing.assert_allclose(delta_x.lines[0].get_data(), [[1.0, 4.0], [5.0, 0.5]])
    np.testing.assert_allclose(worst.lines[0].get_data(), [[1.0, 4.0], [5.0, 0.5]])
    assert work.lines[0].get_data()[0].tolist() == [1.0, 2.0]
    assert "0" in [text.get_text() for text in work.texts]  # the one without an error, at the bottom
    assert [text.get_text() for text in delta_x.texts] == ["8", "24"]
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[:4] == ["points 8", "points 16", "points 24", "points 32"]


def test_without_matplotlib_there_is_no_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("fretsolve.plots.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    case, folder = write_case(tmp_path, LOOP), tmp_path / "case.study"
    folder.mkdir()
    (folder / "study.png").write_bytes(b"another study, drawn by fretsolve")
    result = invoke("study", case, "--vary", "grid.points=8,10", *BRIEF)
    assert result.exit_code == 0
    assert result.stderr.splitlines()[-1].startswith(
        f"{folder / 'study.png'}: not drawn: pictures need matplotlib, which"
    )
    assert result.stderr.endswith("pip install '.[plot]' in a clone of fretsolve\n")
    assert not (folder / "study.png").exists()


def test_folder_that_cannot_be_made(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP)
    told = refused(4, "study", case, "--vary", "grid.points=8", "-o", case)
    assert told.endswith(f"{case}: cannot be made a folder: File exists\n")


def test_something_must_be_varied(tmp_path: Path) -> None:
    assert "Missing option '--vary'" in refused(2, "study", write_case(tmp_path, LOOP))
