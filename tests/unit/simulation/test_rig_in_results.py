"""What results of cases with a rig hold: error bars of the actuator, and the same numbers after a stop."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from command_line import invoke
from small_cases import CASE, SPHERE, write_case
from solving import LOAD, SIMILAR, build

from fretsolve import open_result
from fretsolve.case.history import ACTUATORS
from fretsolve.case.keys.rig_spec import RigSpec
from fretsolve.result import HistoryWriter
from fretsolve.result.layout import RIG_ERRORS
from fretsolve.result.state import Summary, SummaryErrors
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header, solve_missing

STIFFNESS = 50e3
FORCE, MOTION = 28.68037, 1.2e-3
"""Certified: force (N) at an actuator (mm) on this stiffness (N/mm)."""


def last_of(path: list[dict[str, Any]], **rig: float) -> tuple[Summary, SummaryErrors]:
    case = build(bodies=SIMILAR, coupling="none", grid={"points": 24}, rig=rig, load_path=[{"P": LOAD}, *path])
    state = list(run_with_error_bars(case))[-1]
    assert state.errors is not None
    return state.summary, state.errors


def test_an_imposed_actuator_is_exact_and_neither_force_nor_motion_of_the_contact_is() -> None:
    found, errors = last_of([{"actuator_x": MOTION, "increments": 4}], stiffness_x=STIFFNESS)
    assert errors.actuator_x_error == errors.actuator_x_corrected_error == 0.0
    assert errors.actuator_x_corrected == found.actuator_x == pytest.approx(MOTION, rel=1e-12)
    assert 0.0 < abs(found.Qx - FORCE) <= errors.Qx_error < 0.05 * FORCE
    assert abs(errors.Qx_corrected - FORCE) <= errors.Qx_corrected_error
    motion = MOTION - FORCE / STIFFNESS
    assert 0.0 < abs(found.delta_x - motion) <= errors.delta_x_error < 0.1 * motion
    energy = 0.5 * FORCE**2 / STIFFNESS
    assert 0.0 < abs(found.spring_energy - energy) <= errors.spring_energy_error < 0.1 * energy
    assert abs(errors.spring_energy_corrected - energy) <= errors.spring_energy_corrected_error


def test_under_a_force_the_actuator_errs_as_the_contact_does() -> None:
    """Certified: 1.583748 um at 36 N."""
    found, errors = last_of([{"Qx": 36.0, "increments": 4}], stiffness_x=STIFFNESS)
    assert errors.Qx_error < 1e-4
    assert errors.actuator_x_error == pytest.approx(errors.delta_x_error + errors.Qx_error / STIFFNESS, rel=1e-12)
    assert abs(found.actuator_x - 1.583748e-3) <= errors.actuator_x_error < 1e-4
    assert abs(errors.actuator_x_corrected - 1.583748e-3) <= errors.actuator_x_corrected_error
    assert errors.spring_energy_error < 1e-5 * found.spring_energy


def test_under_a_displacement_of_the_contact_the_force_errs_at_the_actuator() -> None:
    motion = MOTION - FORCE / STIFFNESS
    found, errors = last_of([{"delta_x": motion, "increments": 4}], stiffness_x=STIFFNESS)
    assert errors.delta_x_error < 1e-9
    assert errors.actuator_x_error == pytest.approx(errors.Qx_error / STIFFNESS, rel=1e-3)
    assert abs(found.actuator_x - MOTION) <= errors.actuator_x_error


def test_an_actuator_without_a_spring_moves_with_the_contact() -> None:
    """Nothing gives along x, so that the displacement of the contact is imposed."""
    found, errors = last_of([{"actuator_x": 0.5e-3, "increments": 2}], stiffness_z=STIFFNESS)
    assert found.delta_x == pytest.approx(0.5e-3, rel=1e-12)
    assert errors.delta_x_error == pytest.approx(0.0, abs=1e-9)
    assert errors.Qx_error > 0.0
    assert errors.actuator_z_error == pytest.approx(errors.delta_z_error, rel=1e-3)


class StopAfter:
    """Asks to stop after so many increments."""

    def __init__(self, increments: int):
        self.left = increments

    @property
    def requested(self) -> bool:
        self.left -= 1
        return self.left < 0


RIG = CASE.split("expect:")[0].replace("Qx: 20 N", "actuator_x: 1 um") + "rig: {stiffness_x: 50 kN/mm}\n"


def test_a_stopped_run_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    path = [{"P": 400.0}, {"actuator_x": 1e-3, "increments": 4}]
    setup = set_up(build(grid={"points": 16}, rig={"stiffness_x": STIFFNESS}, load_path=path))
    for name, stops in (("whole", [9]), ("stopped", [3, 9])):
        for increments in stops:
            with HistoryWriter.open(tmp_path / f"{name}.h5", run_header(setup, 1, ()), resume=True) as writer:
                assert solve_missing(setup, writer, StopAfter(increments)) is (increments == 9)
    with open_result(tmp_path / "whole.h5") as whole, open_result(tmp_path / "stopped.h5") as resumed:
        for name in ("Qx", "delta_x", "work_total", *ACTUATORS.values(), "spring_energy"):
            assert whole.history[name].tolist() == resumed.history[name].tolist()
        assert whole.history["actuator_x"][-1] == pytest.approx(1e-3, rel=1e-12)


def test_a_run_with_another_file_of_compliances_is_another_run(tmp_path: Path) -> None:
    """Sweeps and resumed runs go by the digests of the files that the case names."""
    setup = set_up(build(grid={"points": 16}))
    rig = RigSpec.model_construct(compliance=tmp_path / "rig.csv")
    setup = replace(setup, case=setup.case.model_copy(update={"rig": rig}))
    digests = []
    for text in ("1e-5,0", "2e-5,0"):
        rig.compliance.write_text(text)
        digests.append(json.loads(run_header(setup, 1, ()).inputs)["compliance of the rig"])
    assert digests[0] == hashlib.sha256(b"1e-5,0").hexdigest() != digests[1]


def test_files_and_lines_of_programs_have_the_actuator_with_a_rig_alone(tmp_path: Path) -> None:
    with_rig = invoke("run", write_case(tmp_path, RIG, "rig.yaml"), "--error-bars", "--log-json")
    assert with_rig.exit_code == 0, with_rig.stderr
    assert '"actuator_x": 0.001' in with_rig.stdout and '"spring_energy_error": ' in with_rig.stdout
    without = invoke("run", write_case(tmp_path, CASE), "--error-bars", "--log-json")
    assert "actuator" not in without.stdout and "spring" not in without.stdout
    with open_result(tmp_path / "rig.h5") as result:
        assert {column.name for column in RIG_ERRORS} <= set(result.history)
    shown = invoke("show", tmp_path / "rig.h5").stdout
    assert "actuator_x" in shown and "spring" in shown and "actuator_z" not in shown  # as the contact's own
    refused = invoke("show", tmp_path / "case.h5", "--columns", "actuator_x_error")
    assert refused.exit_code == 2
    assert "--columns: actuator_x_error is known with a rig alone; the case has none" in refused.stderr


def test_check_of_the_actuator_and_of_the_energy_in_the_springs(tmp_path: Path) -> None:
    """36 N bend 50 kN/mm by 0.72 um."""
    expect = "expect:\n  - {quantity: actuator_x, value: 1.583748 um, rel: 3 %}\n"
    expect += "  - {quantity: spring_energy, value: 0.01296 mJ, rel: 0.001 %}\n"
    path = "load_path: [{P: 400 N}, {Qx: 36 N, increments: 4}]\nrig: {stiffness_x: 50 kN/mm}\ncoupling: none\n"
    checked = invoke("check", write_case(tmp_path, SPHERE + path + expect))
    assert checked.exit_code == 0, checked.stdout
    cells = [line.split() for line in checked.stdout.splitlines()]
    assert cells[2][:4] == ["2", "actuator_x", "1.583748", "um"]
    assert cells[3][:4] == ["2", "spring_energy", "0.01296", "mJ"]


def test_the_table_of_csv_ends_with_what_belongs_to_the_rig(tmp_path: Path) -> None:
    assert invoke("run", write_case(tmp_path, RIG, "rig.yaml"), "-q").exit_code == 0
    assert invoke("export", tmp_path / "rig.h5", "--to", "csv").exit_code == 0
    heading = (tmp_path / "rig.csv").read_text(encoding="utf-8").splitlines()[0]
    assert heading.split(",")[-7:-3] == [
        "actuator_z (mm)",
        "actuator_x (mm)",
        "actuator_y (mm)",
        "actuator_phi_x (rad)",
    ]
    assert heading.endswith(",spring_energy (mJ)")


def test_cycles_of_an_actuator_run_until_they_are_periodic(tmp_path: Path) -> None:
    cycle = "{cycle: {amplitude: {actuator_x: 3 um}, until: periodic, increments: 4}}"
    case = f"{SPHERE}load_path: [{{P: 400 N}}, {cycle}]\nrig: {{stiffness_x: 50 kN/mm}}\n"
    assert invoke("run", write_case(tmp_path, case), "-q").exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        assert result.cycles is not None
        ((outcome, periodic),) = result.cycles.outcomes
        assert periodic and outcome.startswith("load_path.1.cycle: periodic after 2 cycles of at most 20")
        assert result.cycles.columns["actuator_displacement_range"] == pytest.approx([6e-3, 6e-3])
        assert result.cycles.columns["force_range"] == pytest.approx([80.0, 80.0], rel=1e-4)
