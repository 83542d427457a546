"""Spots of contact: how many there are, what each carries, and which have too few cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from fretsolve import open_result
from fretsolve.cli.main import main
from fretsolve.export.spots import may_have_spots, spots_of

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
    (folder / "case.yaml").write_text(CASE)
    ran = CliRunner().invoke(main, ["run", str(folder / "case.yaml"), "-q"])
    assert ran.exit_code == 0, ran.output
    return folder / "case.h5"


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
    text = CliRunner().invoke(main, ["show", str(out)]).stdout
    with open_result(out) as result:
        found = spots_of(result)
    assert "spot  cells" in text
    small = sum(spot.cells < 10 for spot in found)
    line = next(line for line in text.splitlines() if "spots of contact" in line)
    assert line.startswith(f"{len(found)} spots of contact at the last increment")
    assert (f"; {small} have less than 10 cells" in line) == (small > 0)


def test_a_sphere_is_not_looked_at(tmp_path: Path) -> None:
    case = CASE.replace("heights: {file: bumps.npy, spacing: 0.025 mm}", "sphere: {radius: 10 mm}")
    (tmp_path / "case.yaml").write_text(case)
    assert CliRunner().invoke(main, ["run", str(tmp_path / "case.yaml"), "-q"]).exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        assert not may_have_spots(result)
