"""Loops of line contacts over the motion of points at a reference depth: error bars, cycles, pictures, sweeps."""

from __future__ import annotations

import csv
import math

import pytest
from command_line import invoke, refused
from small_cases import write_case

from fretsolve import open_result

CASE = """\
plane: strain
bodies: [{young_modulus: 210 GPa, poisson_ratio: 0.3}, {young_modulus: 210 GPa, poisson_ratio: 0.3}]
surface: {cylinder: {radius: 10 mm}}
grid: {points: 48}
friction: 0.5
reference_depth: 10 mm
load_path:
  - {P: 100 N/mm}
  - {Qx: 25 N/mm, increments: 4}
  - cycle: {amplitude: {delta_x: 3 um}, times: 2, increments: 12}
"""
RIG = CASE.replace("delta_x: 3 um", "actuator_x: 6 um") + "rig: {stiffness_x: 20 kN/mm^2}\n"
BARS = "solver: {error_bars: true}\n"
WITHOUT = CASE.replace("delta_x: 3 um", "Qx: 45 N/mm").replace("reference_depth: 10 mm\n", "")


def result_of(folder, case):
    done = invoke("run", write_case(folder, case), "-q", "--overwrite")
    assert done.exit_code == 0, done.output
    return open_result(folder / "case.h5")


def test_imposed_motions_are_as_they_are(tmp_path):
    with result_of(tmp_path, CASE) as result:
        motions = result.history["delta_x"]
        assert (motions[-1], motions[-13], motions[7]) == (3e-3, 3e-3, 3e-3)
        assert motions[4] == pytest.approx(0.8437161e-3, rel=3e-4)


def test_error_bars(tmp_path):
    """Imposed motions have none; under forces and on a rig they hold the closed form."""
    with result_of(tmp_path, CASE + BARS) as result:
        errors = result.history["delta_x_error"]
        assert errors[5:].max() < 1e-9
        assert 0.0 < abs(result.history["delta_x"][4] - 0.8437161e-3) < errors[4] < 0.01e-3
        assert math.isnan(result.history["delta_y_error"][4])
        # 4 mu P (D - u), u = (A mu P/pi) (ln(2L/a) + 1/4)
        energy, bar = (result.cycles.columns[f"dissipated_energy{kind}"][-1] for kind in ("", "_error"))
        u = 1.7333333e-5 * 50.0 / math.pi * (math.log(2.0 * 10.0 * math.exp(0.5 / 0.7) / 0.1050456) + 0.25)
        assert energy == pytest.approx(200.0 * (3e-3 - u), abs=bar)
    with result_of(tmp_path, RIG + BARS) as result:
        assert result.history["actuator_x"][-1] == 6e-3
        assert result.history["actuator_x_error"][-1] == 0.0
        assert 0.0 < result.history["delta_x_error"][-1] < 1e-5


def test_cycles(tmp_path):
    with result_of(tmp_path, CASE) as result:
        row = {name: values[-1] for name, values in result.cycles.columns.items()}
    assert row["displacement_range"] == pytest.approx(6e-3, rel=1e-9)
    assert row["energy_ratio"] == pytest.approx(row["dissipated_energy"] / 100.0 / 6e-3, rel=1e-6)
    assert row["reversal_stiffness"] == pytest.approx(30393.17, rel=0.02)
    # half of the width at no force: D less the motion from mu P back to 0, which is twice that of mu P/2
    assert row["sliding_amplitude"] == pytest.approx(3e-3 - 2.0 * 0.8437161e-3, rel=0.01)
    assert row["displacement_drift"] == 0.0
    with result_of(tmp_path, RIG) as result:
        row = {name: values[-1] for name, values in result.cycles.columns.items()}
    assert row["actuator_displacement_range"] == pytest.approx(12e-3, rel=1e-9)
    assert row["actuator_reversal_stiffness"] == pytest.approx(12062.42, rel=0.02)
    assert row["actuator_sliding_amplitude"] == pytest.approx(row["sliding_amplitude"], rel=1e-4)


def test_without_a_depth_motions_of_cycles_are_unknown_and_said_to_be(tmp_path):
    with result_of(tmp_path, WITHOUT) as result:
        assert math.isnan(result.cycles.columns["displacement_range"][-1])
        assert result.cycles.columns["dissipated_energy"][-1] > 0.0
    picture = invoke("plot", tmp_path / "case.h5", "loop")
    assert "have an unknown constant without reference_depth" in picture.output
    case = write_case(tmp_path, CASE.replace("reference_depth: 10 mm\n", ""))
    assert "give reference_depth, or impose Qx" in refused(2, "validate", case)
    expects = WITHOUT + "expect: [{quantity: delta_x, value: 1 um, rel: 1 %}]\n"
    assert "delta_x is NaN in a line contact without reference_depth" in refused(
        2, "check", write_case(tmp_path, expects)
    )


def test_pictures(tmp_path):
    with result_of(tmp_path, RIG):
        for kind in ("loop", "stick-history", "profiles"):
            assert invoke("plot", tmp_path / "case.h5", kind, "-o", tmp_path / f"{kind}.png").exit_code == 0


@pytest.mark.slow
def test_a_map_of_running_conditions_over_the_amplitude(tmp_path):
    """All slips from 1.4264 um on at friction 0.4, from 1.7830 um on at 0.5."""
    write_case(tmp_path, CASE.replace("times: 2, increments: 12", "times: 1, increments: 4"))
    sweep = """\
case: case.yaml
axes:
  - load_path.2.cycle.amplitude.delta_x: [1.2 um, 1.6 um, 2 um]
  - friction: [0.4, 0.5]
quantities: [displacement_range, Qx, sliding_ratio]
"""
    done = invoke("sweep", "run", write_case(tmp_path, sweep, "sweep.yaml"), "-j", 1)
    assert done.exit_code == 0, done.output
    assert invoke("sweep", "collect", tmp_path / "sweep.sweep").exit_code == 0
    with (tmp_path / "sweep.sweep" / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    partial, gross = "partial slip", "gross slip"
    assert [row["running_condition"] for row in rows] == [partial, partial, gross, partial, gross, gross]
    assert [float(row["displacement_range (mm)"]) for row in rows[::2]] == pytest.approx([2.4e-3, 3.2e-3, 4e-3])
    over = ("--over", "load_path.2.cycle.amplitude.delta_x", "--over", "friction")
    done = invoke("sweep", "plot", tmp_path / "sweep.sweep", "running-condition", *over, "-o", tmp_path / "map.png")
    assert done.exit_code == 0, done.output
