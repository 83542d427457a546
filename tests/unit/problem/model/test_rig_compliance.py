from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fretsolve.case.loading import load_case
from fretsolve.cli.rig_summary import rig_lines
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.required_terms import derive_model
from fretsolve.problem.model.rig import Rig, rig_of
from fretsolve.simulation.problem_setup import set_up

CASE = """bodies: [{material: steel}, {material: steel}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 16}
friction: 0.1
rig: {RIG}
load_path: [{P: 400 N}, {actuator_x: 2 um, increments: 2}]
"""
MATRIX = np.diag([2e-5, 3e-5, 5e-6, 1e-6, 2e-6, 3e-6])
"""In the order of a file: Qx, Qy, P, Mx, My, Mz."""
FIRST = np.array([1, 0, 1, 0, 0, 0])


def case_with(folder: Path, rig: str, moved: str = "actuator_x"):
    file = folder / "case.yaml"
    file.write_text(CASE.replace("RIG", rig).replace("actuator_x", moved))
    return load_case(file)


def rig_with(folder: Path, text: str) -> Rig:
    (folder / "rig.csv").write_text(text)
    found = rig_of(case_with(folder, "compliance: rig.csv"))
    assert found is not None
    return found


def lines(matrix: np.ndarray, separator: str = ", ") -> str:
    return "\n".join(separator.join(f"{value:g}" for value in row) for row in matrix)


def test_stiffnesses_are_a_diagonal_in_the_order_of_the_history(tmp_path: Path) -> None:
    rig = rig_of(case_with(tmp_path, "stiffness_x: 50 kN/mm, stiffness_z: 200 N/um, stiffness_phi_z: 5 N m/rad"))
    assert rig is not None
    np.testing.assert_allclose(rig.compliance, np.diag([5e-6, 0.0, 0.0, 2e-5, 0.0, 2e-4]))
    loads = np.array([400.0, 0.0, 0.0, 36.0, 0.0, 0.0])
    assert rig.actuator(np.zeros(6), loads)["actuator_x"] == pytest.approx(0.72e-3)
    assert rig.actuator(np.zeros(6), loads)["actuator_z"] == pytest.approx(2e-3)
    assert rig.energy(loads) == pytest.approx(0.5 * (400.0 * 2e-3 + 36.0 * 0.72e-3))


@pytest.mark.parametrize("separator", [", ", ";", "\t", "  "])
def test_a_file_has_its_own_order(tmp_path: Path, separator: str) -> None:
    matrix = MATRIX.copy()
    matrix[0, 4] = matrix[4, 0] = 1e-6  # phi_y under Qx
    rig = rig_with(tmp_path, f"# from a substructure\n\n{lines(matrix, separator)}\n")
    expected = np.diag([5e-6, 1e-6, 2e-6, 2e-5, 3e-5, 3e-6])
    expected[2, 3] = expected[3, 2] = 1e-6
    np.testing.assert_allclose(rig.compliance, expected)


def test_named_rows_and_columns_may_stand_in_any_order(tmp_path: Path) -> None:
    named = "motion,P,Qx,Qy,Mz,Mx,My\nphi_z,0,0,0,3e-6,0,0\ndelta_z,5e-6,1e-6,0,0,0,0\ndelta_x,1e-6,2e-5,0,0,0,0\n"
    named += "delta_y,0,0,3e-5,0,0,0\nphi_x,0,0,0,0,1e-6,0\nphi_y,0,0,0,0,0,2e-6\n"
    expected = np.diag([5e-6, 1e-6, 2e-6, 2e-5, 3e-5, 3e-6])
    expected[0, 3] = expected[3, 0] = 1e-6
    np.testing.assert_allclose(rig_with(tmp_path, named).compliance, expected)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: m[:5], "it has 5 rows; 6 rows of 6 numbers, one per motion, are needed"),
        (lambda m: m[:, :5], "line 1 has 5 numbers; 6 are needed, with a point for decimals"),
        (
            lambda m: m + np.diag([2e-6, 0.0, 0.0, 0.0, 0.0], k=1),
            "it is not symmetric: delta_x under Qy is 2e-06, but delta_y under Qx is 0",
        ),
        (lambda m: m - np.diag([0, 0, 6e-6, 0, 0, 0]), "the compliance of delta_z under P is -1e-06; it is below 0"),
        (
            lambda m: m * [0, 1, 1, 1, 1, 1] + 1e-6 * (np.eye(6, k=2) + np.eye(6, k=-2)) * np.outer(FIRST, FIRST),
            "it is not positive: delta_x under Qx is 0, but other numbers of its row or column are not",
        ),
        (
            lambda m: m + 3e-5 * (np.eye(6, k=1) * [0, 1, 0, 0, 0, 0] + np.eye(6, k=-1) * [1, 0, 0, 0, 0, 0]),
            "it is not positive: with its diagonal scaled to 1 it has the eigenvalue -0.2247",
        ),
    ],
)  # fmt: skip
def test_what_is_no_compliance_is_refused_at_its_key(
    tmp_path: Path, change: Callable[[np.ndarray], np.ndarray], message: str
) -> None:
    with pytest.raises(CaseError) as refused:
        rig_with(tmp_path, lines(change(MATRIX)))
    assert refused.value.key == ("rig", "compliance")
    assert refused.value.line == 5
    assert f"rig.csv: {message}" in str(refused.value)


