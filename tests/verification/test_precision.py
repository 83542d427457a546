"""Single precision: certified to its tolerance, the same results as in double within it, resumed bit for bit."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import pytest
from command_line import invoke
from small_cases import write_case
from solving import DISSIMILAR, build

from fretsolve import load_case, open_result, run
from fretsolve.problem.setup.cost_estimate import estimate
from fretsolve.simulation.problem_setup import set_up

PARTS = {
    "bodies": DISSIMILAR,
    "grid": {"points": 48, "size": 0.8},
    "load_path": [
        {"P": 400.0, "increments": 2},
        {"Qx": 30.0, "Mz": 1.0, "increments": 2},
        {"Qx": -30.0, "increments": 3},
        {"P": 250.0, "Qx": 0.0, "increments": 2},
    ],
}
SCALES = {"delta_z": 1.0, "delta_x": 1.0, "contact_radius": 1.0, "stick_radius": 10.0, "max_pressure": 5.0, "Qx": 1.0}


def case(precision, tolerance):
    return build(**PARTS, solver={"precision": precision, "tolerance": tolerance})


@pytest.fixture(scope="module")
def exact():
    # with a tolerance of 1e-8 the zones tell smaller slips: three cells fewer stick at the end
    return list(run(case("double", 1e-6)))


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5])
def test_certified_and_as_in_double_precision(exact, tolerance):
    states = list(run(case("single", tolerance)))
    assert len(states) == len(exact)
    assert max(state.summary.worst_residual for state in states) <= tolerance
    for name, factor in SCALES.items():
        found, wanted = (np.array([getattr(state.summary, name) for state in path]) for path in (states, exact))
        allowed = factor * tolerance * np.abs(wanted).max()
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=allowed, err_msg=name)
    for state, other in zip(states, exact, strict=True):
        stored = {name: array for name, array in vars(state.fields).items() if name != "zone" and array is not None}
        assert {array.dtype for array in stored.values()} == {np.dtype(np.float32)}
        assert state.displacement.dtype == np.float32
        assert np.mean(state.fields.zone != other.fields.zone) < 5e-3


@pytest.mark.parametrize("done", [1, 4, 7])
def test_resuming_gives_the_same_to_the_last_bit(done):
    states = list(run(case("single", 1e-4)))
    resumed = run(case("single", 1e-4), states[done - 1], [state.summary for state in states[:done]])
    for found, wanted in zip(resumed, states[done:], strict=True):
        for name, array in vars(wanted.fields).items():
            np.testing.assert_array_equal(getattr(found.fields, name), array)
        rows = [asdict(state.summary) | {"wall_time": 0.0} for state in (found, wanted)]
        assert rows[0] == rows[1]


TEXT = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 100 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 24}
friction: 0.2
load_path: [{P: 400 N, increments: 2}, {Qx: 30 N, increments: 2}]
solver: {precision: single}
output: {fields: [pressure, shear, slip, slip_path, work_density, zone, gap]}
"""


def test_result_has_fields_in_single_precision(tmp_path):
    path = write_case(tmp_path, TEXT)
    done = invoke("run", path)
    assert done.exit_code == 0, done.stderr
    with open_result(path.with_suffix(".h5")) as result:
        assert result.effective_case["solver"]["tolerance"] == 1e-4
        assert json.loads(result.attributes["provenance"])["precision"] == "single"
        for name in result.fields:
            assert result.field(name).dtype == result.field_type(name)
            assert result.field_type(name) == (np.uint8 if name == "zone" else np.float32)
        assert result.history["delta_x"].dtype == np.float64


def test_error_bars(tmp_path):
    states = list(run(load_case(write_case(tmp_path, TEXT), ["solver.error_bars=true"])))
    assert len(states) == 4
    done = invoke("run", tmp_path / "case.yaml", "--error-bars")
    assert done.exit_code == 0, done.stderr
    with open_result(tmp_path / "case.h5") as result:
        assert 0.0 < result.history["delta_x_error"][-1] < 0.2 * result.history["delta_x"][-1]


def test_estimate_tells_what_is_saved(tmp_path):
    case = write_case(tmp_path, TEXT)
    precisions = {one: ["grid.points=2048", f"solver.precision={one}"] for one in ("double", "single")}
    double, single = (estimate(set_up(load_case(case, settings))) for settings in precisions.values())
    assert single.memory < 0.8 * double.memory
    assert single.file < 0.6 * double.file
    assert (double.saved, single.memory + single.saved) == (0.0, pytest.approx(double.memory))
    for name, settings in precisions.items():
        told = invoke("validate", case, *(word for setting in settings for word in ("--set", setting))).stdout
        assert ("single precision saves" in told) is (name == "single")
