"""A sweep over the seeds of a rough surface: the mean and scatter beside the table."""

from __future__ import annotations

import csv
import statistics
from pathlib import Path

import pytest
from command_line import invoke, refused
from small_cases import SPHERE
from sweeping import write_sweep

ROUGH = "- sphere: {radius: 10 mm}\n  - roughness: {hurst: 0.8, rms_height: 50 nm, cutoff: 80 um, span: 0.5 mm}"
CASE = (
    SPHERE.replace("{sphere: {radius: 10 mm}}", f"\n  {ROUGH}").replace("points: 16", "points: 20, size: 0.6 mm")
    + "load_path: [{P: 100 N}]\n"
)

pytestmark = pytest.mark.slow
SWEEP = """\
case: case.yaml
axes:
  - load_path.0.P: [100 N, 150 N]
  - surface.1.roughness.seed: [1, 2, 3]
quantities: [delta_z, max_pressure]
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep of two loads and three seeds."""
    path = write_sweep(tmp_path_factory.mktemp("seeds"), SWEEP, CASE)
    assert invoke("sweep", "run", path, "-j", 1, "-q").exit_code == 0
    return path.with_name("sweep.sweep")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_means_and_scatter_over_the_seeds(swept: Path) -> None:
    collected = invoke("sweep", "collect", swept)
    names = ["table.csv", "table.h5", "table.seeds.csv"]
    assert collected.stdout.splitlines() == [*(str(swept / name) for name in names), "6 cases: 6 complete"]
    cases, found = rows(swept / "table.csv"), rows(swept / "table.seeds.csv")
    assert [(row["seeds"], row["load_path.0.P (N)"]) for row in found] == [("3", "100"), ("3", "150")]
    assert "surface.1.roughness.seed" not in found[0]
    for place, row in enumerate(found):
        for name, unit in (("delta_z", "mm"), ("max_pressure", "MPa")):
            values = [float(case[f"{name} ({unit})"]) for case in cases[3 * place : 3 * place + 3]]
            assert len(set(values)) == 3
            assert float(row[f"{name} mean ({unit})"]) == pytest.approx(statistics.mean(values))
            scatter = float(row[f"{name} standard deviation ({unit})"])
            assert scatter == pytest.approx(statistics.stdev(values), rel=1e-6)


def test_foreign_files_are_not_replaced(swept: Path, tmp_path: Path) -> None:
    mine, seeds = tmp_path / "mine.csv", tmp_path / "mine.seeds.csv"
    seeds.write_text("mine")
    told = refused(2, "sweep", "collect", swept, "-o", mine)
    assert told == f"{seeds}: exists: --overwrite replaces it, or give another name with -o\n"
    assert not mine.exists()
    assert invoke("sweep", "collect", swept, "-o", mine, "--overwrite").exit_code == 0
    assert len(rows(seeds)) == 2
    own = swept / "table.seeds.csv"
    own.write_text("mine")
    assert "is not the table of a sweep, so it is not replaced" in refused(4, "sweep", "collect", swept)
    assert own.read_text() == "mine"
    own.unlink()


@pytest.mark.slow
def test_missing_case_is_not_counted(tmp_path: Path) -> None:
    path = write_sweep(tmp_path, SWEEP.replace("150 N", "100.1 N").replace("[1, 2, 3]", "[1, 2]"), CASE)
    assert invoke("sweep", "run", path, "-j", 1, "-q").exit_code == 0
    folder = path.with_name("sweep.sweep")
    sorted((folder / "results").glob("*.h5"))[0].unlink()
    invoke("sweep", "collect", folder)
    one, both = sorted(rows(folder / "table.seeds.csv"), key=lambda row: row["seeds"])
    assert (one["seeds"], both["seeds"]) == ("1", "2")
    assert one["delta_z mean (mm)"] != "" and one["delta_z standard deviation (mm)"] == ""


@pytest.mark.slow
def test_sweep_without_seeds_has_no_such_table(tmp_path: Path) -> None:
    text = SWEEP.replace("  - surface.1.roughness.seed: [1, 2, 3]\n", "").replace(", 150 N", "")
    path = write_sweep(tmp_path, text, CASE)
    assert invoke("sweep", "run", path, "-j", 1, "-q").exit_code == 0
    assert "seeds" not in invoke("sweep", "collect", path.with_name("sweep.sweep")).stdout.replace(str(tmp_path), "")
