"""The table of a study as files, and which folders a study may write to."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import numpy as np
import pytest
from studying import plan_of

from fretsolve.errors import FileError
from fretsolve.study.assessment import (
    CSV_NAME,
    HDF5_NAME,
    PICTURE_NAME,
    Assessment,
    assess,
    require_own_folder,
    write_study_csv,
    write_study_hdf5,
)
from fretsolve.sweep.outcome import CaseOutcome


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


def test_csv(study: Assessment, tmp_path: Path) -> None:
    write_study_csv(tmp_path / CSV_NAME, study)
    rows = list(csv.DictReader((tmp_path / CSV_NAME).read_text().splitlines()))
    assert [row["role"] for row in rows].count("reference") == 1
    by_points = {row["points x"]: row for row in rows}
    error = next(name for name in rows[0] if name.startswith("error of delta_x"))
    assert [float(by_points[points][error]) for points in ("6", "8")] == pytest.approx([10.0, 2.0], rel=1e-6)
    assert {row["status"] for row in rows} == {"complete"}
    assert by_points["12"]["role"] == "reference"


def test_hdf5(study: Assessment, tmp_path: Path) -> None:
    write_study_hdf5(tmp_path / HDF5_NAME, study, ["take 8 points"])
    with h5py.File(tmp_path / HDF5_NAME) as file:
        assert file.attrs["advice"] == "take 8 points"
        assert file.attrs["reference"] == study.plan.reference_words
        assert file["cost/points"][:, 0].tolist() == [row.case.setup.grid.shape[0] for row in study.rows]
        assert file["cost/time"][:].tolist() == [row.outcome.seconds for row in study.rows]
        (name,) = file["errors"]
        expected = [row.errors[0] for row in study.rows]
        np.testing.assert_array_equal(file[f"errors/{name}"][:], expected)
        assert file["reference"][:].tolist() == [row.is_reference for row in study.rows]


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
