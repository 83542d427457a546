"""``fretsolve check``: comparison, exit codes, and the JUnit file."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from command_line import invoke, refused
from small_cases import CASE, write_case

from fretsolve.case.keys.settings_spec import Expectation
from fretsolve.cli.commands.check import Comparison

EXPECT = CASE[CASE.index("expect:") :]


@pytest.mark.parametrize(
    ("tolerance", "found", "ok"),
    [
        ({"rel": 0.01}, 2.019, True),
        ({"rel": 0.01}, 1.979, False),
        ({"rel": 0.0}, 2.0, True),
        ({"abs": 0.5}, 1.5, True),
        ({"abs": 0.5}, 2.6, False),
        ({"abs": 0.5}, float("nan"), False),
        ({"abs": 0.5}, None, False),
    ],
)
def test_comparison(tolerance: dict[str, float], found: float | None, ok: bool) -> None:
    wanted = Expectation.model_validate({"quantity": "P", "value": 2.0, **tolerance})
    assert Comparison(wanted, 1, found).ok is ok


def test_displacements_stand_in_a_unit_that_suits_them() -> None:
    wanted = Expectation.model_validate({"quantity": "delta_x", "value": "1.5 um", "abs": "0.1 um"})
    row = Comparison(wanted, 1, 1.52e-3).cells()
    assert row == ("1", "delta_x", "1.5 um", "1.52 um", "+0.02 um", "0.1 um", "yes")


def test_all_as_expected(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    result = invoke("check", case)
    assert result.exit_code == 0
    lines = [line.split() for line in result.stdout.splitlines()]
    assert lines[1] == ["stage", "quantity", "expected", "found", "deviation", "allowed", "ok"]
    assert lines[2][:4] == ["2", "delta_z", "9.066544", "um"]
    assert lines[2][-3:] == ["1", "%", "yes"]
    assert lines[3] == ["1", "Qx", "0", "N", "0", "N", "+0", "N", "1e-06", "N", "yes"]
    assert lines[-1] == ["1", "of", "1", "cases", "as", "expected"]
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


def test_case_that_expects_nothing_is_a_mistake(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace(EXPECT, ""))
    assert refused(2, "check", case).startswith(f"{case}:1: expect: nothing to check; give a list")


def test_stages_before_a_failure_are_compared(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("20 N", "50 N"))
    result = invoke("check", case)
    assert result.exit_code == 3
    rows = [line for line in result.stdout.splitlines() if line.startswith("  ")][1:3]
    assert ["not reached" in row for row in rows] == [True, False]
    assert [row.split()[-1] for row in rows] == ["NO", "yes"]
    assert result.stdout.splitlines()[-2].startswith(f"  {case}:10: stage.2.Qx: gross slip")
    assert result.stderr == ""


def test_reasons_stand_below_the_case(various: dict[str, Path]) -> None:
    """Whatever keeps a case from its values, and its warnings, stand between its name and the next one."""
    coarse = CASE.replace("points: 16", "points: 14")
    warned = write_case(various["0"].parent, coarse, "warned.yaml")
    result = invoke("check", *various.values(), warned)
    names = [*map(str, various.values()), str(warned)]
    of_case: dict[str, list[str]] = {}
    for line in result.stdout.splitlines()[:-1]:
        if line in names:
            of_case[line] = []
        else:
            of_case[[*of_case][-1]].append(line)
    said = {name: [line for line in lines if ": " in line] for name, lines in of_case.items()}
    begin = {code: said[str(path)][-1] if said[str(path)] else "" for code, path in various.items()}
    assert begin["0"] == "" or "warning" in begin["0"]
    assert begin["2"].startswith(f"  {various['2']}:6: grid.pints: unknown key 'pints'; did you mean 'points'?")
    assert begin["3"].startswith(f"  {various['3']}:10: stage.2.Qx: gross slip")
    assert begin["4"].startswith(f"  {various['4']}: cannot be read: No such file")
    assert said[str(warned)] == [line for line in said[str(warned)] if line.startswith("  warning: grid.points: only")]
    assert said[str(warned)]
    assert result.stderr == ""


@pytest.fixture()
def various(tmp_path: Path) -> dict[str, Path]:
    """One case of each outcome, by exit code."""
    return {
        "0": write_case(tmp_path, name="good.yaml"),
        "1": write_case(tmp_path, CASE.replace("9.066544 um", "9.3 um"), "off.yaml"),
        "3": write_case(tmp_path, CASE.replace("20 N", "50 N"), "slides.yaml"),
        "2": write_case(tmp_path, CASE.replace("points", "pints"), "bad.yaml"),
        "4": tmp_path / "none.yaml",
    }


@pytest.mark.parametrize(("codes", "worst"), [("01", 1), ("13", 3), ("320", 2), ("24", 4), ("40", 4)])
def test_worst_outcome_decides(codes: str, worst: int, various: dict[str, Path]) -> None:
    assert invoke("check", *[various[code] for code in codes]).exit_code == worst


def test_cases_of_a_folder_are_checked_in_order_and_other_files_named(various: dict[str, Path], tmp_path: Path) -> None:
    folder, other = tmp_path / "folder", write_case(tmp_path, name="other.yaml")
    folder.mkdir()
    write_case(folder, name="b.yml")
    write_case(folder, CASE.replace("9.066544 um", "9.3 um"), "a.yaml")
    write_case(folder, CASE.replace("load_path", "load_paths"), "c.yaml")
    write_case(folder, "case: b.yml\naxes: {friction: [0.1, 0.2]}\n", "sweep.yaml")
    write_case(folder, "tension_limit: 300 MPa\n", "material.yaml")
    write_case(folder, "no case", "notes.txt")
    (folder / "inner").mkdir()
    write_case(folder, name="capitals.YAML")
    result = invoke("check", folder, other, various["4"])
    assert result.exit_code == 4
    checked = [*(folder / name for name in ("a.yaml", "b.yml", "c.yaml")), other, various["4"]]
    assert [line for line in result.stdout.splitlines() if line.startswith(str(tmp_path))] == [*map(str, checked)]
    left_out = f"a folder or a name in capitals: {folder / 'capitals.YAML'}, {folder / 'inner'}"
    skipped = f"{folder / 'material.yaml'}, {folder / 'sweep.yaml'}"
    assert result.stdout.endswith(
        f"\n2 of 5 cases as expected; skipped, as they are no cases: {skipped}; left out, {left_out}\n"
    )
    assert f"{folder / 'c.yaml'}:8: load_paths: " in result.stdout


def test_broken_file_of_a_folder_is_no_file_to_skip(tmp_path: Path) -> None:
    case = write_case(tmp_path, "bodies: [")
    result = invoke("check", tmp_path)
    assert (result.exit_code, result.stderr) == (2, "")
    assert f"{case}\n  {case}:2: not valid YAML" in result.stdout


@pytest.mark.parametrize("name", ["sweep.yaml", "case.txt", ""])
def test_folder_without_cases_is_a_mistake(name: str, tmp_path: Path) -> None:
    if name:
        write_case(tmp_path, "case: case.yaml\naxes: {friction: [0.1]}\n", name)
    told = f"{tmp_path}: no YAML file in this folder is a case, with bodies, surface, load_path\n"
    assert refused(4, "check", tmp_path) == told


def test_junit(various: dict[str, Path], tmp_path: Path) -> None:
    file = tmp_path / "report.xml"
    result = invoke("check", *various.values(), "--junit", file)
    assert result.exit_code == 4
    assert "1 of 5 cases as expected" in result.stdout
    suites = {suite.get("name"): suite for suite in ElementTree.parse(file).getroot()}
    counts = {
        code: [suites[str(path)].get(name) for name in ("tests", "failures", "errors")]
        for code, path in various.items()
    }
    assert counts == {
        "0": ["2", "0", "0"],
        "1": ["2", "1", "0"],
        "3": ["2", "0", "1"],
        "2": ["1", "0", "1"],
        "4": ["1", "0", "1"],
    }
    failure = suites[str(various["1"])].find("testcase/failure")
    assert failure is not None
    assert failure.get("message", "").startswith("9.3 um expected, 9.0")
    error = suites[str(various["3"])].find("testcase/error")
    assert error is not None
    assert error.get("type") == "SlidingError"
    assert "gross slip" in error.get("message", "")


def test_junit_file_is_no_case(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    message = "the name of a JUnit file must end in .xml"
    assert refused(2, "check", case, "--junit", case) == f"{case}: {message}\n"
    assert case.read_text() == CASE


def test_junit_file_that_cannot_be_written(tmp_path: Path) -> None:
    case, file = write_case(tmp_path), tmp_path / "missing" / "report.xml"
    result = invoke("check", case, "--junit", file)
    told = f"{file}: cannot be written: there is no folder {file.parent}\n"
    assert (result.exit_code, result.stdout, result.stderr) == (4, "", told)
    file.mkdir(parents=True)
    result = invoke("check", case, "--junit", file)
    assert result.exit_code == 4
    assert result.stderr.splitlines()[-1] == f"{file}: cannot be written: Is a directory"
