"""An increment solved as a whole, directly and by the coupled Newton method, against staggered iterations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, build, solve_last

from fretsolve.contact.increment.coupled_step import coupled_problem, solve_coupled
from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.contact.increment.states import InitialState, WorkingState
from fretsolve.contact.solvers.coupled_newton import CoupledProblem
from fretsolve.elastic.rounding import LEAST_MOTION
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up

PARTS: dict[str, Any] = {
    "bodies": DISSIMILAR,
    "coupling": "full",
    "grid": {"points": 12, "size": 0.9},
    "friction": 0.2,
    "load_path": [{"P": LOAD, "Qx": 30.0, "increments": 1}],
    "solver": {"tolerance": 1e-7},
}


@pytest.fixture(scope="module")
def setup() -> ProblemSetup:
    return set_up(build(**PARTS))


def begun(setup: ProblemSetup) -> tuple[GridLevel, InitialState, WorkingState]:
    """The level of the grid, and the state of nothing loaded."""
    nothing = np.zeros(setup.grid.shape)
    shear = np.zeros((2, *nothing.shape))
    start = InitialState(nothing, shear, shear.copy(), np.zeros(6), setup.friction_on_grid().limit())
    level = GridLevel(setup.grid, setup.model, ThreadTeam(), np.float64)
    return level, start, WorkingState(nothing.copy(), np.zeros((2, *nothing.shape)), np.zeros(6))


def problem_of(
    setup: ProblemSetup, start: InitialState, work: WorkingState, precision: type[np.floating] = np.float64
) -> CoupledProblem:
    increment = setup.load_path.increment(0, ())
    tangential = increment.tangential.relative_to(start.rigid[3:])
    return coupled_problem(setup.separation(), increment, tangential, start, work, 1e-12, precision)


def assert_solved(setup: ProblemSetup, work: WorkingState) -> None:
    expected = solve_last(**PARTS)
    np.testing.assert_allclose(work.pressure, expected.fields.pressure, atol=1e-5 * expected.summary.max_pressure)
    np.testing.assert_allclose(work.shear, expected.fields.shear, atol=1e-5 * expected.summary.max_pressure)
    found = [work.rigid[0], work.rigid[3]]
    assert found == pytest.approx([expected.summary.delta_z, expected.summary.delta_x], rel=1e-5)
    assert work.pressure.sum() * setup.grid.cell_area == pytest.approx(LOAD, rel=1e-6)


def test_by_the_coupled_newton_method(setup):
    level, start, work = begun(setup)
    assert solve_coupled(level, problem_of(setup, start, work), start, work, 1e-7, 500)
    assert work.coupled_step
    assert work.iterations_normal == work.iterations_tangential > 0
    assert_solved(setup, work)


def test_without_iterations_the_tractions_stay(setup):
    level, start, work = begun(setup)
    assert not solve_coupled(level, problem_of(setup, start, work), start, work, 1e-7, 1)
    assert not work.pressure.any() and not work.shear.any()
    assert (work.coupled_step, work.gap_scale) == (False, 0.0)


def test_single_precision_counts_slip_from_tractions_whose_slip_is_known(setup):
    _, start, work = begun(setup)
    work.shear[0] = 3.0
    double = problem_of(setup, start, work)
    assert not double.shear.any() and double.elastic_slip is start.displacement
    work.elastic_slip = slip = np.full_like(start.shear, 1e-5)
    known = replace(start, displacement=start.displacement + 2e-3)
    single = problem_of(setup, known, work, np.float32)
    assert np.array_equal(single.shear, work.shear) and single.elastic_slip is slip
    assert single.motion == pytest.approx(max(LEAST_MOTION * 2e-3, 1e-12))
