"""Cases of a sweep whose load paths begin alike solve that beginning once, and have the same numbers as alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from small_cases import DISSIMILAR, case_of
from sweeping import assert_as_serial, write_sweep

from fretsolve import open_result
from fretsolve.contact.increment.increment import IncrementSolver
from fretsolve.errors import FretsolveError
from fretsolve.sweep import beginnings
from fretsolve.sweep.beginnings import FOLDER_NAME
from fretsolve.sweep.case_run import CaseRunner
from fretsolve.sweep.manifest import Manifest, read_manifest, write_manifest
from fretsolve.sweep.plan import make_sweep_plan

PATH = "{P: 400 N, increments: 3}, {Qx: 20 N, increments: 2}, {Qx: -20 N, increments: 2}"
CASE = case_of(PATH, bodies=DISSIMILAR, points=16)
SWEEP = "case: case.yaml\naxes:\n  - stage.1.P: [400 N, 410 N]\n  - stage.3.Qx: [-20 N, -10 N, 10 N]\n"
"""Two groups of three cases that share two of three stages."""


ON_A_RIG = CASE.replace("Qx: 20 N", "actuator_x: 1 um").replace("Qx: -20 N", "actuator_x: -1 um")
ON_A_RIG += "rig: {stiffness_x: 50 kN/mm}\n"


class StopAfter:
    """Asks to stop after so many increments."""

    def __init__(self, increments: int = 1000):
        self.left = increments

    @property
    def requested(self) -> bool:
        self.left -= 1
        return self.left < 0


@pytest.fixture(autouse=True)
def _short_beginnings(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cases here are so small that their beginnings would not be worth a file."""
    monkeypatch.setattr(beginnings, "LEAST_SECONDS", 0.0)


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The steps that are solved from now on."""
    steps: list[int] = []
    solve = IncrementSolver.solve

    def watched(self: Any, increment: Any, start: Any) -> Any:
        steps.append(increment.step)
        return solve(self, increment, start)

    monkeypatch.setattr(IncrementSolver, "solve", watched)
    return steps


def plan_of(folder: Path, sweep: str = SWEEP, case: str = CASE) -> Manifest:
    path = write_sweep(folder, sweep, case)
    write_manifest(make_sweep_plan(path, folder / "sweep.sweep").manifest)
    return read_manifest(folder / "sweep.sweep")


def run_all(manifest: Manifest) -> None:
    runner = CaseRunner(manifest)
    for row in manifest.unique:
        assert runner.run(row, StopAfter()).code == 0


def test_a_shared_beginning_is_solved_once(tmp_path: Path, solved: list[int]) -> None:
    manifest = plan_of(tmp_path)
    assert [[one.increments for one in row.shared] for row in manifest.rows] == [[5]] * 6
    assert len({row.shared for row in manifest.rows}) == 2
    run_all(manifest)
    assert solved == [*range(7), 5, 6, 5, 6] * 2
    assert len(list((manifest.folder / FOLDER_NAME).iterdir())) == 2
    assert assert_as_serial(manifest.folder, tmp_path / "case.yaml") == 6


def test_a_case_with_more_columns_shares_none_of_its_beginnings_with_others(tmp_path: Path) -> None:
    """Bulk stress in a later stage gives all increments columns that other cases do not have."""
    ends = "{Qx: -20 N}, {Qx: -20 N, bulk_2: {xx: 20 MPa}}, {Qx: -20 N, bulk_2: {xx: 10 MPa}}"
    manifest = plan_of(tmp_path, f"case: case.yaml\naxes:\n  - load_path.2: [{ends}]\n")
    without, *with_bulk = (row.shared for row in manifest.rows)
    assert without == ()
    assert with_bulk[0] == with_bulk[1] != ()
    run_all(manifest)
    assert assert_as_serial(manifest.folder, tmp_path / "case.yaml") == 3
    histories = [open_result(manifest.result(row)).history for row in manifest.rows]
    assert ["bulk_2_xx" in history for history in histories] == [False, True, True]
    assert histories[1]["bulk_2_xx"][:5].tolist() == [0.0] * 5
    assert histories[1]["bulk_2_xx"][-1] == 20.0


def test_a_case_with_a_rig_goes_on_from_what_it_shares(tmp_path: Path, solved: list[int]) -> None:
    sweep = "case: case.yaml\naxes:\n  - stage.3.actuator_x: [-1 um, 0.5 um]\n"
    manifest = plan_of(tmp_path, sweep, ON_A_RIG)
    run_all(manifest)
    assert solved == [*range(7), 5, 6]
    assert assert_as_serial(manifest.folder, tmp_path / "case.yaml") == 2
    for row, end in zip(manifest.rows, (-1e-3, 0.5e-3), strict=True):
        with open_result(manifest.result(row)) as result:
            assert result.history["actuator_x"][[4, 6]] == pytest.approx([1e-3, end], rel=1e-12)


@pytest.mark.parametrize(
    ("sweep", "case"),
    [
        (SWEEP.replace("stage.1.P: [400 N, 410 N]", "friction: [0.1, 0.2]").replace("stage.3", "stage.1"), CASE),
        ("case: case.yaml\naxes:\n  - solver.tolerance: [1e-6, 1e-7]\n", CASE),
        ("case: case.yaml\naxes:\n  - grid.points: [16, 17]\n", CASE),
        ("case: case.yaml\nerror_bars: true\naxes:\n  - stage.3.Qx: [1 N, 2 N]\n", CASE),
        ("case: case.yaml\naxes:\n  - rig.stiffness_x: [20 kN/mm, 50 kN/mm]\n", ON_A_RIG),
        # Only with the third stage in the path is there any shear.
        ("case: case.yaml\naxes:\n  - stage.2.Qx: [0 N, 10 N]\n", case_of("{P: 400 N}, {Qx: 10 N}")),
    ],
)
def test_cases_that_differ_otherwise_share_nothing(tmp_path: Path, sweep: str, case: str) -> None:
    sweep = sweep.replace("stage.1.Qx: [-20 N, -10 N, 10 N]", "stage.1.P: [300 N, 400 N]")
    assert {row.shared for row in plan_of(tmp_path, sweep, case).rows} == {()}


def test_a_damaged_beginning_is_solved_anew(tmp_path: Path, solved: list[int]) -> None:
    manifest = plan_of(tmp_path, SWEEP.replace("[400 N, 410 N]", "[400 N]"))
    runner = CaseRunner(manifest)
    runner.run(manifest.rows[0], StopAfter())
    (path,) = (manifest.folder / FOLDER_NAME).iterdir()
    whole = path.read_bytes()
    damaged = bytearray(whole)
    damaged[len(damaged) // 2 :] = bytes(len(damaged) - len(damaged) // 2)
    path.write_bytes(damaged)
    solved.clear()
    runner.run(manifest.rows[1], StopAfter())
    assert solved == list(range(7))
    runner.run(manifest.rows[2], StopAfter())
    assert solved == [*range(7), 5, 6]
    assert assert_as_serial(manifest.folder, tmp_path / "case.yaml") == 3


@pytest.mark.parametrize("increments", [0, 1, 3, 6])
def test_a_stopped_case_goes_on(tmp_path: Path, solved: list[int], increments: int) -> None:
    """Both of the case that writes a beginning, and of one that goes on from it."""
    manifest = plan_of(tmp_path, SWEEP.replace("[400 N, 410 N]", "[400 N]"))
    runner = CaseRunner(manifest)
    for row in manifest.rows:
        runner.run(row, StopAfter(increments))
        assert runner.run(row, StopAfter()).code == 0
    assert solved == [*range(7), 5, 6, 5, 6]
    assert assert_as_serial(manifest.folder, tmp_path / "case.yaml") == 3


def test_a_beginning_that_cannot_be_written_costs_nothing(tmp_path: Path, solved: list[int]) -> None:
    manifest = plan_of(tmp_path, SWEEP.replace("[400 N, 410 N]", "[400 N]"))
    (manifest.folder / FOLDER_NAME).write_text("no folder")
    run_all(manifest)
    assert solved == [*range(7)] * 3


def test_a_stored_key_is_nothing_but_a_digest(tmp_path: Path) -> None:
    manifest = plan_of(tmp_path)
    path = manifest.folder / "manifest.json"
    path.write_text(path.read_text().replace(manifest.rows[0].shared[0].key, "../../../etc/pwd"))
    with pytest.raises(FretsolveError, match=r"not the manifest of a sweep: cases\.0\.shared\.0\.key"):
        read_manifest(manifest.folder)
