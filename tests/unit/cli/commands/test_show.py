"""`fretsolve show`: tables, and for programs CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest
from command_line import invoke, result_of
from small_cases import write_case

from fretsolve import open_result
from fretsolve.post.export import text_report

CASE = """bodies: [rigid, {young_modulus: 200 GPa, poisson_ratio: 0}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 8, size: 1 mm}
friction: 0.1
load_path:
  - {P: 400 N, increments: 1}
  - cycle: {amplitude: {Qx: 10 N}, times: 2, increments: 4}
"""

BARS = f"{CASE}solver: {{error_bars: true}}\n".replace("points: 8", "points: 16")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return result_of(write_case(tmp_path_factory.mktemp("show"), CASE))


def shown(*arguments: object, code: int = 0) -> str:
    result = invoke("show", *arguments)
    assert result.exit_code == code, result.output
    return result.stdout if code == 0 else result.stderr


def test_json_has_history_cycles_and_units(out: Path) -> None:
    found = json.loads(shown(out, "--json"))
    assert (found["status"], found["increments"], found["title"]) == ("complete", 10, None)
    assert found["history"]["stage"] == [1, 2, 3, 4, 5, 6]
    assert found["units"]["delta_x"] == "mm"
    with open_result(out) as result:
        assert found["history"]["Qx"] == result.history["Qx"][[0, 1, 3, 5, 7, 9]].tolist()
        assert found["cycles"]["dissipated_energy"] == result.cycles.columns["dissipated_energy"].tolist()
    assert found["cycle_units"]["dissipated_energy"] == "mJ"
    assert len(json.loads(shown(out, "--json", "--all"))["history"]["step"]) == 10


def test_csv_has_all_digits_and_the_units_in_its_heading(out: Path) -> None:
    heading, *rows = csv.reader(io.StringIO(shown(out, "--csv", "--columns", "Qx,delta_x", "--all")))
    assert heading == ["step", "stage", "Qx (N)", "delta_x (mm)"]
    with open_result(out) as result:
        assert [float(row[3]) for row in rows] == result.history["delta_x"].tolist()
    assert len(next(csv.reader(io.StringIO(shown(out, "--csv"))))) == len(result.history)


def test_mistakes(out: Path) -> None:
    assert "'qx' is not a column of the history; did you mean 'Qx'?" in shown(out, "--columns", "qx", code=2)
    assert "energy_ratio is a column of the cycles" in shown(out, "--columns", "Qx,energy_ratio", code=2)
    assert shown(out, "--columns", "qx,P,pressur,energy_ratio", code=2).splitlines() == [
        "--columns: 'qx' is not a column of the history; did you mean 'Qx'?",
        "--columns: 'pressur' is not a column of the history; did you mean 'max_pressure'?",
        "--columns: energy_ratio is a column of the cycles, whose table is printed below the history; leave it out",
    ]
    assert "exclude each other" in shown(out, "--json", "--csv", code=2)


@pytest.mark.parametrize("column", ["delta_x_error", "delta_x_corrected", "stick_radius_error"])
def test_columns_of_error_bars_need_a_run_with_them(out: Path, column: str) -> None:
    said = shown(out, "--columns", column, code=2)
    assert f"{column} is not there, since the case ran without error bars; run it with --error-bars" in said


def test_radii_are_not_corrected(tmp_path: Path) -> None:
    out = result_of(write_case(tmp_path, BARS))
    said = shown(out, "--columns", "stick_radius_corrected", code=2)
    assert "since stick_radius is not corrected for the number of increments; use stick_radius" in said
    assert "delta_x_corrected_error (mm)" in shown(out, "--columns", "delta_x_corrected_error", "--csv")
    assert "did you mean 'delta_x_error'?" in shown(out, "--columns", "delta_x_eror", code=2)


def test_long_tables_have_the_first_and_the_last_stages(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_report, "MOST_STAGES", 4)
    monkeypatch.setattr(text_report, "FIRST_STAGES", 1)
    lines = shown(out).splitlines()
    first, last = (next(n for n, line in enumerate(lines) if line.startswith(word)) for word in ("step", "cycle"))
    rows = [line.split()[1] for line in lines[first:last] if line[:4].strip().isdigit()]
    assert rows[:4] == ["1", "4", "5", "6"]
    assert set(rows) == set(rows[:4])  # in each part of a wide table
    assert "the table has the first 1 and the last stages; --csv prints all" in lines
    assert not any("the table of cycles has" in line for line in lines)
    monkeypatch.setattr(text_report, "MOST_CYCLES", 1)
    told = shown(out, "--all")
    assert "--csv prints all" not in told  # all increments are there
    assert "the table of cycles has the first 2 and the last ones; --json prints all" in told
