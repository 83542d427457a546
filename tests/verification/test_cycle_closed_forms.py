"""The table of cycles of solved cases against closed forms of Mindlin & Deresiewicz, and of gross slip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from solving import FRICTION, HERTZ, LOAD, MATERIAL, A, build

from fretsolve import open_result
from fretsolve.reference.tangential import cattaneo_mindlin, full_stick_compliance
from fretsolve.result import HistoryWriter
from fretsolve.result.cycles.table import CycleTable
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header, solve_missing

LIMIT = FRICTION * LOAD
COMPLIANCE = MATERIAL.tangential
ONSET = 3.0 * LIMIT * COMPLIANCE / (16.0 * A)


class Unstopped:
    requested = False


def cycles(out: Path, cycle: dict, **parts: object) -> CycleTable:
    """The cycles of a case without Poisson's coupling of the directions, as the closed forms are."""
    path = [{"P": LOAD}, {"cycle": cycle}]
    setup = set_up(build(grid={"points": 48}, coupling="none", load_path=path, **parts))
    with HistoryWriter.open(out, run_header(setup, 1, ())) as writer:
        assert solve_missing(setup, writer, Unstopped())
    with open_result(out) as result:
        assert result.cycles is not None
        return result.cycles


def test_partial_slip(tmp_path: Path) -> None:
    """Q = 0.9 mu P: the dissipated energy of a cycle, the loop's width at Q = 0, and the slope of full stick."""
    force = 0.9 * LIMIT
    table = cycles(tmp_path / "out.h5", {"amplitude": {"Qx": force}, "times": 2, "increments": 40})
    mindlin = cattaneo_mindlin(HERTZ, FRICTION, force, COMPLIANCE)
    columns = {name: column[-1] for name, column in table.columns.items()}
    assert columns["dissipated_energy"] == pytest.approx(mindlin.work_per_cycle, rel=5e-3)
    assert columns["force_range"] == pytest.approx(2.0 * force)
    assert columns["displacement_range"] == pytest.approx(2.0 * mindlin.delta_x, rel=2e-3)
    box = 4.0 * force * mindlin.delta_x
    assert columns["energy_ratio"] == pytest.approx(mindlin.work_per_cycle / box, rel=5e-3)
    half = cattaneo_mindlin(HERTZ, FRICTION, 0.5 * force, COMPLIANCE)
    width = 2.0 * half.delta_x - mindlin.delta_x  # unloading by Q/2 is half of a loop twice as large
    assert columns["sliding_amplitude"] == pytest.approx(abs(width), rel=1e-2)
    assert columns["sliding_ratio"] == pytest.approx(abs(width) / mindlin.delta_x, rel=1e-2)
    stiffness = 1.0 / full_stick_compliance(A, COMPLIANCE)
    assert columns["reversal_stiffness"] == pytest.approx(stiffness, rel=5e-3)
    # The edge slips by what the rigid displacement exceeds the elastic one of the sliding contact there.
    assert 0.0 < columns["slip_amplitude"] < mindlin.delta_x


@pytest.mark.slow
def test_partial_slip_on_a_rig(tmp_path: Path) -> None:
    """Certified: an actuator at 1.583748 um has 36 N on 50 kN/mm, where the loop begins with these slopes."""
    cycle = {"amplitude": {"actuator_x": 1.583748e-3}, "times": 2, "increments": 40}
    table = cycles(tmp_path / "out.h5", cycle, rig={"stiffness_x": 50e3})
    columns = {name: column[-1] for name, column in table.columns.items()}
    assert columns["force_range"] == pytest.approx(72.0, rel=2e-3)
    assert columns["displacement_range"] == pytest.approx(2.0 * (1.583748e-3 - 36.0 / 50e3), rel=2e-3)
    assert columns["actuator_displacement_range"] == pytest.approx(2.0 * 1.583748e-3)
    assert columns["reversal_stiffness"] == pytest.approx(54499.01, rel=5e-3)
    assert columns["actuator_reversal_stiffness"] == pytest.approx(26076.33, rel=5e-3)
    # At the mean force, 0, the spring is slack, so that both loops are as wide; as high they are, too.
    assert columns["actuator_sliding_amplitude"] == pytest.approx(columns["sliding_amplitude"], rel=1e-4)
    shares = columns["actuator_energy_ratio"] / columns["energy_ratio"]
    assert shares == pytest.approx(columns["displacement_range"] / columns["actuator_displacement_range"], rel=1e-12)
    assert (table.units["actuator_sliding_amplitude"], table.units["actuator_reversal_stiffness"]) == ("mm", "N/mm")


@pytest.mark.slow
def test_gross_slip(tmp_path: Path) -> None:
    """Between +-2 um all slips from 2 x 1.1 um on: the energy 4 mu P (D - 4/5 d), where d is the onset."""
    table = cycles(tmp_path / "out.h5", {"amplitude": {"delta_x": 2e-3}, "times": 2, "increments": 40})
    columns = {name: column[-1] for name, column in table.columns.items()}
    assert columns["dissipated_energy"] == pytest.approx(4.0 * LIMIT * (2e-3 - 0.8 * ONSET), rel=2e-3)
    assert columns["energy_ratio"] == pytest.approx((2e-3 - 0.8 * ONSET) / 2e-3, rel=2e-3)
    # Unloading by mu P takes 2 d (1 - (1/2)^(2/3)) of the 2 um.
    width = 2e-3 - 2.0 * ONSET * (1.0 - 0.5 ** (2.0 / 3.0))
    assert columns["sliding_amplitude"] == pytest.approx(width, rel=5e-3)
    assert columns["sliding_ratio"] == pytest.approx(width / 2e-3, rel=5e-3)
    assert columns["reversal_stiffness"] == pytest.approx(8.0 * A / COMPLIANCE, rel=2e-2)


def test_bars_hold_the_closed_forms(tmp_path: Path) -> None:
    force = 0.8 * LIMIT
    cycle = {"amplitude": {"Qx": force}, "times": 1, "increments": 20}
    table = cycles(tmp_path / "out.h5", cycle, solver={"error_bars": True})
    mindlin = cattaneo_mindlin(HERTZ, FRICTION, force, COMPLIANCE)
    exact = {
        "dissipated_energy": mindlin.work_per_cycle,
        "energy_ratio": mindlin.work_per_cycle / (4.0 * force * mindlin.delta_x),
        "displacement_range": 2.0 * mindlin.delta_x,
        "reversal_stiffness": 8.0 * A / COMPLIANCE,
    }
    for name, value in exact.items():
        error = table.columns[f"{name}_error"][-1]
        assert abs(table.columns[name][-1] - value) <= error
        assert error < 0.3 * value
    assert np.isfinite(table.columns["sliding_ratio_error"]).all()
