"""Spots of contact: how many there are, what each carries, and which have too few cells."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke, result_of
from small_cases import write_case

from fretsolve import open_result
from fretsolve.case.history import FEWEST_SPOT_CELLS
from fretsolve.post.export.remarks import may_have_spots, spot_warnings, spots_of

CASE = """bodies: [rigid, {young_modulus: 200 GPa, poisson_ratio: 0}]
surface: {heights: {file: bumps.npy, spacing: 0.025 mm}}
grid: {points: 48, size: 1.2 mm}
friction: 0.1
load_path:
  - {P: 30 N}
  - {Qx: 1.5 N, increments: 1}
"""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two equal bumps at x = -0.3 and 0.3 mm, and one at y = 0.45 mm that hardly touches."""
    folder = tmp_path_factory.mktemp("spots")
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 49), np.linspace(-0.6, 0.6, 49), indexing="ij")
    pair = np.minimum((x - 0.3) ** 2, (x + 0.3) ** 2) + y**2
    third = x**2 + (y - 0.45) ** 2
    np.save(folder / "bumps.npy", np.minimum(pair / 10.0, third / 0.5 + 0.0016))
    return result_of(write_case(folder, CASE))


def test_each_spot_has_its_loads_and_its_place(out: Path) -> None:
    with open_result(out) as result:
        assert may_have_spots(result)
        found = spots_of(result)
        pressed = spots_of(result, 0)
        cells = int(result.history["contact_cells"][-1])
    assert sum(spot.cells for spot in found) == cells
    assert sum(spot.P for spot in found) == pytest.approx(30.0, rel=1e-5)
    assert sum(spot.Qx for spot in found) == pytest.approx(1.5, rel=1e-4)
    first, second, *others = found
    assert abs(pressed[0].P - pressed[1].P) < 1e-3 * first.P
    assert abs(second.P - first.P) < 2e-2 * first.P  # shear moves some of it, as the bodies differ
    assert sorted([first.x, second.x]) == pytest.approx([-0.3, 0.3], abs=0.02)
    assert abs(first.y) < 0.03
    assert first.area == pytest.approx(first.cells * 0.025**2)
    assert 0.0 < first.stick < 1.0
    assert abs(sum(spot.Qx for spot in pressed)) < 1e-4
    assert [spot.P for spot in others] == sorted((spot.P for spot in others), reverse=True)


def test_report_has_a_table_and_says_which_are_small(out: Path) -> None:
    text = invoke("show", out).stdout
    with open_result(out) as result:
        count = len(spots_of(result))
    assert "spot  cells" in text
    line = next(line for line in text.splitlines() if "spots of contact" in line)
    assert line.startswith(f"{count} spots of contact at the last increment")
    assert "fewer than" not in line


def test_the_history_counts_them(out: Path) -> None:
    with open_result(out) as result:
        found = [spots_of(result, step) for step in result.steps]
        assert result.history["spots"].tolist() == list(map(len, found))
        small = [sum(spot.cells < FEWEST_SPOT_CELLS for spot in spots) for spots in found]
        assert result.history["small_spots"].tolist() == small
        assert len({len(spots) for spots in found}) == 1
        assert small[0] == 2
        assert small[-1] == 0
        assert spot_warnings(result.history) == []  # two spots throughout, of enough cells where the contact is largest
    lines = invoke("show", out).stdout.splitlines()
    assert any("spots" in line.split() for line in lines if line.startswith("step  stage"))


def history_of(spots: list[int], small: list[int] | None = None, cells: list[int] | None = None) -> dict[str, Any]:
    columns = {"spots": spots, "small_spots": small or [0] * len(spots), "contact_cells": cells or [50] * len(spots)}
    return {name: np.array(values) for name, values in columns.items()}


def test_a_warning_names_the_increments_at_which_their_number_changes() -> None:
    changes = "the number of spots of contact changes at "
    assert spot_warnings(history_of([0, 0, 2, 2, 3, 2, 2])) == [f"{changes}increments 4, 5, between 2 and 3"]
    assert spot_warnings(history_of([1, 1, 2])) == [f"{changes}increment 2, between 1 and 2"]
    (many,) = spot_warnings(history_of([1, 2] * 20))
    assert many == f"{changes}increments 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 and 29 more, between 1 and 2"
    assert spot_warnings(history_of([1, 1, 1])) == spot_warnings({}) == spot_warnings(history_of([])) == []


def test_a_warning_tells_of_spots_of_few_cells_in_the_largest_contact() -> None:
    told = spot_warnings(history_of([3, 3, 3], [3, 1, 2], [10, 90, 40]))
    assert told == [
        "grid.points: 1 of 3 spots in the largest contact (increment 1) has fewer than 10 cells, so that sizes and"
        " loads are rough there"
    ]


def test_a_run_of_several_surfaces_warns(tmp_path: Path) -> None:
    text = CASE.replace("{heights: {file: bumps.npy, spacing: 0.025 mm}}", "[{sphere: {radius: 10 mm}}, WAVES]")
    (tmp_path / "case.yaml").write_text(text.replace("WAVES", "{heights: {file: waves.npy, spacing: 0.025 mm}}"))
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 49), np.linspace(-0.6, 0.6, 49), indexing="ij")
    np.save(tmp_path / "waves.npy", 2e-3 * np.cos(2.0 * np.pi * x / 0.2) * np.cos(2.0 * np.pi * y / 0.2))
    loads = "load_path=[{P: 1 N, increments: 1}, {P: 200 N, increments: 3}]"
    ran = invoke("run", tmp_path / "case.yaml", "-q", "--set", loads)
    assert ran.exit_code == 0
    assert "case.yaml: warning: the number of spots of contact changes at increment" in ran.stderr
