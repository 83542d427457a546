"""The names of cases, by which studies and sweeps find the results that are there."""

from __future__ import annotations

from pathlib import Path

from small_cases import SPHERE, write_case

from fretsolve.sweep.plan import make_sweep_plan


def test_cases_keep_their_names_from_version_to_version(tmp_path: Path) -> None:
    """With other names every case of a folder would be solved again. A new version of the program changes them."""
    write_case(tmp_path, SPHERE + "load_path:\n  - {P: 400 N}\n")
    sweep = write_case(tmp_path, "case: case.yaml\naxes:\n  - friction: [0.1, 0.2]\n", "sweep.yaml")
    plan = make_sweep_plan(sweep, tmp_path / "sweep")
    assert [row.id for row in plan.manifest.rows] == ["ec42314f64c09485", "1c4491481b67220a"]
