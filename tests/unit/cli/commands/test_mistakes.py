"""Mistakes that people make on the command line and in Python: what is said, and what would be right."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

import fretsolve
from fretsolve.cli.main import main
from fretsolve.errors import CaseError

CASE = """bodies: [rigid, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 8, size: 1 mm}
friction: 0.1
load_path:
  - {P: 400 N, increments: 1}
  - cycle: {amplitude: {Qx: 10 N}, times: 1, increments: 4}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "base.yaml").write_text(CASE)
    return tmp_path


def said(*arguments: str, code: int) -> str:
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == code, result.output
    return result.stderr.strip()


def test_file_without_its_ending(folder: Path) -> None:
    assert said("run", "base", code=4).endswith("; did you mean base.yaml?")
    assert "did you mean" not in said("run", "other", code=4)


def test_result_in_a_folder_that_does_not_exist(folder: Path) -> None:
    message = said("run", "base.yaml", "-o", "some dir/x.h5", code=4)
    assert message == "some dir/x.h5: there is no folder some dir; mkdir -p 'some dir' makes it"


def test_keys_of_a_stage_without_braces(folder: Path) -> None:
    (folder / "base.yaml").write_text(CASE + "  - Qx: 45 N, increments: 5\n")
    assert said("validate", "base.yaml", code=2).endswith("stand in braces, as in {Qx: 45 N, increments: 5}")


@pytest.mark.parametrize(("wrong", "right"), [("Gpa", "GPa"), ("gpa", "GPa"), ("MPA", "MPa")])
def test_unit_with_other_capitals(folder: Path, wrong: str, right: str) -> None:
    (folder / "base.yaml").write_text(CASE.replace("GPa", wrong))
    assert f"has the unknown unit '{wrong}' (did you mean {right}?)" in said("validate", "base.yaml", code=2)


def test_key_of_a_mapping_inside(folder: Path) -> None:
    said_of = said("study", "base.yaml", "--vary", "points=8,16", code=2)
    assert "unknown key 'points'; did you mean grid.points?" in said_of
    assert "did you mean solver.tolerance?" in said("validate", "base.yaml", "--set", "tolerance=1e-5", code=2)
    (folder / "base.yaml").write_text(CASE + "points: 8\n")
    assert "base.yaml:8: points: unknown key 'points'; did you mean grid.points?" in said(
        "validate", "base.yaml", code=2
    )


def test_python_hears_of_arguments(folder: Path) -> None:
    with pytest.raises(CaseError, match=r"^override points=8: points: unknown key") as error:
        fretsolve.load_case("base.yaml", ["points=8"])
    assert "--set" not in str(error.value)


def test_every_stage_at_once(folder: Path) -> None:
    case = fretsolve.load_case("base.yaml", ["load_path.*.increments=8"])
    assert [stage.increments for stage in case.stages()] == [8, 2, 4, 4]
    case = fretsolve.load_case("base.yaml", ["load_path.*.increments=8", "stage.1.increments=3"])
    assert [stage.increments for stage in case.stages()] == [3, 2, 4, 4]
    output = CliRunner().invoke(main, ["validate", "base.yaml", "--set", "stage.*.increments=8"]).stdout
    assert "# load path of 18 increments" in output


def test_one_increment(folder: Path) -> None:
    (folder / "base.yaml").write_text(CASE[: CASE.index("  - cycle")])
    output = CliRunner().invoke(main, ["run", "base.yaml"]).stdout
    assert output.endswith("complete: base.h5, 1 increment\n")
    assert "complete, 1 increment\n" in CliRunner().invoke(main, ["show", "base.h5"]).stdout
