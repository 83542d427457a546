"""Cycles that run until they are periodic: when they end, what follows, and a resume in between."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from command_line import assert_same_result
from solving import DISSIMILAR, SIMILAR, build
from test_run_to_file import solve

from fretsolve import open_result, run, run_with_error_bars
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up


def setup_of(bodies: Any = DISSIMILAR, tolerance: float = 0.05, most: int = 6, **parts: Any) -> ProblemSetup:
    cycle = {"amplitude": {"Qx": 30.0}, "until": "periodic", "tolerance": tolerance, "at_most": most, "increments": 4}
    path = [{"P": 400.0, "increments": 2}, {"cycle": cycle}, {"Qx": 0.0, "increments": 2}]
    return set_up(build(**{"bodies": bodies, "grid": {"points": 16, "size": 0.8}, "load_path": path, **parts}))


def stages(setup: ProblemSetup) -> list[int]:
    return list(dict.fromkeys(state.summary.stage for state in run(setup)))


def test_equal_bodies_are_periodic_in_the_second_cycle() -> None:
    """The stages of the others are left out; the stage after them keeps its number."""
    assert stages(setup_of(SIMILAR)) == [1, 2, 3, 4, 5, 6, 15]


def test_ratcheting_bodies_take_more_cycles_or_do_not_end() -> None:
    assert stages(setup_of()) == [*range(1, 13), 15]
    assert stages(setup_of(tolerance=1e-9)) == list(range(1, 16))


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-3])
def test_a_periodic_cycle_is_near_the_limit_and_not_near_the_cycle_before(tolerance: float) -> None:
    """P to and fro with Q between unlike bodies, whose energy falls more slowly the longer it falls."""
    stages = [{"P": 300.0, "Qx": -40.0, "increments": 5}, {"P": 400.0, "Qx": 60.0, "increments": 5}]
    cycle: dict[str, Any] = {"stages": stages, "until": "periodic", "tolerance": tolerance, "at_most": 40}
    bodies = [{"young_modulus": 200e3, "poisson_ratio": 0.3}, {"young_modulus": 70e3, "poisson_ratio": 0.2}]

    def energy(**repeated: Any) -> float:
        cycles = {"stages": stages, **repeated} if repeated else cycle
        path = [{"P": 400.0, "increments": 5}, {"Qx": 60.0, "increments": 5}, {"cycle": cycles}]
        setup = setup_of(bodies, grid={"points": 20, "size": 1.0}, friction=0.3, load_path=path)
        rows = [state.summary for state in run(setup)]
        return rows[-1].work_total - rows[-11].work_total

    limit = energy(times=60)
    assert 1e-3 * tolerance < abs(energy() / limit - 1.0) <= tolerance


def test_result_says_whether_it_is_periodic(tmp_path: Path) -> None:
    for tolerance, periodic in ((0.05, True), (1e-9, False)):
        out = tmp_path / f"{periodic}.h5"
        assert solve(out, setup_of(tolerance=tolerance))[0]
        with open_result(out) as result:
            ((text, found),) = result.cycles.outcomes
        assert found is periodic
        assert text.startswith(f"load_path.1.cycle: {'' if periodic else 'not '}periodic after ")
        assert "the dissipated energy is about" in text


@pytest.mark.parametrize("stop", [13, 15])
def test_resumed_run_is_the_same(tmp_path: Path, stop: int) -> None:
    setup = setup_of()
    assert solve(tmp_path / "whole.h5", setup)[0]
    assert not solve(tmp_path / "stopped.h5", setup, stop)[0]
    assert solve(tmp_path / "stopped.h5", setup)[0]
    assert_same_result(tmp_path / "stopped.h5", tmp_path / "whole.h5")


def test_coarse_runs_of_error_bars_follow() -> None:
    setup = setup_of(solver={"error_bars": True})
    as_run, barred = list(run(setup)), list(run_with_error_bars(setup))
    assert [state.summary.stage for state in barred] == [state.summary.stage for state in as_run]
    last = barred[-1]
    assert 0.0 < last.errors.delta_x_error < abs(as_run[-3].summary.delta_x)
    history = tuple(state.summary for state in barred[:-1])
    resumed = next(run_with_error_bars(setup, barred[-2], history))
    assert resumed.errors.delta_x_error == last.errors.delta_x_error
