"""What a user reads where an increment is given up: the reason, and what would help."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from solving import DISSIMILAR, build

from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.increment.failure_reasons import (
    ADVICE,
    EASIER,
    TOO_FEW_DIGITS,
    is_far,
    why_not_pressed,
    why_not_settled,
    why_not_sheared,
)
from fretsolve.increment.grid_hierarchy import GridLevel
from fretsolve.model.load_control import LoadControl
from fretsolve.setup.problem_setup import set_up
from fretsolve.solvers.normal import SolverResult
from fretsolve.system.arrays import FloatArray

TOLERANCE, MOST = 1e-6, 50
FREE, TORQUE = (True, True, False), (True, True, True)


def result(residual: float, iterations: int = 7) -> SolverResult:
    return SolverResult(np.zeros(3), iterations, residual, 1.0, converged=False)


def level(dtype: type[np.floating] = np.float64, **grid: Any) -> GridLevel:
    setup = set_up(build(grid={"points": 16, **grid}, load_path=[{"P": 400.0}, {"Qx": 10.0}]))
    return GridLevel(setup.grid, setup.model, ThreadTeam(), dtype)


def friction_limit(of: GridLevel, carried: float) -> FloatArray:
    """Return a friction limit that carries a force (N) in all."""
    return np.full(of.grid.shape, carried / (of.grid.cell_area * of.grid.nx * of.grid.ny))


def test_few_cells_may_balance_no_load_although_the_contact_conditions_hold() -> None:
    assert why_not_pressed(result(0.5 * TOLERANCE), TOLERANCE).startswith("the imposed loads are not balanced")
    held = level()
    control, limit = LoadControl(FREE, (10.0, 0.0, 0.0)), friction_limit(held, 40.0)
    reason = why_not_sheared(held, result(0.5 * TOLERANCE), TOLERANCE, control, limit, MOST)
    assert reason.startswith("the tangential loads are not balanced")


def test_a_normal_problem_names_its_error_and_iterations() -> None:
    reason = why_not_pressed(result(3e-4, 41), TOLERANCE)
    assert "after 41 iterations" in reason
    assert "0.0003 of the normal displacement, 1e-06 is needed" in reason
    assert reason.endswith(ADVICE)


@pytest.mark.parametrize(("carried", "near"), [(10.0005, True), (10.5, False)])
def test_loads_next_to_gross_slip_are_named_as_the_reason(carried: float, near: bool) -> None:
    held = level()
    control, limit = LoadControl(FREE, (10.0, 0.0, 0.0)), friction_limit(held, carried)
    reason = why_not_sheared(held, result(3e-4), TOLERANCE, control, limit, MOST)
    assert ("within 5e-05 of gross slip" in reason) == near
    assert ("the largest slip error is 0.0003" in reason) != near


@pytest.mark.parametrize(("iterations", "advice"), [(MOST, ADVICE), (MOST - 1, EASIER)])
def test_more_iterations_are_advised_only_where_they_ran_out(iterations: int, advice: str) -> None:
    held = level()
    control, limit = LoadControl(FREE, (10.0, 0.0, 0.0)), friction_limit(held, 40.0)
    reason = why_not_sheared(held, result(3e-4, iterations), TOLERANCE, control, limit, MOST)
    assert reason.endswith(f"is needed; {advice}")


def test_single_precision_is_named_where_it_may_be_the_reason() -> None:
    for dtype, named in ((np.float32, True), (np.float64, False)):
        held = level(dtype)
        control, limit = LoadControl(FREE, (10.0, 0.0, 0.0)), friction_limit(held, 40.0)
        reason = why_not_sheared(held, result(3e-4), TOLERANCE, control, limit, MOST)
        assert (TOO_FEW_DIGITS in reason) == named


def test_a_torque_about_a_far_origin_has_too_few_digits() -> None:
    here, far = level(size=1.0), level(size=1.0, center=[2e4, 0.0])
    for held, found in ((here, False), (far, True)):
        control = LoadControl(TORQUE, (0.0, 0.0, 5.0))
        assert is_far(control, held.grid) == found
        assert not is_far(LoadControl(FREE, (0.0, 0.0, 5.0)), held.grid)  # the turn is imposed, not the torque
    reason = why_not_sheared(far, result(3e-4), TOLERANCE, control, friction_limit(far, 40.0), MOST)
    assert "an origin 2e+04 mm away" in reason


def test_a_strong_coupling_is_named_with_its_numbers() -> None:
    model = set_up(build(bodies=DISSIMILAR, friction=3.0, grid={"points": 16})).model
    reason = why_not_settled(cast(Any, SimpleNamespace(staggered_iterations=60, change=0.02)), model)
    assert "after 60 staggered iterations, by 0.02 of the normal displacement" in reason
    assert "friction times Dundurs' constant is 3 x 0.19" in reason
