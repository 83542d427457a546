"""Sweeps of cases with a rig: what is collected, and running conditions over the amplitude of the actuator."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from command_line import invoke, refused
from pictures import panels
from small_cases import SPHERE, write_case

from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.plan import make_sweep_plan
from fretsolve.sweep.plot import running_condition_map
from fretsolve.sweep.table import collect

pytestmark = pytest.mark.slow

PATH = "load_path: [{P: 400 N}, {cycle: {amplitude: {actuator_x: 1 um}, times: 1, increments: 4}}]\n"
CASE = SPHERE.replace("points: 16", "points: 12") + PATH + "rig: {stiffness_x: 50 kN/mm}\n"
SWEEP = """\
case: case.yaml
axes:
  - load_path.1.cycle.amplitude.actuator_x: [1.7 um, 2.2 um]
  - rig.stiffness_x: [20 kN/mm, 500 kN/mm]
quantities: [actuator_x, spring_energy, actuator_displacement_range, Qx]
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("swept")
    write_case(folder, CASE)
    done = invoke("sweep", "run", write_case(folder, SWEEP, "sweep.yaml"), "-j", 1)
    assert done.exit_code == 0, done.output
    assert invoke("sweep", "collect", folder / "sweep.sweep").exit_code == 0
    return folder / "sweep.sweep"


def test_a_soft_rig_keeps_the_contact_in_partial_slip(swept: Path) -> None:
    """By Mindlin all slips from 1.1 um at the contact on, which 40 N make 3.1 um on 20 kN/mm, 1.2 um on 500 kN/mm."""
    with (swept / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["running_condition"] for row in rows] == ["partial slip", "gross slip"] * 2
    for row, amplitude, stiffness in zip(rows, (1.7e-3, 1.7e-3, 2.2e-3, 2.2e-3), (20e3, 500e3) * 2, strict=True):
        assert float(row["actuator_x (mm)"]) == pytest.approx(amplitude, rel=1e-9)
        assert float(row["actuator_displacement_range (mm)"]) == pytest.approx(2.0 * amplitude, rel=1e-9)
        assert float(row["spring_energy (mJ)"]) == pytest.approx(0.5 * float(row["Qx (N)"]) ** 2 / stiffness, rel=1e-9)


def test_the_map_has_the_amplitude_of_the_actuator_on_its_axis(swept: Path) -> None:
    over = ("load_path.1.cycle.amplitude.actuator_x", "rig.stiffness_x")
    (axes, *_) = panels(running_condition_map(collect(read_manifest(swept)), over))
    assert axes.get_xlabel() == "displacement amplitude of the actuator $D_x$ (µm)"
    assert axes.get_ylabel() == "stiffness of the rig along x (kN/mm)"


def test_by_default_the_responses_of_what_the_rig_moves_are_collected(tmp_path: Path) -> None:
    """The actuator is imposed, and along z the rig does not give."""
    write_case(tmp_path, CASE)
    sweep = "case: case.yaml\naxes: [{rig.stiffness_x: [20 kN/mm, 50 kN/mm]}]\n"
    manifest = make_sweep_plan(write_case(tmp_path, sweep, "sweep.yaml"), tmp_path / "sweep.sweep").manifest
    contact = {"contact_radius", "stick_radius", "max_pressure", "work_total"}
    assert set(manifest.quantities) == {"Qx", "delta_z", "delta_x", *contact}


def test_motions_of_an_actuator_are_known_with_a_rig_alone(tmp_path: Path) -> None:
    write_case(tmp_path, CASE.replace("rig: {stiffness_x: 50 kN/mm}\n", "").replace("actuator_x", "delta_x"))
    sweep = "case: case.yaml\naxes: [{friction: [0.1, 0.2]}]\nquantities: [NAME]\n"
    for name in ("actuator_x", "spring_energy", "actuator_sliding_ratio"):
        told = refused(2, "sweep", "run", write_case(tmp_path, sweep.replace("NAME", name), "sweep.yaml"))
        assert f"{name} is known from runs with rig alone; rig in the case is needed" in told
    told = refused(
        2,
        "study",
        tmp_path / "case.yaml",
        "--vary",
        "grid.points=16,20",
        "--quantity",
        "actuator_x",
        "-o",
        tmp_path / "o",
    )
    assert "--quantity actuator_x: it is known with rig alone; rig in the case is needed" in told
