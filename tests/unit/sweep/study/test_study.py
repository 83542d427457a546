"""``fretsolve study``: what is varied, what the reference is, what is reused, and what comes out."""

from __future__ import annotations

import csv
import signal
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import PATIENCE, finish, invoke, refused, start
from line_cases import LINE
from small_cases import LOOP, TWO_CYCLES, write_case
from studying import BRIEF, EVERY, EXPECT

import fretsolve.cli.commands.study as command
from fretsolve import open_result


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
        assert file.attrs["reference"] == "the finest run, 12 x 12, tolerance 1e-6"
        reference = file["values/delta_x@2"].attrs["reference"]
        assert reference == pytest.approx(float(truth["delta_x@2 (mm)"]), rel=1e-9)


def percentages(rows: list[dict[str, str]], quantity: str) -> list[float]:
    return [float(row[f"error of {quantity} (%)"] or "nan") for row in rows]


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
    (tmp_path / "case.study" / "study.csv.0123456789abcdef.tmp").touch()  # as a kill leaves it
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
        (LOOP, ("--truth", "closed-form", "--quantity", "max_shear"), "max_shear: --truth closed-form: it has no"),
        (
            LOOP,
            ("--truth", "closed-form", "--quantity", "delta_x@2", "--set", "coupling=tangential"),
            "max_pressure; with Poisson's ratios other than 0, shear along x also moves the surfaces along y, which",
        ),
        (LOOP, ("--truth", "expect"), "expect: the case expects nothing that --truth expect could compare with"),
        (LOOP + EXPECT, ("--truth", "expect", "--quantity", "delta_x@4"), "no expected value; these have: delta_x@2"),
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


def test_the_last_repetition_that_was_solved_stands_for_the_last(tmp_path: Path, undrawn: None) -> None:
    text = TWO_CYCLES.replace("times: 2", "until: periodic, at_most: 9")
    result = invoke("study", write_case(tmp_path, text), "--vary", "grid.points=12,16", "--quantity", "delta_x")
    assert result.exit_code == 0, result.stderr
    for row in rows_of(tmp_path / "case.study"):
        with open_result(tmp_path / "case.study" / row["result"]) as solved:
            assert solved.increments < 20
            delta_x = solved.history["delta_x"]
        found = [float(row[f"delta_x@{stage} (mm)"]) for stage in (1, 2, 19, 20)]
        np.testing.assert_allclose(found, delta_x[[0, 2, -3, -1]], rtol=1e-9)


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


def test_it_is_told_why_there_is_no_closed_form_of_shear(tmp_path: Path, undrawn: None) -> None:
    words = ("--vary", "grid.points=8,10", "--truth", "closed-form")
    linked = write_case(tmp_path, LOOP.replace("none", "tangential"))
    told = invoke("study", linked, *words).stdout
    names = "delta_x (stages 1-4), stick_radius (stages 1-4), work_total (stages 1-4)"
    assert f"left out, with no closed form: {names}\n(with Poisson's ratios" in told
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
    assert "left out, since 0: delta_y (stages 1-4)" in result.stdout
    line = write_case(tmp_path, LINE, "line.yaml")
    result = invoke("study", line, "--vary", "grid.points=16,24", "--quantity", "delta_x", "--quantity", "stick_radius")
    assert "left out, since 0 or not known: delta_x (stages 1-2)" in result.stdout
    free = invoke("study", line, "--vary", "grid.points=16,24", "--quantity", "delta_z")
    assert "0, or displacements of a line contact, which a reference_depth makes known: delta_z (stages" in free.stderr
    alone = invoke("study", case, "--vary", "grid.points=8,10", "--quantity", "delta_y")
    assert alone.exit_code == 2
    said = "nothing to compare, since 0 or not known in the reference: delta_y (stages 1-4); name others with --quan"
    assert f"{case}: {said}" in alone.stderr


@pytest.mark.slow
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


def test_without_matplotlib_there_is_no_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("fretsolve.post.plots.")]:
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