@pytest.mark.parametrize("word", ["soft", "nan", "2,5e-6"])
def test_a_word_in_place_of_a_number_is_told_with_its_line(tmp_path: Path, word: str) -> None:
    rows = lines(MATRIX).splitlines()
    rows[2] = rows[2].replace("5e-06", word, 1)
    with pytest.raises(CaseError, match="line 3 has"):
        rig_with(tmp_path, "\n".join(rows))


@pytest.mark.parametrize(
    "header", ["Qx (N),Qy (N),P (N),Mx,My,Mz", "'Qx','Qy','P','Mx','My','Mz'", '"";Qx;Qy;P;Mx;My;Mz']
)
def test_names_may_have_units_and_quotes(tmp_path: Path, header: str) -> None:
    separator = ";" if ";" in header else ", "
    rows = lines(MATRIX, separator).splitlines()
    if ";" in header:
        motions = ("delta_x [mm]", "delta_y", "delta_z (mm)", "phi_x", "phi_y", "phi_z")
        rows = [f"{name};{row}" for name, row in zip(motions, rows, strict=True)]
    rig = rig_with(tmp_path, "\n".join([header, *rows]))
    np.testing.assert_allclose(rig.compliance.diagonal(), [5e-6, 1e-6, 2e-6, 2e-5, 3e-5, 3e-6])


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("Qx,Qy,N,Mx,My,Mz", "its columns from line 1 on are named Qx, Qy, N, Mx, My, Mz; P, Mx, My, Qx, Qy, Mz are"),
        ("Qx,Qx,P,Mx,My,Mz", "its columns from line 1 on are named Qx, Qx, P, Mx, My, Mz"),
        ("qx,qy,p,mx,my,mz", "its columns from line 1 on are named qx, qy, p, mx, my, mz"),
    ],
)
def test_misspelt_names_are_told(tmp_path: Path, header: str, message: str) -> None:
    with pytest.raises(CaseError) as refused:
        rig_with(tmp_path, f"{header}\n{lines(MATRIX)}")
    assert message in str(refused.value)
    with pytest.raises(CaseError, match="its rows from line 1 on are named dx, dx, dx, dx, dx, dx; delta_z, phi_x"):
        rig_with(tmp_path, "\n".join(f"dx, {row}" for row in lines(MATRIX).splitlines()))


def test_digits_that_a_file_loses_are_made_up_by_the_mean(tmp_path: Path) -> None:
    matrix = MATRIX.copy()
    matrix[0, 2], matrix[2, 0] = 1.000e-6, 1.0005e-6
    assert rig_with(tmp_path, lines(matrix)).compliance[0, 3] == pytest.approx(1.00025e-6)


def test_a_file_of_zeros_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="all of it is 0; leave the rig out"):
        rig_with(tmp_path, lines(0.0 * MATRIX))


def test_validate_says_the_stiffness_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "rig.csv").write_text(lines(MATRIX))
    said = list(rig_lines(set_up(case_with(tmp_path, "compliance: rig.csv"))))
    assert said[1] == (
        "rig.csv: stiffness of each motion alone: delta_z 2e+05 N/mm, phi_x 1e+06 N mm/rad, phi_y 5e+05 N mm/rad,"
        " delta_x 5e+04 N/mm, delta_y 3.333e+04 N/mm, phi_z 3.333e+05 N mm/rad"
    )


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"the compliance cannot be read: .*No such file"):
        rig_of(case_with(tmp_path, "compliance: gone.csv"))


def test_known_loads_bend_the_rig_before_the_contact_is_solved(tmp_path: Path) -> None:
    """P is imposed: by its motion of the actuator along x the contact moves less."""
    matrix = MATRIX.copy()
    matrix[0, 2] = matrix[2, 0] = 2e-6
    (tmp_path / "rig.csv").write_text(lines(matrix))
    case = case_with(tmp_path, "compliance: rig.csv")
    path = LoadPath(case.stages(), derive_model(case))
    touching: Any = SimpleNamespace(actuator_x=0.0)
    second = path.increment(path.increments - 1, [touching] * path.increments)
    assert second.tangential.values[0] == pytest.approx(2e-3 - 400.0 * 2e-6)
    assert second.tangential.compliance is not None
    assert second.tangential.compliance[0][0] == 2e-5
    assert second.normal.forced == (True, False, False)  # tilts are held at the actuator
    assert second.normal.sprung_index == [1, 2]
    assert second.coupling is None


def test_a_motion_of_the_contact_that_the_rig_couples_is_refused(tmp_path: Path) -> None:
    matrix = MATRIX.copy()
    matrix[0, 4] = matrix[4, 0] = 1e-6  # phi_y under Qx
    (tmp_path / "rig.csv").write_text(lines(matrix))
    with pytest.raises(CaseError) as refused:
        rig_of(case_with(tmp_path, "compliance: rig.csv", "delta_x"))
    assert refused.value.key == ("stage", 2, "delta_x")
    message = "delta_x is imposed at the contact, but the rig couples it with actuator_phi_y, which is held or moved"
    assert f"{message}; impose actuator_x" in str(refused.value)
    (tmp_path / "rig.csv").write_text(lines(MATRIX))
    assert rig_of(case_with(tmp_path, "compliance: rig.csv", "delta_x")) is not None
