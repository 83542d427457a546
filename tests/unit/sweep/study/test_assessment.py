"""Errors, marks, advice and pictures of a study."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from PIL import Image
from small_cases import LOOP, write_case
from studying import plan_of

from fretsolve.errors import FileError
from fretsolve.sweep.outcome import CaseOutcome
from fretsolve.sweep.study.assessment import (
    CSV_NAME,
    HDF5_NAME,
    PICTURE_NAME,
    Assessment,
    assess,
    require_own_folder,
    write_study_csv,
    write_study_hdf5,
)
from fretsolve.sweep.study.plan import StudyPlan
from fretsolve.sweep.study.report import advice, notes


def made_up(plan: StudyPlan, seconds: Sequence[float], values: Sequence[Sequence[float]]) -> Assessment:
    """A study of outcomes in the order of the plan's cases."""
    return assess(plan, [outcome(cost, row) for cost, row in zip(seconds, values, strict=True)])


def outcome(seconds: float, values: Sequence[float], peaks: Sequence[float] | None = None) -> CaseOutcome:
    """The outcome of a run in one increment."""
    largest = np.abs(values if peaks is None else peaks)
    return CaseOutcome(np.array(values), np.full(len(values), np.nan), 1, seconds, 1, largest)


def test_errors_marks_and_advice(tmp_path: Path) -> None:
    quantities = ["delta_x@4", "stick_radius@4", "work_total@4"]
    plan = plan_of(tmp_path, ["grid.points=8,16,24,32,40"], quantities=quantities)
    values = [[2.0, 1.0, 4.0], [1.9, 1.0, 4.0], [2.01, 1.1, 4.0], [2.0, 0.995, 4.02], [2.0, 1.0, 5.0]]
    study = made_up(plan, [10.0, 1.0, 2.0, 5.0, 20.0], values)
    assert [row.outcome.seconds for row in study.rows] == [1.0, 2.0, 5.0, 10.0, 20.0]
    np.testing.assert_allclose([row.worst for row in study.rows], [0.05, 0.1, 0.005, np.nan, 0.25])
    assert [row.best for row in study.rows] == [True, False, True, False, False]
    assert [row.is_reference for row in study.rows] == [False, False, False, True, False]
    first, second, third, fourth = advice(study)
    assert first == (
        "for 1 %: 24 x 24: stick_radius within 0.50 %, work_total within 0.50 %, delta_x within 0 %;"
        " 5.0 s, 2.0 times cheaper than the finest run"
    )
    assert second.startswith("for 1 % in all but stick_radius (10 %): 16 x 16: delta_x within 0.50 %")
    assert third.startswith("for 0.1 %: no other run meets it; the nearest is 24 x 24")
    assert fourth.startswith("for 0.1 % in all but stick_radius (0.50 %) and work_total (0.50 %): 24 x 24: ")


def test_the_worst_of_all_stages_counts(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,16,24"], quantities=["work_total", "delta_z@4"])
    assert [str(one) for one in plan.quantities] == ["delta_z@4", *(f"work_total@{stage}" for stage in (1, 2, 3, 4))]
    peaks = [9.0, *[8.0] * 4]
    first_is_worse = outcome(1.0, [9.0, 1.23, 2.02, 4.0, 8.0], peaks)
    closer = outcome(2.0, [9.009, 1.005, 2.0, 4.0, 8.08], peaks)
    study = assess(plan, [outcome(4.0, [9.0, 1.0, 2.0, 4.0, 8.0], peaks), first_is_worse, closer])
    rough, fine, _ = study.rows
    np.testing.assert_allclose([rough.worst, fine.worst], [0.23, 0.01])
    assert [study.worst_of(row, "work_total")[1] for row in (rough, fine)] == [1, 4]
    assert study.error_of(rough, "work_total") == pytest.approx(0.23)
    first, second, *_ = advice(study)
    assert first.startswith("for 1 %: 16 x 16: work_total within 1.0 %, delta_z within 0.10 %; 2.0 s")
    but = "for 1 % and 0.1 % in all but work_total (23 %, stage 1): 8 x 8: delta_z within 0 %; 1.0 s"
    assert second.startswith(but)
    assert "the error of a quantity is the worst over the ends of stages 1-4" in list(notes(study))


def test_a_value_of_zero_is_compared_with_the_largest_on_the_path(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,16"], quantities=["stick_radius@2", "stick_radius@3", "work_total@1"])
    reference, other = outcome(2.0, [0.5, 0.0, 1e-15], [2.0, 2.0, 4.0]), outcome(1.0, [0.4, 0.1, 0.02])
    study = assess(plan, [reference, other])
    np.testing.assert_allclose(study.scales, [0.5, 2.0, 4.0])
    np.testing.assert_allclose(study.rows[0].errors, [0.2, 0.05, 0.005])


def test_what_the_reference_does_not_know_is_left_out(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, ["grid.points=8,16"], quantities=["delta_z@1", "delta_z@2", "delta_y@2"])
    study = assess(plan, [outcome(2.0, [2.0, math.nan, 0.0], [2.0, 2.0, 0.0]), outcome(1.0, [2.1, 2.0, 0.0])])
    assert [row.worst for row in study.rows] == pytest.approx([0.05, math.nan], nan_ok=True)
    assert "left out, since 0 or not known: delta_z (stage 2), delta_y (stage 2)" in list(notes(study))


def test_picture(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP)
    varied = ("--vary", "grid.points=8,10,12", "--vary", "solver.tolerance=1e-2,1e-6")
    result = invoke("study", case, *varied, "--quantity", "delta_x", "--quantity", "contact_radius")
    assert result.exit_code == 0, result.stderr
    picture = tmp_path / "case.study/study.png"
    assert result.stdout.splitlines()[-1].endswith(str(picture))
    with Image.open(picture) as image:
        assert min(image.size) > 400


@pytest.fixture
def study(tmp_path: Path) -> Assessment:
    """Three runs that take 1, 2 and 3 s; delta_x is 10 % and 2 % wrong in those before the finest."""
    plan = plan_of(tmp_path, ["grid.points=6,8,12"], quantities=["delta_x"])
    found = {6: (1.0, 0.9e-3), 8: (2.0, 1.02e-3), 12: (3.0, 1.0e-3)}
    outcomes = [
        CaseOutcome(np.array([value]), np.full(1, np.nan), 4, seconds, 100, np.array([value]))
        for seconds, value in (found[case.setup.grid.shape[0]] for case in plan.cases)
    ]
    return assess(plan, outcomes)


def test_its_own_files_may_be_replaced(study: Assessment, tmp_path: Path) -> None:
    folder = tmp_path / "own"
    folder.mkdir()
    require_own_folder(folder)
    write_study_csv(folder / CSV_NAME, study)
    write_study_hdf5(folder / HDF5_NAME, study, [])
    (folder / "notes.txt").touch()  # beside its table others may lie
    require_own_folder(folder)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        (HDF5_NAME, b"no HDF5", r"study\.h5: is not the table of a study, so it is not replaced"),
        (CSV_NAME, b"a,b\n", r"study\.csv: .*the table of a study"),
        (PICTURE_NAME, b"\x89PNG", r"study\.png: .*a picture"),
        ("notes.txt", b"", r"no study"),
    ],
)
def test_files_of_others_stay(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError, match=message):
        require_own_folder(tmp_path)
    assert (tmp_path / name).read_bytes() == content
