"""Sweeps and studies over cases with wear, whose number of solved cycles is found on the way."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from command_line import invoke, refused
from small_cases import LOOP, WORN, write_case

from fretsolve import open_result

SWEEP = """\
case: worn.yaml
axes: [{wear.alpha: [1e-5 mm^3/J, 1e-4 mm^3/J]}]
"""


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_volume_its_error_and_depth_are_collected(tmp_path: Path) -> None:
    write_case(tmp_path, WORN.replace("points: 24", "points: 16"), "worn.yaml")
    done = invoke("sweep", "run", write_case(tmp_path, SWEEP, "sweep.yaml"), "-j", 1)
    assert done.exit_code == 0, done.output
    assert invoke("sweep", "collect", tmp_path / "sweep.sweep").exit_code == 0
    little, much = rows(tmp_path / "sweep.sweep" / "table.csv")
    assert float(much["wear_volume (mm^3)"]) == pytest.approx(10.0 * float(little["wear_volume (mm^3)"]), rel=0.05)
    assert 0.0 < float(much["wear_error (mm^3)"]) < float(much["wear_volume (mm^3)"])
    assert 0.0 < float(little["wear_depth_max (mm)"]) < float(much["wear_depth_max (mm)"])


def test_a_study_compares_the_ends(tmp_path: Path) -> None:
    case = write_case(tmp_path, WORN, "worn.yaml")
    done = invoke("study", case, "--vary", "grid.points=16,24", "--quantity", "wear_volume", "-o", tmp_path / "study")
    assert done.exit_code == 0, done.output
    table = rows(tmp_path / "study" / "study.csv")
    *_, last = (name for name in table[0] if name.startswith("wear_volume@"))
    for row in table:
        with open_result(tmp_path / "study" / row["result"]) as result:
            assert float(row[last]) == pytest.approx(result.history["wear_volume"][-1], rel=1e-9)
    (error,) = (float(row["worst error (%)"]) for row in table if row["role"] != "reference")
    assert 0.0 < error < 10.0


def test_without_wear_nothing_of_it_is_known(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP, "worn.yaml")
    sweep = SWEEP.replace("wear.alpha: [1e-5 mm^3/J, 1e-4 mm^3/J]", "friction: [0.1, 0.2]")
    path = write_case(tmp_path, f"{sweep}quantities: [wear_volume]\n", "sweep.yaml")
    assert "wear_volume is known from runs with wear alone; wear in the case is needed" in refused(
        2, "sweep", "run", path
    )
    words = ("study", case, "--vary", "grid.points=16,24", "--quantity", "wear_volume", "-o", tmp_path / "study")
    assert "it is known with wear alone; wear in the case is needed" in refused(2, *words)
