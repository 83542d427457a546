"""Loads that no contact can carry, contact at the edge of the grid, and why an increment is given up."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from solving import DISSIMILAR, build

from fretsolve.contact.increment.failures import (
    ADVICE,
    EASIER,
    TOO_FEW_DIGITS,
    gross_slip_error,
    is_far,
    require_inside,
    require_supported,
    why_not_pressed,
    why_not_settled,
    why_not_sheared,
)
from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.contact.solvers.normal import SolverResult
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import ContactLostError, GridEdgeError
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.rig import Rig
from fretsolve.simulation.problem_setup import set_up
from fretsolve.system.arrays import FloatArray

GRID = Grid.from_size((8, 6), (0.8, 0.6))
FLAT = np.zeros(GRID.shape)
ALL = (True, True, True)


class TestSupport:
    @pytest.mark.parametrize("loads", [(100.0, 0.0, 0.0), (100.0, 24.9, -34.9), (0.0, 0.0, 0.0)])
    def test_loads_that_act_on_the_grid(self, loads):
        require_supported(LoadControl(ALL, loads), FLAT, GRID)

    @pytest.mark.parametrize(
        ("loads", "component"), [((100.0, 26.0, 0.0), "Mx"), ((100.0, 0.0, -36.0), "My"), ((0.0, 0.0, 1.0), "My")]
    )
    def test_loads_outside_of_the_grid(self, loads, component):
        with pytest.raises(ContactLostError) as caught:
            require_supported(LoadControl(ALL, loads), FLAT, GRID)
        assert caught.value.component == component

    def test_the_message_says_where_the_load_may_act(self):
        with pytest.raises(ContactLostError, match=r"Mx/P = 0\.3 mm.*-0\.25 to 0\.25 mm"):
            require_supported(LoadControl(ALL, (100.0, 30.0, 0.0)), FLAT, GRID)

    def test_moments_of_imposed_rotations_do_not_count(self):
        require_supported(LoadControl((True, False, False), (100.0, 1.0, 1.0)), FLAT, GRID)
        require_supported(LoadControl((False, True, True), (1e-3, 500.0, 500.0)), FLAT, GRID)

    def test_only_cells_with_material_support(self):
        half = FLAT.copy()
        half[4:] = np.inf
        require_supported(LoadControl(ALL, (100.0, 0.0, -20.0)), half, GRID)
        with pytest.raises(ContactLostError):
            require_supported(LoadControl(ALL, (100.0, 0.0, 20.0)), half, GRID)


class TestEdge:
    @pytest.mark.parametrize(("cell", "side"), [((0, 3), "-x"), ((7, 3), "+x"), ((3, 0), "-y"), ((3, 5), "+y")])
    def test_contact_at_an_edge(self, cell, side):
        pressure = FLAT.copy()
        pressure[cell] = 1.0
        with pytest.raises(GridEdgeError) as caught:
            require_inside(pressure, GRID)
        assert f"({side})" in str(caught.value)
        assert "0.8 x 0.6 mm" in str(caught.value)


class TestGrossSlip:
    def test_what_slips_and_what_is_carried(self):
        error = gross_slip_error(LoadControl(ALL, (50.0, 0.0, 3.0)), 0.8, 40.0)
        assert error.component == "Qx"
        for part in ("Qx = 50 N", "Mz = 3 N mm", "mu P = 40 N", "0.8", "delta_x and phi_z"):
            assert part in str(error)

    def test_a_rig_is_moved_by_its_actuator(self):
        rig = Rig(np.diag([0.0, 0.0, 0.0, 2e-5, 0.0, 0.0]))
        error = gross_slip_error(LoadControl(ALL, (50.0, 0.0, 3.0)), 0.8, 40.0, rig=rig)
        assert str(error).endswith("or impose actuator_x and phi_z instead")

    def test_nothing_is_carried(self):
        assert "none of it" in str(gross_slip_error(LoadControl(ALL, (0.0, 2.0, 0.0)), 0.0, 0.0))


def test_a_grid_without_material_bears_no_imposed_load():
    for load in (0.0, 100.0):
        with pytest.raises(ContactLostError, match="nowhere face each other") as caught:
            require_supported(LoadControl(ALL, (load, 0.0, 0.0)), np.full(GRID.shape, np.inf), GRID)
        assert caught.value.component == "P"
    require_supported(LoadControl((False, False, False), (0.0, 0.0, 0.0)), np.full(GRID.shape, np.inf), GRID)


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
    reason = why_not_sheared(held.tangential, held.grid, result(0.5 * TOLERANCE), TOLERANCE, control, limit, MOST)
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
    reason = why_not_sheared(held.tangential, held.grid, result(3e-4), TOLERANCE, control, limit, MOST)
    assert ("within 5e-05 of gross slip" in reason) == near
    assert ("the largest slip error is 0.0003" in reason) != near


@pytest.mark.parametrize(("iterations", "advice"), [(MOST, ADVICE), (MOST - 1, EASIER)])
def test_more_iterations_are_advised_only_where_they_ran_out(iterations: int, advice: str) -> None:
    held = level()
    control, limit = LoadControl(FREE, (10.0, 0.0, 0.0)), friction_limit(held, 40.0)
    reason = why_not_sheared(held.tangential, held.grid, result(3e-4, iterations), TOLERANCE, control, limit, MOST)
    assert reason.endswith(f"is needed; {advice}")


def test_single_precision_is_named_where_it_may_be_the_reason() -> None:
    for dtype, named in ((np.float32, True), (np.float64, False)):
        held = level(dtype)
        control, limit = LoadControl(FREE, (10.0, 0.0, 0.0)), friction_limit(held, 40.0)
        reason = why_not_sheared(held.tangential, held.grid, result(3e-4), TOLERANCE, control, limit, MOST)
        assert (TOO_FEW_DIGITS in reason) == named


def test_a_torque_about_a_far_origin_has_too_few_digits() -> None:
    here, far = level(size=1.0), level(size=1.0, center=[2e4, 0.0])
    for held, found in ((here, False), (far, True)):
        control = LoadControl(TORQUE, (0.0, 0.0, 5.0))
        assert is_far(control, held.grid) == found
        assert not is_far(LoadControl(FREE, (0.0, 0.0, 5.0)), held.grid)  # the turn is imposed, not the torque
    reason = why_not_sheared(
        far.tangential, far.grid, result(3e-4), TOLERANCE, control, friction_limit(far, 40.0), MOST
    )
    assert "an origin 2e+04 mm away" in reason


def test_a_strong_coupling_is_named_with_its_numbers() -> None:
    model = set_up(build(bodies=DISSIMILAR, friction=3.0, grid={"points": 16})).model
    reason = why_not_settled(cast(Any, SimpleNamespace(staggered_iterations=60, change=0.02)), model)
    assert "after 60 staggered iterations, by 0.02 of the normal displacement" in reason
    assert "friction times Dundurs' constant is 3 x 0.19" in reason
