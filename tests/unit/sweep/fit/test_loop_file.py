"""Reading a measured loop: its columns, units and decimal signs, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fretsolve.case.dimensions import FORCE, LENGTH
from fretsolve.errors import CaseError, FileError
from fretsolve.sweep.fit.loop_file import read_loop_file

ROWS = [(0.5 * k, 1.5 * k - 3.0) for k in range(12)]
TABLE = "Qx (N),actuator_x (um)\n" + "".join(f"{q},{d}\n" for q, d in ROWS)


def read(folder: Path, text: str, names: tuple[str, str] = ("Qx", "actuator_x")) -> tuple[np.ndarray, np.ndarray]:
    (folder / "loop.csv").write_text(text, encoding="utf-8")
    return read_loop_file(folder / "loop.csv", names, (FORCE, LENGTH))


def message(folder: Path, text: str, names: tuple[str, str] = ("Qx", "actuator_x")) -> str:
    with pytest.raises(CaseError) as caught:
        read(folder, text, names)
    return str(caught.value).removeprefix(f"{folder / 'loop.csv'}")


@pytest.mark.parametrize(
    "text",
    [
        TABLE,
        TABLE.replace(",", ";").replace(".", ","),
        TABLE.replace(",", "\t").replace(".", ","),
        "\ufeff# of the rig\n" + TABLE.replace(",", ";") + "\n\n",
        "time (s)," + TABLE.replace("\n", "\n7.5,")[: -len("7.5,")],
        TABLE.replace("(um)", "[µm]"),
        '"Qx (N)","actuator_x (um)"\n' + TABLE.partition("\n")[2],
    ],
)
def test_forms_of_a_table(tmp_path: Path, text: str) -> None:
    force, motion = read(tmp_path, text)
    np.testing.assert_allclose(force, [q for q, _ in ROWS])
    np.testing.assert_allclose(motion, [1e-3 * d for _, d in ROWS])


def test_other_columns_and_units(tmp_path: Path) -> None:
    text = TABLE.replace("Qx (N)", "Force (kN)").replace("actuator_x (um)", "Stroke (mm)")
    force, motion = read(tmp_path, text, ("Force", "Stroke (mm)"))
    assert (force[1], motion[0]) == (500.0, -3.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Qx (N)\n1\n2\n", ":1: has one column; two, such as 'Qx (N)' and 'actuator_x (um)', are needed"),
        ("1,2\n3,4\n", ":1: the first line holds numbers; headings such as 'Qx (N)' and 'actuator_x (um)' are needed"),
        ("", ": is empty; a CSV with headings is needed"),
        ("\n".join(TABLE.splitlines()[:8]), ": has 7 points; at least 10 are needed"),
        (
            TABLE.replace("1.5,1.5", "nan,1.5"),
            ":5: 'nan' in the column 'Qx (N)' is not finite; a number such as 12.5 is needed",
        ),
        (
            TABLE.replace("1.5,1.5", "1.5"),
            ":5: '' in the column 'actuator_x (um)' is no number; a number such as 12.5 is needed",
        ),
        ("Qx (N),actuator_x (um)\n" + 12 * "3,4\n", ": the column 'Qx (N)' is constant; a loop moves force and motion"),
        (
            TABLE.replace("actuator_x", "actuator"),
            ":1: no column 'actuator_x'; did you mean 'actuator'? (--columns FORCE,MOTION takes other names)",
        ),
        (
            TABLE.replace(" (um)", ""),
            ":1: the heading 'actuator_x' has no unit; one such as 'actuator_x (um)' is needed",
        ),
        (
            TABLE.replace("(um)", "(N)"),
            ":1: the heading 'actuator_x (um)': 'N' is a force; a length such as '10 mm' is needed".replace(
                "(um)", "(N)"
            ),
        ),
        (
            TABLE.replace(",", ";").replace("1.5;1.5", "1,5;1.5"),
            ": mixes decimal points and decimal commas; one of the two is needed",
        ),
        (TABLE.replace("actuator_x (um)", "Qx (N)"), ":1: the column 'Qx' is there 2 times; one is needed"),
    ],
)
def test_refused_tables(tmp_path: Path, text: str, said: str) -> None:
    names = ("Qx", "Qx") if "2 times" in said else ("Qx", "actuator_x")
    assert message(tmp_path, text, names) == said


def test_one_column_twice(tmp_path: Path) -> None:
    assert message(tmp_path, TABLE, ("Qx", "Qx")) == ":1: Qx and Qx are one column; two are needed"


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read: No such file"):
        read_loop_file(tmp_path / "none.csv", ("Qx", "delta_x"), (FORCE, LENGTH))


def test_headings_below_other_lines_are_told(tmp_path: Path) -> None:
    file = tmp_path / "loop.csv"
    rows = "\n".join(f"{0.1 * k};{k % 7}" for k in range(20))
    file.write_text(f"Operator;Me\nrig;3\nQx (N);actuator_x (um)\n{rows}\n")
    with pytest.raises(CaseError, match="line 3 has the headings; remove the lines above it, or begin them with #"):
        read_loop_file(file, ("Qx", "actuator_x"), (FORCE, LENGTH))


def test_utf_16_with_its_mark_is_read(tmp_path: Path) -> None:
    file = tmp_path / "loop.csv"
    rows = "\n".join(f"{k % 7};{0.1 * k}" for k in range(20))
    file.write_text(f"Qx (N);actuator_x (µm)\n{rows}\n", encoding="utf-16")
    force, motion = read_loop_file(file, ("Qx", "actuator_x"), (FORCE, LENGTH))
    assert force[3] == 3.0
    assert motion[3] == pytest.approx(0.3e-3)
