"""Runs with a friction law: saved and resumed, with error bars, in single precision, and by both ways to couple."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from line_cases import solve_line
from solving import DISSIMILAR, build, solve

import fretsolve.contact.increment.staggered_iteration
from fretsolve import open_result, run
from fretsolve.result import HistoryWriter
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header

RUNNING_IN = {"initial": 0.1, "final": 0.3, "slip": "0.5 um", "shear_limit": 200.0}
LAWS = [
    {"coefficient": 0.3, "shear_limit": 150.0},
    {"coefficient": 0.1, "exponent": 2 / 3, "reference_pressure": 2000.0},
    {"coefficient": [0.2, 0.1], "angle": "30 deg"},
    {"expression": "0.1 + 0.3*(r < 0.1)"},
]


def test_resumed_in_the_middle_it_has_the_same_bits(tmp_path: Path) -> None:
    path = [{"P": 400.0}, {"Qx": 30.0, "increments": 3}, {"Qx": -30.0, "increments": 3}]
    output = {"fields": ["pressure", "friction", "shear_bound"], "every": 4}
    setup = set_up(build(friction=RUNNING_IN, grid={"points": 24}, load_path=path, output=output))
    states, header = list(run(setup)), run_header(setup, 1, ())
    out = tmp_path / "run.h5"
    for first, last in ((0, 3), (3, 7)):
        with HistoryWriter.open(out, header, resume=first > 0) as writer:
            begin = writer.last_state
            assert (begin is None) == (first == 0)
            for state in list(run(setup, begin, tuple(writer.summaries)))[: last - first]:
                writer.append(state)
    with HistoryWriter.open(out, header, resume=True) as writer:  # all is there but the end
        writer.finish("complete")
    with open_result(out) as result:
        assert result.steps == (3, 6)
        for step in result.steps:
            for name in ("pressure", "friction", "shear_bound"):
                assert (result.field(name, step) == getattr(states[step].fields, name)).all()
        assert (result.field("friction").min(), result.units("friction")) == (0.1, "1")
        assert result.units("shear_bound") == "MPa"


def test_error_bars() -> None:
    path = [{"P": 400.0}, {"Qx": 20.0, "increments": 2}]
    parts = {"grid": {"points": 32}, "load_path": path, "solver": {"error_bars": True}}
    for friction in LAWS:
        last = list(run_with_error_bars(build(friction=friction, **parts)))[-1]
        assert last.errors is not None
        assert 0.0 < last.errors.delta_x_error < 0.05 * last.summary.delta_x


@pytest.mark.parametrize("friction", LAWS, ids=["limit", "power", "axes", "formula"])
class TestBothPrecisionsAndSolvers:
    PATH = ({"P": 400.0, "increments": 2}, {"Qx": 25.0, "Qy": 5.0, "increments": 2})

    def test_coupled_newton_finds_what_staggered_iterations_find(self, friction, monkeypatch) -> None:
        parts = {"friction": friction, "bodies": DISSIMILAR, "grid": {"points": 32}, "load_path": list(self.PATH)}
        staggered = solve(**parts)[-1]
        monkeypatch.setattr(fretsolve.contact.increment.staggered_iteration, "ENOUGH_ITERATIONS", 1)
        coupled = solve(**parts)[-1]
        assert coupled.summary.alternations < staggered.summary.alternations
        assert np.abs(coupled.fields.shear - staggered.fields.shear).max() < 0.01
        assert coupled.summary.delta_x == pytest.approx(staggered.summary.delta_x, rel=1e-6)


def test_line_contact() -> None:
    grid, path = {"points": 96}, [{"P": 100.0}, {"Qx": 18.0, "increments": 1}]
    one, other = (
        solve_line(friction=friction, grid=grid, load_path=path)[-1] for friction in (0.3, {"expression": "0.3"})
    )
    assert other.fields.shear == pytest.approx(one.fields.shear, abs=1e-3)
    assert other.summary.stick_radius == pytest.approx(one.summary.stick_radius, rel=1e-6)
    stuck = solve_line(friction={"expression": "0.1 + 0.4*(abs(x) < 0.05)"}, grid=grid, load_path=path)[-1].summary
    assert 0.0 < stuck.stick_radius < 0.05
