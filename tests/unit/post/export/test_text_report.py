"""The printed table: which rows and columns, in 100 characters, without colour codes where it is piped."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_states import fake_header, fake_states

from fretsolve.post.export.selection import relevant_columns
from fretsolve.post.export.text_report import print_report
from fretsolve.result import HistoryWriter, Result, open_result


def made_up(tmp_path: Path, count: int = 7, end: str = "complete", **changes: float) -> Result:
    """A result of `count` increments, three a stage, with `changes` to all rows of its history."""
    with HistoryWriter.open(tmp_path / "out.h5", fake_header(), overwrite=True) as writer:
        for state in fake_states(count):
            writer.append(replace(state, summary=replace(state.summary, **changes)))
        if end != "stopped":
            writer.finish(end, "load_path.1.Qx: sliding")
    return open_result(tmp_path / "out.h5")


def printed(result: Result, **options: bool) -> list[str]:
    text = io.StringIO()
    print_report(result, file=text, **options)
    assert "\x1b" not in text.getvalue()
    return text.getvalue().splitlines()


def test_one_row_per_stage_end_with_units_and_totals(tmp_path: Path) -> None:
    lines = printed(made_up(tmp_path))
    assert lines[0] == "made up"
    assert lines[1] == "complete, 7 increments"
    assert lines[2].startswith("coupling tangential, grid 6 x 5 cells on 0.6 x 0.5 mm, fretsolve ")
    assert lines[5].split()[:4] == ["step", "stage", "P", "Qx"]
    assert lines[6].split()[:4] == ["N", "N", "mm", "mm"]
    assert [line.split()[:2] for line in lines[8:-2]] == [["2", "1"], ["5", "2"], ["6", "3"]]
    assert lines[-2].startswith("worst residual 3.0e-07 (residual_stick of increment 0), dissipated energy ")
    assert lines[-1] == "28 operator applications, 1.75 s of wall time"
    assert max(map(len, lines)) <= 100


def test_error_bars_at_rounding_are_none(tmp_path: Path) -> None:
    result = made_up(tmp_path)
    bars = {"P": 1e-16, "delta_z": 1e-3, "max_pressure": np.nan}
    result.history = {**result.history}
    for name, share in bars.items():
        result.history[f"{name}_error"] = share * np.abs(result.history[name])
    cells = {line.split()[0]: line.split()[2:4] for line in printed(result) if "±" in line or "unknown" in line}
    assert cells["P"] == ["±", "0"]
    assert cells["delta_z"] == ["±", f"{1e-3 * result.history['delta_z'][-1]:.1e}"]
    assert cells["max_pressure"][0] == "unknown"


@pytest.mark.parametrize(("bar", "shown"), [(1e-3, True), (1e-20, False)])
def test_an_energy_that_no_cell_shows_is_shown_with_its_bar(tmp_path: Path, bar: float, shown: bool) -> None:
    result = made_up(tmp_path, work_total=0.0)
    bars = {"P_error": 0.0, "work_total_error": bar}
    result.history = {**result.history, **{name: np.full_like(result.history["P"], its) for name, its in bars.items()}}
    lines = [line.split() for line in printed(result)]
    assert (["work_total", "0", "±", "1.0e-03", "mJ"] in lines) == shown


def test_columns_of_round_off_are_left_out(tmp_path: Path) -> None:
    names = relevant_columns(made_up(tmp_path, My=1e-13, delta_y=0.0, delta_z=0.0))
    assert not {"Mx", "My", "Qy", "Mz", "delta_y", "phi_z"} & set(names)
    assert {"P", "Qx", "delta_x", "delta_z", "stick_radius", "work_total"} <= set(names)


def test_extents_are_shown_for_zones_that_are_no_circles_about_the_origin(tmp_path: Path) -> None:
    result = made_up(tmp_path)
    columns = {name for name in result.history if name.startswith(("contact_", "stick_")) and name[-2:] in ("_x", "_y")}
    assert len(columns) == 8
    assert not columns & set(relevant_columns(result))
    result.history = {**result.history, "stick_center_x": 0.2 * result.history["contact_radius"]}
    assert columns & set(relevant_columns(result)) == {"stick_center_x"}
    assert any("center_x" in line.split() for line in printed(result))
    result.history["stick_center_x"] = np.full(7, np.nan)
    result.history["contact_half_width_y"] = 2.0 * result.history["contact_radius"]
    assert columns & set(relevant_columns(result)) == {"contact_half_width_x", "contact_half_width_y"}


def test_wide_history_is_split_and_no_number_cut(tmp_path: Path) -> None:
    names = ("Mx", "My", "Qy", "Mz", "delta_y", "phi_x", "phi_y", "phi_z")
    lines = printed(made_up(tmp_path, **dict.fromkeys(names, -1.2345678e-4)))
    assert max(map(len, lines)) <= 120
    assert sum("step" in line and "stage" in line for line in lines) > 1
    assert "…" not in "".join(lines)
    assert sum(line.count("-0.0001235") for line in lines) == 3 * (len(names) - 1)
    assert sum(line.count("-0.1235") for line in lines) == 3  # delta_y, in um


def test_failed_and_stopped_results(tmp_path: Path) -> None:
    assert printed(made_up(tmp_path, end="failed"))[1] == "failed, 7 increments: load_path.1.Qx: sliding"
    assert printed(made_up(tmp_path, end="stopped"))[1] == "stopped, 7 increments"


def test_result_without_increments(tmp_path: Path) -> None:
    lines = printed(made_up(tmp_path, count=0, end="failed"))
    assert lines[1] == "failed, 0 increments: load_path.1.Qx: sliding"
    assert len(lines) == 3


def test_it_says_where_p_acts_if_the_pressure_has_a_moment(tmp_path: Path) -> None:
    """A contact that may not tilt takes up My; the point of P shows it."""
    assert not [line for line in printed(made_up(tmp_path)) if "P acts at" in line]
    result = made_up(tmp_path, P=400.0, My=2.0)
    (line,) = [line for line in printed(result) if "P acts at" in line]
    assert line == "at the end P acts at x = My/P = 5 um; My > 0 is more pressure at x > 0"
